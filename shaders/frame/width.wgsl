// How far the depth may be from the true one, frame's unit; 0 on a miss.
@group(0) @binding(15) var<storage, read_write> frame_width: array<f32>;

fn write_width(pixel: u32, width: f32) {
    frame_width[pixel] = width;
}
