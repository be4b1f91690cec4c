// The closest hit by a tree of bounding boxes over the spheres. The host pads the boxes so that they contain every hit.
const STACK: u32 = 32u;              // depth of the stack; the host builds no deeper tree
const IS_LEAF: u32 = 0x80000000u;    // marks a link to a leaf: 4 bits for the number of spheres, 27 for the first
const FIRST: u32 = 0x07ffffffu;
const NOWHERE: u32 = 0xffffffffu;    // a link to nothing
const LEAST: f32 = 2.3283064e-10;    // 2^-32: replaces smaller components of a direction, to avoid a division by 0

// The corners of two boxes as bits, with the links to their children in the w components of the low corners. Bits,
// because a link that is loaded as an f32 may be flushed to zero.
struct Node {
    low_a: vec4<u32>,
    high_a: vec4<u32>,
    low_b: vec4<u32>,
    high_b: vec4<u32>,
}

@group(0) @binding(BIND_NODES) var<storage, read> nodes: array<Node>;
@group(0) @binding(BIND_ORDER) var<storage, read> order: array<u32>;

// A ray for slab tests: the origin, and the reciprocals of the direction's components.
struct Slabs {
    origin: vec3<f32>,
    inverse: vec3<f32>,
}

fn slabs_of(direction: vec3<f32>, origin: vec3<f32>) -> Slabs {
    let least = select(vec3<f32>(LEAST), vec3<f32>(-LEAST), direction < vec3<f32>(0.0));
    return Slabs(origin, 1.0 / select(direction, least, abs(direction) < vec3<f32>(LEAST)));
}

// t where the ray enters the box, at least 0; MISS if it does not.
fn entry(slabs: Slabs, low: vec4<u32>, high: vec4<u32>) -> f32 {
    let a = (bitcast<vec3<f32>>(low.xyz) - slabs.origin) * slabs.inverse;
    let b = (bitcast<vec3<f32>>(high.xyz) - slabs.origin) * slabs.inverse;
    let first = min(a, b);
    let last = max(a, b);
    let near = max(max(first.x, first.y), max(first.z, 0.0));
    let far = min(min(last.x, last.y), last.z);
    return select(MISS, near, near <= far);
}

// The traversal stacks of the workgroup's rays: the bits of the entry t, and a link. In workgroup memory, because
// software adapters compile a private array into a chain of comparisons.
var<workgroup> waiting: array<vec2<u32>, GROUP * STACK>;

// Pops the last link whose box is not behind the current hit; NOWHERE if there is none. depth is the number of entries
// on the stack.
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

// The closest hit among the spheres of a tree. The nearer box is visited first, and boxes behind the current hit are
// skipped. A box as near as the hit is still visited, because it may contain a lower id. t is rounded to f32 for this
// comparison; the boxes' padding is larger than that error.
fn nearest(ray: Ray, group: vec3<u32>) -> Hit {
    let slabs = slabs_of(given.direction.xyz, given.origin.xyz);
    var hit = no_hit();
    var depth = 0u;
    var link = 0u;
    loop {
        // Descends to the next leaf; NOWHERE has the leaf bit too.
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
