// Unit world normal, facing the ray's origin; zero on a miss.
fn world_normal(ray: Ray, hit: Hit) -> vec3<f32> {
    var n = vec3<f32>(0.0, 0.0, 0.0);
    if (hit.id != NONE) {
        n = to_world(surface_normal(ray, hit));
    }
    return n;
}
