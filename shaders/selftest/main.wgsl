// One invocation per case, in workgroups of the kernels' size. Cases are read from a buffer, because a compiler would
// fold constants. Word is the type of the test's numbers.
@group(0) @binding(BIND_CASES) var<storage, read> cases: array<Word>;
@group(0) @binding(BIND_ANSWERS) var<storage, read_write> answers: array<Word>;

@compute @workgroup_size(GROUP)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x < view.spheres) {
        answer(id.x);
    }
}
