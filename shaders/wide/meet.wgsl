// nearest/meet.wgsl in a better arithmetic.
fn no_hit() -> Hit {
    return Hit(number(MISS), NONE);
}

fn meet(hit: Hit, ray: Ray, id: u32) -> Hit {
    let s = spheres[id];
    let t = intersect(ray, wide_sphere(s, lows[id]));
    if (less(t, number(MISS))) {
        let met = Hit(scaled(t, s.scale), id);
        if (is_before(met, hit)) {
            return met;
        }
    }
    return hit;
}

// Rounded; the boxes' padding is larger than that.
fn reach(hit: Hit) -> f32 {
    return high(hit.t);
}
