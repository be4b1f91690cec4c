// The rays from the hits of a frame: what main/sky.wgsl traces, and picture/sky_sums.wgsl adds up.

struct Sky {
    first: u32,        // pixel of the band, and one past the last
    end: u32,
    rays: u32,         // of each pixel toward the sky
    lights: u32,       // and toward lights
    turns: u32,        // of the directions toward the sky, a power of two
    seed: u32,
    interleaved: u32,  // 1: the place of a pixel chooses its turn, 0: a hash does
    groups: u32,       // workgroups in a row of the dispatch
    sure_limit: f32,   // of rays toward the sky
    limit: f32,
    unit: f32,         // the frame's unit in the unit of the tree; 0 where ways from the eye are of no use
    steps: u32,        // of the tree in an invocation; beyond them the host traces the pixel
    eye: vec3<i32>,    // on the grid of places: whole steps, and the rest
    first_ray: u32,    // the first ray of each pixel in this dispatch, and one past the last
    eye_rest: vec3<f32>,
    end_ray: u32,
}

@group(0) @binding(BIND_SKY) var<uniform> sky: Sky;
// Two vectors each: a direction and the reciprocals of its components, for all turns of the sky and then for the
// lights. A light that is not infinitely far has its place instead, as steps and a rest, and the fourth number of the
// first vector is 1.
@group(0) @binding(BIND_DIRECTIONS) var<storage, read> directions: array<vec4<u32>>;
@group(0) @binding(BIND_OPEN) var<storage, read_write> open: array<u32>;

// The turn of the directions toward the sky at a pixel of the full frame.
fn turn_of(at: vec2<u32>) -> u32 {
    let hash = pcg4d(vec4<u32>(at, 0u, sky.seed)).w & (sky.turns - 1u);
    return select(hash, (at.y & 7u) * 8u + (at.x & 7u), sky.interleaved == 1u);
}
