// Large spheres in pieces.

// The slot of a large sphere, and a square of pixels of the image, PIECE << s along a side: column and row among such squares in 15
// bits each, then s.
@group(0) @binding(BIND_PIECES) var<storage, read_write> pieces: array<vec2<u32>>;

// Columns and rows of the squares that a rectangle reaches.
fn squares(r: vec4<i32>, s: u32) -> vec2<u32> {
    let side = vec2<u32>(PIECE << s);
    return vec2<u32>(r.zw) / side - vec2<u32>(r.xy) / side + vec2<u32>(1u);
}

// Their product may be more than a u32.
fn are_too_many(across: vec2<u32>) -> bool {
    return across.x > CUT / across.y;
}

// Cuts the rectangle of a large sphere into pieces; whether it is large.
fn cut(slot: u32, r: vec4<i32>) -> bool {
    if (is_small(r)) {
        return false;
    }
    // The finest squares that are at most CUT in number.
    var s = 0u;
    while (s < COARSEST && are_too_many(squares(r, s))) {
        s++;
    }
    let corner = vec2<u32>(r.xy) / (PIECE << s);
    let across = squares(r, s);
    if (are_too_many(across) || any(corner + across > vec2<u32>(0x8000u))) {
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
