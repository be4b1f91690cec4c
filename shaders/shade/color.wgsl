// Shaded colour, linear RGB; the background on a miss.
fn hit_color(ray: Ray, hit: Hit) -> vec3<f32> {
    var c = view.background.rgb;
    if (hit.id != NONE) {
        c = shade(ray, hit);
    }
    return c;
}
