// One invocation per viewing ray; a workgroup is a tile of 8 x 8 pixels.
@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) tile: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    render(tile, index);
}
