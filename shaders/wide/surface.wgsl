// surface.wgsl in a better arithmetic; the normal does not start from t.
fn surface_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    return normal_at(ray, wide_sphere(spheres[hit.id], lows[hit.id]));
}
