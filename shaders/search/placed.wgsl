// The spheres of a tree, in its order and its unit; places are whole steps of a grid and a rest.

struct PlacedSphere {
    steps: vec3<i32>,
    radius: f32,
    rest: vec3<f32>,
}

const PLACED_ROW_BITS: u32 = 11u; // a row of the texture holds 2^11 spheres

@group(0) @binding(BIND_PLACED) var placed: texture_2d<u32>; // two texels each

fn placed_at(n: u32) -> PlacedSphere {
    let first = vec2<u32>((n << 1u) & ((2u << PLACED_ROW_BITS) - 1u), n >> PLACED_ROW_BITS);
    let a = textureLoad(placed, first, 0);
    let b = textureLoad(placed, first + vec2<u32>(1u, 0u), 0);
    return PlacedSphere(bitcast<vec3<i32>>(a.xyz), bitcast<f32>(a.w), bitcast<vec3<f32>>(b.xyz));
}
