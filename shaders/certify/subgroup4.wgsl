// All spheres as candidates; those in front, nearly all, are loaded once per subgroup and shared. The host pads their
// list with spheres that nothing hits.
fn candidates(s: Slopes, start: Kept) -> Kept {
    var k = start;
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, nears[slot]), NEAR | slot);
    }
    for (var first = 0u; first < lens.fronts; first += 4u) {
        let mine = fronts[first + lane];
        k = keep(k, front_low(s, share0(mine)), first + 0u);
        k = keep(k, front_low(s, share1(mine)), first + 1u);
        k = keep(k, front_low(s, share2(mine)), first + 2u);
        k = keep(k, front_low(s, share3(mine)), first + 3u);
    }
    return k;
}

// A broadcast takes constant lanes only.
fn share0(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 0u), subgroupBroadcast(f.y, 0u),
        subgroupBroadcast(f.rho, 0u), subgroupBroadcast(f.low, 0u),
    );
}
fn share1(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 1u), subgroupBroadcast(f.y, 1u),
        subgroupBroadcast(f.rho, 1u), subgroupBroadcast(f.low, 1u),
    );
}
fn share2(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 2u), subgroupBroadcast(f.y, 2u),
        subgroupBroadcast(f.rho, 2u), subgroupBroadcast(f.low, 2u),
    );
}
fn share3(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 3u), subgroupBroadcast(f.y, 3u),
        subgroupBroadcast(f.rho, 3u), subgroupBroadcast(f.low, 3u),
    );
}
