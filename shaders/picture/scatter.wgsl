// Writes words that the host decided into a buffer.

// The place of each word, and the word.
@group(0) @binding(BIND_PATCHES) var<storage, read> patches: array<vec2<u32>>;
@group(0) @binding(BIND_PATCHED) var<storage, read_write> patched: array<u32>;

@compute @workgroup_size(GROUP)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    // Whole workgroups: the last patches are repeated.
    let patch_at = patches[group.x * GROUP + index];
    patched[patch_at.x] = patch_at.y;
}
