// The invocations of a subgroup share their loads. A workgroup is a tile of 8 x 8 pixels; subgroups of 8 invocations are
// its rows.
var<private> lane: u32;
var<private> lanes: u32;

@compute @workgroup_size(GROUP / ROWS)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
    @builtin(subgroup_invocation_id) subgroup_lane: u32,
    @builtin(subgroup_size) subgroup_lanes: u32,
) {
    lane = subgroup_lane;
    lanes = subgroup_lanes;
    render(group, index);
}

fn all_of_subgroup(yes: bool) -> bool {
    return subgroupAll(yes);
}

// What all invocations of a subgroup read is loaded by one of them, because software adapters load lane by lane.
fn leads() -> bool {
    return lane == 0u;
}

// Its value.
fn of_leader(v: vec4<u32>) -> vec4<u32> {
    return subgroupBroadcast(v, 0u);
}
