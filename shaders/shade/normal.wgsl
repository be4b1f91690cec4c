// The world normal as a colour: (n + 1)/2.
fn shade(ray: Ray, hit: Hit) -> vec3<f32> {
    let n = to_world(surface_normal(ray, hit));
    return 0.5 * n + vec3<f32>(0.5, 0.5, 0.5);
}
