// What a tree's walk asks of a sphere.
fn no_hit() -> Hit {
    return Hit(MISS, NONE);
}

// Keeps the closer hit, and of an equal t the lower id: a tree's spheres come in any order.
fn meet(hit: Hit, ray: Ray, id: u32) -> Hit {
    let s = sphere_for(ray, id);
    let t = intersect(ray, s);
    if (t < MISS) {
        let met = Hit(t * s.scale, id);
        if (is_before(met, hit)) {
            return met;
        }
    }
    return hit;
}

// What begins behind this cannot hold the closest hit.
fn reach(hit: Hit) -> f32 {
    return hit.t;
}
