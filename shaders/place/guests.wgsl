// Cuts the large ones among the spheres that the host placed.

@group(0) @binding(BIND_PROJECTED) var<storage, read_write> projected: array<vec4<i32>>;

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let n = place_in_block(group, index);
    if (n < block_pass.count) {
        let f = projected[n];
        if (cut(block_pass.first + n, rectangle(f.x, f.y, bitcast<f32>(f.z)))) {
            projected[n].z = bitcast<i32>(-bitcast<f32>(f.z));
        }
    }
}
