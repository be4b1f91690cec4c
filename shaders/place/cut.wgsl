// Large spheres in pieces.

// The slot of a large sphere, and a square of pixels of the image, PIECE << s along a side: column and row among such squares in 15
// bits each, then s.
@group(0) @binding(BIND_PIECES) var<storage, read_write> pieces: array<vec2<u32>>;

// Cuts the rectangle of a large sphere into pieces; whether it is large.
fn cut(slot: u32, r: vec4<i32>) -> bool {
    if (is_small(r)) {
        return false;
    }
    // The finest squares of which there are at most CUT.
    var s = 0u;
    var corner = vec2<u32>(r.xy) / PIECE;
    var last = vec2<u32>(r.zw) / PIECE;
    while (s < COARSEST && last.x - corner.x >= CUT / (last.y - corner.y + 1u)) {
        s++;
        corner >>= vec2<u32>(1u);
        last >>= vec2<u32>(1u);
    }
    let across = last - corner + vec2<u32>(1u);
    if (across.x > CUT / across.y || any(last > vec2<u32>(0x7fffu))) {
        atomicAdd(&summary[SUMMARY_MORE], 1u);
        return true;
    }
    let count = across.x * across.y;
    let first = atomicAdd(&summary[SUMMARY_PIECES], count);
    // The sum may pass 2^32: it has a second word.
    if (first + count < first) {
        atomicAdd(&summary[SUMMARY_MORE], 1u);
    }
    for (var k = 0u; k < count && first + k < PIECES; k++) {
        let piece = corner + vec2<u32>(k % across.x, k / across.x);
        pieces[first + k] = vec2<u32>(slot, piece.x | (piece.y << 15u) | (s << 30u));
    }
    return true;
}
