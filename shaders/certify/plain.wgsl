// The spheres of a tile as candidates, nearest first, each loaded by every invocation for itself: right on every adapter.
fn candidates(s: Slopes, range: vec2<u32>) -> Kept {
    var k = Kept(MISS, MISS, NONE);
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, near(slot)), NEAR | slot);
    }
    for (var first = range.x; first < range.y; first += CHUNK) {
        let least = sill(first);
        if (is_behind(s, k, least)) {
            k.second = min(k.second, least);
            break;
        }
        for (var n = 0u; n < CHUNK; n++) {
            k = keep(k, front_low(s, front(first + n)), first + n);
        }
    }
    return k;
}
