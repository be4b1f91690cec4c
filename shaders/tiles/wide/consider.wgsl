// tiles/consider.wgsl in a better arithmetic.

// What rounding took from each of candidates: two vectors, of which the second holds the power's.
@group(0) @binding(18) var<storage, read> candidate_lows: array<vec4<f32>>;

fn candidate_low(n: u32) -> SphereLow {
    return SphereLow(candidate_lows[2u * n], candidate_lows[2u * n + 1u].x);
}

fn consider(found: Found, ray: Ray, c: Candidate, low: SphereLow, place: u32) -> Found {
    let t = intersect(ray, wide_sphere(sphere_of(c), low));
    if (less(t, number(MISS))) {
        let met = Hit(scaled(t, c.scale), c.id);
        if (is_before(met, found.hit)) {
            return Found(met, place);
        }
    }
    return found;
}

fn missed() -> Hit {
    return Hit(number(MISS), NONE);
}

fn is_behind(hit: Hit, limit: f32) -> bool {
    return high(hit.t) < limit;
}
