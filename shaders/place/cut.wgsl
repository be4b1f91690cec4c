// Large spheres in pieces.

// The slot of a large sphere, and the number of a piece of its rectangle.
@group(0) @binding(BIND_PIECES) var<storage, read_write> pieces: array<vec2<u32>>;

// Cuts the rectangle of a large sphere into pieces.
fn cut(slot: u32, r: vec4<i32>) {
    if (is_small(r)) {
        return;
    }
    let across = vec2<u32>(r.zw - r.xy) / PIECE + vec2<u32>(1u);
    let count = across.x * across.y;
    let first = atomicAdd(&summary[SUMMARY_PIECES], count);
    for (var k = 0u; k < count && first + k < PIECES; k++) {
        pieces[first + k] = vec2<u32>(slot, k);
    }
}
