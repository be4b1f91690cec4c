// Two colours per sphere, of its surface and of its face: linear RGB, three numbers each.
@group(0) @binding(BIND_COLORS) var<storage, read> colors: array<f32>;

fn sphere_color(id: u32) -> vec3<f32> {
    let at = 6u * id + select(0u, 3u, winner == FACE);
    return vec3<f32>(colors[at], colors[at + 1u], colors[at + 2u]);
}
