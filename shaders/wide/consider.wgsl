// consider.wgsl in a better arithmetic. Lanes past the end repeat the last sphere, and so must its low parts.
fn consider(hit: Hit, ray: Ray, s: Sphere, id: u32) -> Hit {
    let t = intersect(ray, wide_sphere(s, lows[min(id, view.spheres - 1u)]));
    if (less(t, number(MISS))) {
        let there = scaled(t, s.scale);
        if (less(there, hit.t)) {
            return Hit(there, id);
        }
    }
    return hit;
}
