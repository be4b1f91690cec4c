// Converts a direction from the canonical camera to world space.
fn to_world(a: vec3<f32>) -> vec3<f32> {
    return a.x * view.right.xyz + a.y * view.up.xyz + a.z * view.back.xyz;
}
