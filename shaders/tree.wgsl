// The boxes of a tree over the spheres, padded by the host so that no hit is outside of them, and a ray among them.
const STACK: u32 = 32u;              // nodes that may wait; the host keeps every tree as shallow
const IS_LEAF: u32 = 0x80000000u;    // of a link: to a leaf; then 4 bits say how many spheres, 27 which is the first
const FIRST: u32 = 0x07ffffffu;
const NOWHERE: u32 = 0xffffffffu;    // a link to nothing
const LEAST: f32 = 2.3283064e-10;    // 2^-32: a smaller component of a direction is taken for this; nothing is divided by 0

// Bits of two boxes' corners, and in the fourth number of the low ones where they lead. Bits, because a link that
// passes as an f32 may be flushed.
struct Node {
    low_a: vec4<u32>,
    high_a: vec4<u32>,
    low_b: vec4<u32>,
    high_b: vec4<u32>,
}

@group(0) @binding(17) var<storage, read> nodes: array<Node>;
@group(0) @binding(18) var<storage, read> order: array<u32>;

// A ray as the boxes see it: origin, and one over each component of the direction.
struct Slabs {
    origin: vec3<f32>,
    inverse: vec3<f32>,
}

fn slabs_of(direction: vec3<f32>, origin: vec3<f32>) -> Slabs {
    let least = select(vec3<f32>(LEAST), vec3<f32>(-LEAST), direction < vec3<f32>(0.0));
    return Slabs(origin, 1.0 / select(direction, least, abs(direction) < vec3<f32>(LEAST)));
}

// Where the ray comes into the box, at least 0; MISS where it does not.
fn entry(slabs: Slabs, low: vec4<u32>, high: vec4<u32>) -> f32 {
    let a = (bitcast<vec3<f32>>(low.xyz) - slabs.origin) * slabs.inverse;
    let b = (bitcast<vec3<f32>>(high.xyz) - slabs.origin) * slabs.inverse;
    let first = min(a, b);
    let last = max(a, b);
    let near = max(max(first.x, first.y), max(first.z, 0.0));
    let far = min(min(last.x, last.y), last.z);
    return select(MISS, near, near <= far);
}
