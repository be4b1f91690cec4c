// The general spheres of a tile, from its list.

fn general_at(n: u32) -> General {
    return general_of(others[4u * n], others[4u * n + 1u], others[4u * n + 2u], others[4u * n + 3u]);
}

// Tests the general spheres of a tile.
fn nearest_two_generals(s: Slopes, tile: vec3<u32>) -> NearestTwo {
    var k = NearestTwo(BEYOND, BEYOND, NONE);
    let range = tile_generals(tile);
    for (var n = range.x; n < range.y; n++) {
        let slot = lists[n];
        k = with_candidate(k, general_low(s, general_at(slot)), GENERAL | slot);
    }
    return k;
}

// The winner's answer if it is a general sphere, otherwise `other`.
fn certify_general(s: Slopes, k: NearestTwo, other: Answer) -> Answer {
    if ((k.slot & GENERAL) != 0u && k.slot != NONE) {
        return general_answer(s, general_at(k.slot & ~GENERAL));
    }
    return other;
}
