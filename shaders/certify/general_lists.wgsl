// The general spheres of a tile, from its list.

fn general_at(n: u32) -> General {
    return general_of(others[4u * n], others[4u * n + 1u], others[4u * n + 2u], others[4u * n + 3u]);
}

// others[n], for a subgroup.
fn shared_other(n: u32) -> vec4<i32> {
    var other = vec4<i32>(0, 0, 0, 0);
    if (leads()) {
        other = others[n];
    }
    return bitcast<vec4<i32>>(of_leader(bitcast<vec4<u32>>(other)));
}

fn shared_general(n: u32) -> General {
    return general_of(shared_other(4u * n), shared_other(4u * n + 1u), shared_other(4u * n + 2u), shared_other(4u * n + 3u));
}

// Tests the general spheres of a tile.
fn nearest_two_generals(s: Searcher, start: Best, tile: vec3<u32>) -> Best {
    var k = start;
    let range = tile_generals(tile);
    for (var n = range.x; n < range.y; n++) {
        let slot = shared_entry(n);
        k = test_general(s, k, shared_general(slot), slot);
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
