// General spheres; planes may cut some.
fn general_roots(s: Slopes, n: General) -> Roots {
    let answer = general_answer(s, n);
    let w = general_weigh(s, n);
    let least = sqrt(positive(w.disc - w.error));
    let most = sqrt(positive(w.disc + w.error));
    let of_sum = sum_error(s);
    let sums = vec2<f32>(
        (w.b - w.b_error + least) * s.inverse * (1.0 - of_sum) * n.scale,
        (w.b + w.b_error + most) * s.inverse * (1.0 + of_sum) * n.scale,
    );
    let outside = n.power > 0.0;
    let first = general_low(s, n);
    // An eye on the surface is not known to be on either side of it.
    let hits = answer.hits && n.power != 0.0;
    let far = vec2<f32>(select(answer.low, sums.x, outside), select(BEYOND, select(answer.high, sums.y, outside), hits));
    let near = vec2<f32>(select(-BEYOND, first, outside), select(-BEYOND, answer.high, outside));
    return Roots(near, far, hits, first >= MISS, !outside);
}

// A general sphere, tested by one ray.
fn test_general(s: Slopes, k: NearestTwo, n: u32) -> NearestTwo {
    let general = general_at(n);
    if (general.rank == 0u) {
        return with_candidate(k, general_low(s, general), GENERAL | n);
    }
    let found = cut_hit(kept, general_roots(s, general));
    if (found.at_face) {
        face = min(face, general.rank);
        return k;
    }
    return with_candidate(k, found.low, GENERAL | n);
}

// Whether planes certainly leave the hit of a general sphere as if it were whole.
fn keeps_general(s: Slopes, n: u32) -> bool {
    let general = general_at(n);
    return general.rank == 0u || cut_hit(kept, general_roots(s, general)).at_root;
}
