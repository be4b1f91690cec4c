// Keeps the closer hit; of equal ones the lower id, for lists have an order of their own.
fn consider(found: Found, ray: Ray, c: Candidate, place: u32) -> Found {
    let t = intersect(ray, sphere_of(c));
    if (t < MISS) {
        let met = Hit(t * c.scale, c.id);
        if (is_before(met, found.hit)) {
            return Found(met, place);
        }
    }
    return found;
}

fn missed() -> Hit {
    return Hit(MISS, NONE);
}

fn is_behind(hit: Hit, limit: f32) -> bool {
    return hit.t < limit;
}

// The sphere that was hit.
fn sphere_for(ray: Ray, id: u32) -> Sphere {
    return sphere_of(candidate(packed(place)));
}
