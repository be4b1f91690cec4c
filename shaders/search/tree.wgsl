// The traversal of a complete tree of bounding boxes over the spheres, eight children to a node, which lie in spheres in
// its order. The host pads the rays so that they enter every box of a hit (docs/certificate.md, section 9b).
const LEVELS: u32 = 10u;           // the most levels of nodes
const FIRSTS: u32 = 0x49249249u;   // its lowest 3 l bits are the place of the first node of level l, (8^l - 1)/7
const LANE: u32 = 7u;              // the bits of a key that tell the child
const NEVER: u32 = 0xffffffffu;    // the key of a child that the ray does not enter
const NOWHERE: u32 = 0xffffffffu;  // a level beyond all others
const ROW_BITS: u32 = 10u;         // a row of the texture holds 2^10 nodes

// Eight boxes on a grid of 8 bits.
struct Node {
    origin: vec3<f32>,             // least x, y, z of all
    grid: u32,                     // from the lowest bits: the exponents of its steps in x, y, z; which children exist
    planes: array<vec2<u32>, 6>,   // steps from the origin, one byte for each child: least x, y, z, greatest x, y, z
}

// A ray in the tree's unit.
struct BoxRay {
    enter: vec4<f32>,              // a point of the line, moved ahead by the padding; w unused in all three
    leave: vec4<f32>,              // the same moved back
    inverse: vec4<f32>,            // of the direction's components
}

@group(0) @binding(BIND_NODES) var nodes: texture_2d<u32>;  // four texels each

fn node_at(n: u32) -> Node {
    let first = vec2<u32>((n << 2u) & ((4u << ROW_BITS) - 1u), n >> ROW_BITS);
    let a = textureLoad(nodes, first, 0);
    let b = textureLoad(nodes, first + vec2<u32>(1u, 0u), 0);
    let c = textureLoad(nodes, first + vec2<u32>(2u, 0u), 0);
    let d = textureLoad(nodes, first + vec2<u32>(3u, 0u), 0);
    return Node(bitcast<vec3<f32>>(a.xyz), a.w, array<vec2<u32>, 6>(b.xy, b.zw, c.xy, c.zw, d.xy, d.zw));
}

// The children that wait, of one node of each level for each ray of the workgroup: four bits each, the nearest lowest, and
// t where the ray enters the nearest. In workgroup memory, because software adapters compile a private array into a
// chain of comparisons.
var<workgroup> waiting: array<vec2<u32>, GROUP * LEVELS>;

// A node or a sphere of the tree.
struct Position {
    level: u32,
    place: u32, // in its level
    open: u32,  // the levels whose children wait, one bit each
}

// Four numbers of a byte each.
fn bytes(word: u32) -> vec4<f32> {
    return vec4<f32>(vec4<i32>((vec4<u32>(word) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u)));
}

// The keys of four children: t where the ray enters the box, the last bits replaced by the number of the child.
fn keys(near: vec4<f32>, far: vec4<f32>, first: u32, exists: u32) -> vec4<u32> {
    let lanes = vec4<u32>(0u, 1u, 2u, 3u);
    let entered = (near <= far) & (((vec4<u32>(exists) >> lanes) & vec4<u32>(1u)) == vec4<u32>(1u));
    return select(vec4<u32>(NEVER), (bitcast<vec4<u32>>(near) & vec4<u32>(~LANE)) | (lanes + first), entered);
}

// A child that waits: its number and a bit that tells it from none.
fn waits(key: u32) -> u32 {
    return select(0u, (key & LANE) | 8u, key != NEVER);
}

// The nearest child that waits and is not behind the hit; the others of a level are farther.
fn resume(at: Position, limit: f32) -> Position {
    var open = at.open;
    while (open != 0u) {
        let level = firstLeadingBit(open);
        let slot = level * GROUP + local_index;
        let next = waiting[slot];
        let left = next.x >> 4u;
        let near = bitcast<f32>(next.y) <= limit;
        if (!near || left == 0u) {
            open &= ~(1u << level);
        }
        if (near) {
            waiting[slot].x = left;
            let parent = at.place >> (3u * (at.level - level));
            return Position(level + 1u, 8u * parent + (next.x & LANE), open);
        }
    }
    return Position(NOWHERE, 0u, 0u);
}

