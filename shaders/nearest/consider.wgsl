// Keeps the closer hit. Spheres come in the order of their ids and the comparison is strict, so an equal t stays with
// the lower id.
fn consider(hit: Hit, ray: Ray, s: Sphere, id: u32) -> Hit {
    let t = intersect(ray, s);
    if (t < MISS) {
        let scaled = t * s.scale;
        if (scaled < hit.t) {
            return Hit(scaled, id);
        }
    }
    return hit;
}
