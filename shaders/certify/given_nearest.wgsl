// The nearest hit of a given ray.

struct Best {
    low: f32,    // bounds of its t
    high: f32,
    place: u32,
    rival: f32,  // the least t at which any other sphere may be hit
    limit: f32,  // no hit from here on is the nearest
}

fn begin(ray: CertifiedRay) -> Best {
    return Best(MISS, MISS, NONE, MISS, ray.limit);
}

fn keep(k: Best, ray: CertifiedRay, place: u32, bounds: Bounds) -> Best {
    if (bounds.low >= ray.limit) {
        return k;
    }
    if (bounds.sure && bounds.high < min(ray.sure_limit, k.high)) {
        return Best(bounds.low, bounds.high, place, min(k.rival, k.low), bounds.high);
    }
    return Best(k.low, k.high, k.place, min(k.rival, bounds.low), k.limit);
}

// The state that leaves the ray to the host.
fn undecided() -> Best {
    return Best(MISS, MISS, NONE, 0.0, 0.0);
}

// The place of the sphere that is hit, NONE or UNSURE.
fn answer(k: Best) -> u32 {
    return select(UNSURE, k.place, k.rival > k.high || (k.place == NONE && k.rival == MISS));
}
