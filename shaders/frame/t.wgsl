// t along the viewing ray, in the frame's unit: distance, depth and position follow from it on the host.
@group(0) @binding(4) var<storage, read_write> frame_t: array<f32>;

fn write_t(pixel: u32, hit: Hit) {
    frame_t[pixel] = hit.t;
}
