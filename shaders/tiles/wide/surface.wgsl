// wide/surface.wgsl for the candidate that was hit.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    return normal_at(ray, wide_sphere(sphere_of(candidate(packed(place))), candidate_low(place)));
}
