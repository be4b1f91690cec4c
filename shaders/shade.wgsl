// What every shading needs of the surface.

// Unit normal at a hit, in the canonical camera, against the ray.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    let s = sphere_for(ray, hit.id);
    return normal_at(ray, s, hit.t / s.scale);
}

// A direction of the canonical camera in world space.
fn to_world(a: vec3<f32>) -> vec3<f32> {
    return a.x * view.right.xyz + a.y * view.up.xyz + a.z * view.back.xyz;
}
