// Colour per sphere: linear RGB, three numbers each.
@group(0) @binding(BIND_COLORS) var<storage, read> colors: array<f32>;

fn sphere_color(id: u32) -> vec3<f32> {
    return vec3<f32>(colors[3u * id], colors[3u * id + 1u], colors[3u * id + 2u]);
}
