// All spheres as candidates, each loaded by every invocation for itself: right on every adapter.
fn candidates(s: Slopes, start: Kept) -> Kept {
    var k = start;
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, nears[slot]), NEAR | slot);
    }
    for (var slot = 0u; slot < lens.fronts; slot++) {
        k = keep(k, front_low(s, fronts[slot]), slot);
    }
    return k;
}
