// All spheres as candidates; those in front, nearly all, are loaded once per subgroup and shared. Lanes past the end
// repeat the last sphere; a repeated sphere is nobody's second.
fn candidates(s: Slopes, start: Kept) -> Kept {
    var k = start;
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, nears[slot]), NEAR | slot);
    }
    for (var first = 0u; first < lens.fronts; first += 4u) {
        let mine = fronts[min(first + lane, lens.fronts - 1u)];
        k = shared_front(s, k, share0(mine), first + 0u);
        k = shared_front(s, k, share1(mine), first + 1u);
        k = shared_front(s, k, share2(mine), first + 2u);
        k = shared_front(s, k, share3(mine), first + 3u);
    }
    return k;
}

// A broadcast takes constant lanes only.
fn share0(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 0u), subgroupBroadcast(f.column, 0u), subgroupBroadcast(f.row, 0u),
        subgroupBroadcast(f.rho2, 0u), subgroupBroadcast(f.error, 0u),
        subgroupBroadcast(f.size, 0u), subgroupBroadcast(f.low, 0u),
    );
}
fn share1(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 1u), subgroupBroadcast(f.column, 1u), subgroupBroadcast(f.row, 1u),
        subgroupBroadcast(f.rho2, 1u), subgroupBroadcast(f.error, 1u),
        subgroupBroadcast(f.size, 1u), subgroupBroadcast(f.low, 1u),
    );
}
fn share2(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 2u), subgroupBroadcast(f.column, 2u), subgroupBroadcast(f.row, 2u),
        subgroupBroadcast(f.rho2, 2u), subgroupBroadcast(f.error, 2u),
        subgroupBroadcast(f.size, 2u), subgroupBroadcast(f.low, 2u),
    );
}
fn share3(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 3u), subgroupBroadcast(f.column, 3u), subgroupBroadcast(f.row, 3u),
        subgroupBroadcast(f.rho2, 3u), subgroupBroadcast(f.error, 3u),
        subgroupBroadcast(f.size, 3u), subgroupBroadcast(f.low, 3u),
    );
}
