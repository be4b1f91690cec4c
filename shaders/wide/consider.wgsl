// nearest/consider.wgsl in a better arithmetic.
fn consider(hit: Hit, ray: Ray, s: Sphere, low: SphereLow, id: u32) -> Hit {
    let t = intersect(ray, wide_sphere(s, low));
    if (less(t, number(MISS))) {
        let there = scaled(t, s.scale);
        if (less(there, hit.t)) {
            return Hit(there, id);
        }
    }
    return hit;
}
