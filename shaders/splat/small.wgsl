// A sphere of few pixels in one invocation.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let n = place_in_block(group, index);
    if (n >= part.count) {
        return;
    }
    let f = projected_of(projected[n]);
    if (f.x == NOWHERE) {
        return;
    }
    let all = rectangle(f.x, f.y, f.rho);
    if (!is_small(all)) {
        return;
    }
    let r = in_band(all);
    let slot = part.first + n;
    let c = frame_constants();
    for (var row = r.y; row <= r.w; row++) {
        for (var column = r.x; column <= r.z; column++) {
            splat(c, f, slot, vec2<u32>(vec2<i32>(column, row)));
        }
    }
}
