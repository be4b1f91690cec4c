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

@group(0) @binding(BIND_NODES) var<storage, read> nodes: array<Node>;
@group(0) @binding(BIND_ORDER) var<storage, read> order: array<u32>;

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

// What every ray of the workgroup has still to visit: bits of where it comes in, and a link. Memory of the workgroup,
// because software adapters turn an array of an invocation's own into a chain of comparisons.
var<workgroup> waiting: array<vec2<u32>, GROUP * STACK>;

// The last thing put aside that the hit has not put out of reach since; NOWHERE when there is none. depth says how
// many wait.
fn resume(depth: ptr<function, u32>, reach: f32) -> u32 {
    while (*depth > 0u) {
        *depth -= 1u;
        let next = waiting[*depth * GROUP + local_index];
        if (bitcast<f32>(next.x) <= reach) {
            return next.y;
        }
    }
    return NOWHERE;
}

// The closest hit among the spheres of a tree: the nearer box first, and none behind the hit that is already there. A
// box as near as the hit is still opened, for the lower id may be in it. t is rounded to f32 for this: the boxes' padding is
// larger than that.
fn nearest(ray: Ray, group: vec3<u32>) -> Hit {
    let slabs = slabs_of(given.direction.xyz, given.origin.xyz);
    var hit = no_hit();
    var depth = 0u;
    var link = 0u;
    loop {
        // Down to the next leaf: NOWHERE has a leaf's bit too.
        while ((link & IS_LEAF) == 0u) {
            let node = nodes[link];
            let a = entry(slabs, node.low_a, node.high_a);
            let b = entry(slabs, node.low_b, node.high_b);
            let swap = b < a;
            let near = select(a, b, swap);
            let far = select(b, a, swap);
            if (far < MISS && far <= to_hi(hit.t)) {
                waiting[depth * GROUP + local_index] = vec2<u32>(bitcast<u32>(far), select(node.low_b.w, node.low_a.w, swap));
                depth++;
            }
            if (near < MISS && near <= to_hi(hit.t)) {
                link = select(node.low_a.w, node.low_b.w, swap);
            } else {
                link = resume(&depth, to_hi(hit.t));
            }
        }
        if (link == NOWHERE) {
            break;
        }
        let first = link & FIRST;
        hit = test_chunk(ray, hit, first, (link >> 27u) & 15u);
        link = resume(&depth, to_hi(hit.t));
    }
    return hit;
}

alias Searcher = Ray;
alias Best = Hit;

fn load(n: u32) -> Record {
    return record_at(order[n]);
}

fn test(ray: Ray, hit: Hit, r: Record, n: u32) -> Hit {
    return closer_hit_any_order(hit, ray, sphere_of(r), r.id);
}

fn record_of(hit: Hit) -> Record {
    return record_at(hit.id);
}
