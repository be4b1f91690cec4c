// Shaded colour, linear RGB; the background on a miss.
@group(0) @binding(6) var<storage, read_write> frame_color: array<f32>;

fn write_color(pixel: u32, ray: Ray, hit: Hit) {
    var c = view.background.rgb;
    if (hit.id != NONE) {
        c = shade(ray, hit);
    }
    frame_color[3u * pixel] = c.r;
    frame_color[3u * pixel + 1u] = c.g;
    frame_color[3u * pixel + 2u] = c.b;
}
