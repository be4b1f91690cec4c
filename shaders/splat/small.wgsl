// A sphere of few pixels in one invocation.
@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let n = place_in_block(group, index);
    if (n >= block_pass.count) {
        return;
    }
    let record = projected[n];
    if (record.x == NOWHERE || is_cut(record)) {
        return;
    }
    let f = projected_of(record);
    let r = in_band(rectangle(f.x, f.y, f.rho));
    let slot = block_pass.first + n;
    let c = frame_constants();
    for (var row = r.y; row <= r.w; row++) {
        for (var column = r.x; column <= r.z; column++) {
            splat(c, f, slot, vec2<u32>(vec2<i32>(column, row)));
        }
    }
}