// The nearest child of a node that the ray enters before `limit`; the others wait.
fn descend(at: Position, ray: BoxRay, limit: f32) -> Position {
    let node = node_at((FIRSTS & ((1u << (3u * at.level)) - 1u)) + at.place);
    let exponents = vec3<u32>(node.grid, node.grid >> 8u, node.grid >> 16u) & vec3<u32>(255u);
    let step = bitcast<vec3<f32>>(exponents << vec3<u32>(23u)) * ray.inverse.xyz;
    let enter = (node.origin - ray.enter.xyz) * ray.inverse.xyz;
    let leave = (node.origin - ray.leave.xyz) * ray.inverse.xyz;
    let back = ray.inverse.xyz < vec3<f32>(0.0);
    let near_x = select(node.planes[0], node.planes[3], back.x);
    let near_y = select(node.planes[1], node.planes[4], back.y);
    let near_z = select(node.planes[2], node.planes[5], back.z);
    let far_x = select(node.planes[3], node.planes[0], back.x);
    let far_y = select(node.planes[4], node.planes[1], back.y);
    let far_z = select(node.planes[5], node.planes[2], back.z);
    let none = vec4<f32>(0.0);
    let last = vec4<f32>(limit);
    let low = keys(
        max(max(bytes(near_x.x) * step.x + enter.x, bytes(near_y.x) * step.y + enter.y), max(bytes(near_z.x) * step.z + enter.z, none)),
        min(min(bytes(far_x.x) * step.x + leave.x, bytes(far_y.x) * step.y + leave.y), min(bytes(far_z.x) * step.z + leave.z, last)),
        0u, node.grid >> 24u,
    );
    let high = keys(
        max(max(bytes(near_x.y) * step.x + enter.x, bytes(near_y.y) * step.y + enter.y), max(bytes(near_z.y) * step.z + enter.z, none)),
        min(min(bytes(far_x.y) * step.x + leave.x, bytes(far_y.y) * step.y + leave.y), min(bytes(far_z.y) * step.z + leave.z, last)),
        4u, node.grid >> 28u,
    );
    // The keys in ascending order, by a network of 19 comparisons (Knuth 5.3.4).
    let a = vec4<u32>(low.xy, high.xy);
    let b = vec4<u32>(low.zw, high.zw);
    let c = min(a, b);
    let d = max(a, b);
    let e = vec4<u32>(c.xy, d.xy);
    let f = vec4<u32>(c.zw, d.zw);
    let g = min(e, f);
    let h = max(e, f);
    let i = vec4<u32>(g.x, g.z, h.x, h.z);
    let j = vec4<u32>(g.y, g.w, h.y, h.w);
    let even = min(i, j);
    let odd = max(i, j);
    let k = min(vec2<u32>(even.y, odd.y), vec2<u32>(even.z, odd.z));
    let l = max(vec2<u32>(even.y, odd.y), vec2<u32>(even.z, odd.z));
    let m = min(vec2<u32>(odd.x, k.y), vec2<u32>(l.x, even.w));
    let n = max(vec2<u32>(odd.x, k.y), vec2<u32>(l.x, even.w));
    let o = min(vec3<u32>(m.x, m.y, l.y), vec3<u32>(k.x, n.x, n.y));
    let p = max(vec3<u32>(m.x, m.y, l.y), vec3<u32>(k.x, n.x, n.y));
    if (even.x == NEVER) {
        return resume(at, limit);
    }
    var open = at.open;
    if (o.x != NEVER) {
        let order = waits(o.x) | (waits(p.x) << 4u) | (waits(o.y) << 8u) | (waits(p.y) << 12u)
            | (waits(o.z) << 16u) | (waits(p.z) << 20u) | (waits(odd.w) << 24u);
        waiting[at.level * GROUP + local_index] = vec2<u32>(order, o.x & ~LANE);
        open |= 1u << at.level;
    }
    return Position(at.level + 1u, 8u * at.place + (even.x & LANE), open);
}

// The level of the spheres: the lowest nodes have eight of them, and there are at least two levels of nodes.
fn level_of_spheres() -> u32 {
    var level = 2u;
    for (var blocks = (view.spheres - 1u) >> 6u; blocks > 0u; blocks >>= 3u) {
        level++;
    }
    return level;
}
