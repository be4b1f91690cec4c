// One invocation per case, in workgroups like those of the kernels. Cases come from a buffer: of constants a compiler
// would know the answers.
@group(0) @binding(20) var<storage, read> cases: array<f32>;
@group(0) @binding(21) var<storage, read_write> answers: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x < view.spheres) {
        answer(id.x);
    }
}
