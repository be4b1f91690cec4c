// Converts a direction from the canonical camera to world space.
fn to_world(a: vec3<f32>) -> vec3<f32> {
    return a.x * view.right.xyz + a.y * view.up.xyz + a.z * view.back.xyz;
}

// Unit world normal, facing the ray's origin; zero on a miss.
fn world_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    var n = vec3<f32>(0.0, 0.0, 0.0);
    if (hit.id != NONE) {
        n = to_world(surface_normal(ray, hit));
    }
    return n;
}
