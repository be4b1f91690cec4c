// frame/t.wgsl in a better arithmetic: t is the sum of two f32.
@group(0) @binding(4) var<storage, read_write> frame_t: array<f32>;
@group(0) @binding(16) var<storage, read_write> frame_t_low: array<f32>;

fn write_t(pixel: u32, hit: Hit) {
    frame_t[pixel] = high(hit.t);
    frame_t_low[pixel] = low(hit.t);
}
