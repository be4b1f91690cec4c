// Large spheres in pieces.

// The slot of a large sphere, and the column and row of a piece: a square of PIECE x PIECE pixels of the image, in 16 bits each.
@group(0) @binding(BIND_PIECES) var<storage, read_write> pieces: array<vec2<u32>>;

// Cuts the rectangle of a large sphere into pieces; whether it is large.
fn cut(slot: u32, r: vec4<i32>) -> bool {
    if (is_small(r)) {
        return false;
    }
    let corner = vec2<u32>(r.xy) / PIECE;
    let across = vec2<u32>(r.zw) / PIECE - corner + vec2<u32>(1u);
    let count = across.x * across.y;
    let first = atomicAdd(&summary[SUMMARY_PIECES], count);
    for (var k = 0u; k < count && first + k < PIECES; k++) {
        let piece = corner + vec2<u32>(k % across.x, k / across.x);
        pieces[first + k] = vec2<u32>(slot, piece.x | (piece.y << 16u));
    }
    return true;
}
