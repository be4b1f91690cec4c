// Lambert with the light at the eye: colour times the cosine between the normal and the reversed ray direction.
fn shade(ray: Ray, hit: Hit) -> vec3<f32> {
    // These are the bits of the direction, but unknown to compilers: where they know its last component, they make a quotient of a
    // product, which rounds otherwise.
    let d = bitcast<vec3<f32>>(bitcast<vec3<u32>>(rounded(ray.d)) ^ vec3<u32>(view.zero));
    let cosine = positive(-dot3(surface_normal(ray, hit), unit3(d)));
    return cosine * sphere_color(hit.id);
}
