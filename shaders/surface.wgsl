// Unit normal at a hit, in the canonical camera, against the ray.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    let s = sphere_for(ray, hit.id);
    return normal_at(ray, s, hit.t / s.scale);
}
