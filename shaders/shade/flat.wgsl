// The sphere's own colour.
fn shade(ray: Ray, hit: Hit) -> vec3<f32> {
    return sphere_color(hit.id);
}
