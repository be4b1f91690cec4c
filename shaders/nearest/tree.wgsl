// What every ray of the workgroup has still to visit: bits of where it comes in, and a link. Memory of the workgroup,
// because software adapters turn an array of an invocation's own into a chain of comparisons.
var<workgroup> waiting: array<vec2<u32>, GROUP * STACK>;

// The last thing put aside that the hit has not put out of reach since; NOWHERE when there is none. depth says how
// many wait.
fn resume(depth: ptr<function, u32>, reach: f32) -> u32 {
    while (*depth > 0u) {
        *depth -= 1u;
        let next = waiting[*depth * GROUP + seat];
        if (bitcast<f32>(next.x) <= reach) {
            return next.y;
        }
    }
    return NOWHERE;
}

// The closest hit among the spheres of a tree: the nearer box first, and none behind the hit that is already there. A
// box as near as the hit is still opened, for the lower id may be in it.
fn nearest(ray: Ray) -> Hit {
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
            if (far < MISS && far <= reach(hit)) {
                waiting[depth * GROUP + seat] = vec2<u32>(bitcast<u32>(far), select(node.low_b.w, node.low_a.w, swap));
                depth++;
            }
            if (near < MISS && near <= reach(hit)) {
                link = select(node.low_a.w, node.low_b.w, swap);
            } else {
                link = resume(&depth, reach(hit));
            }
        }
        if (link == NOWHERE) {
            break;
        }
        let first = link & FIRST;
        let end = first + ((link >> 27u) & 15u);
        for (var k = first; k < end; k++) {
            hit = meet(hit, ray, order[k]);
        }
        link = resume(&depth, reach(hit));
    }
    return hit;
}
