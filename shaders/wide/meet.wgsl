// nearest/meet.wgsl in a better arithmetic.
fn no_hit() -> Hit {
    return Hit(number(MISS), NONE);
}

fn meet(hit: Hit, ray: Ray, id: u32) -> Hit {
    let s = spheres[id];
    let t = intersect(ray, wide_sphere(s, lows[id]));
    if (less(t, number(MISS))) {
        let there = scaled(t, s.scale);
        if (less(there, hit.t) || (id < hit.id && !less(hit.t, there) && less(there, number(MISS)))) {
            return Hit(there, id);
        }
    }
    return hit;
}

// Rounded; the boxes' padding is larger than that.
fn reach(hit: Hit) -> f32 {
    return high(hit.t);
}
