// Lists the pixels that are not proved, without a slot: some have no projected sphere near.

@group(0) @binding(BIND_FRAME_ID) var<storage, read> frame_id: array<u32>;

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let at = pixel_at(tile, index);
    if (!in_crop(at)) {
        return;
    }
    if (frame_id[pixel_index(at)] == UNSURE) {
        list_for_host(pixel_index(at), NONE);
    }
}
