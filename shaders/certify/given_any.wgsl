// Whether a given ray hits anything.

struct Best {
    place: u32,  // of a sphere that is hit for certain; NONE, or UNSURE if some sphere may be hit
    limit: f32,  // below 0 once a hit is certain, which ends the search
}

fn begin(ray: CertifiedRay) -> Best {
    return Best(NONE, ray.limit);
}

fn keep(k: Best, ray: CertifiedRay, place: u32, bounds: Bounds) -> Best {
    if (bounds.low >= ray.limit) {
        return k;
    }
    if (bounds.sure && bounds.high < ray.sure_limit) {
        return Best(place, -1.0);
    }
    return Best(UNSURE, k.limit);
}

// The place of a sphere that is hit, NONE or UNSURE.
fn answer(k: Best) -> u32 {
    return k.place;
}
