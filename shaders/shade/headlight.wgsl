// Lambert with the light at the eye: colour times the cosine between the normal and the reversed ray direction.
fn shade(ray: Ray, hit: Hit) -> vec3<f32> {
    let cosine = positive(-dot3(surface_normal(ray, hit), unit3(rounded(ray.d))));
    return cosine * sphere_color(hit.id);
}
