// Every invocation loads every record itself, which works on every adapter. A workgroup is a tile of 8 x 8 pixels, or a
// group of given rays.
@compute @workgroup_size(GROUP / ROWS)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    render(group, index);
}

fn all_of_subgroup(yes: bool) -> bool {
    return yes;
}

fn leads() -> bool {
    return true;
}

fn of_leader(v: vec4<u32>) -> vec4<u32> {
    return v;
}
