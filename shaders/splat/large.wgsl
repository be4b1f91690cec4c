// A piece of a large sphere in a workgroup.

@group(0) @binding(BIND_PIECES) var<storage, read> pieces: array<vec2<u32>>;

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let n = group.y * block_pass.groups + group.x;
    if (n >= block_pass.pieces) {
        return;
    }
    let piece = pieces[n];
    let place = piece.x - block_pass.first;
    if (place >= block_pass.count) {
        return;
    }
    let f = projected_of(uncut(projected[place]));
    let whole = rectangle(f.x, f.y, f.rho);
    let side = PIECE << (piece.y >> 30u);
    let corner = vec2<i32>(vec2<u32>(piece.y & 0x7fffu, (piece.y >> 15u) & 0x7fffu) * side);
    let r = in_band(vec4<i32>(max(whole.xy, corner), min(whole.zw, corner + vec2<i32>(i32(side) - 1))));
    let c = frame_constants();
    // Squares of 8 x 8 pixels, one for each invocation.
    let own = r.xy + vec2<i32>(vec2<u32>(index % 8u, index / 8u));
    for (var row = own.y; row <= r.w; row += 8) {
        for (var column = own.x; column <= r.z; column += 8) {
            splat(c, f, piece.x, vec2<u32>(vec2<i32>(column, row)));
        }
    }
}
