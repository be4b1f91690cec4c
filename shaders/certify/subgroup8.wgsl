// All spheres as candidates; those in front, nearly all, are loaded once per subgroup and shared. Lanes past the end
// repeat the last sphere; a repeated sphere is nobody's second.
fn candidates(s: Slopes, start: Kept) -> Kept {
    var k = start;
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, nears[slot]), NEAR | slot);
    }
    for (var first = 0u; first < lens.fronts; first += 8u) {
        let mine = fronts[min(first + lane, lens.fronts - 1u)];
        k = shared_front(s, k, share0(mine), first + 0u);
        k = shared_front(s, k, share1(mine), first + 1u);
        k = shared_front(s, k, share2(mine), first + 2u);
        k = shared_front(s, k, share3(mine), first + 3u);
        k = shared_front(s, k, share4(mine), first + 4u);
        k = shared_front(s, k, share5(mine), first + 5u);
        k = shared_front(s, k, share6(mine), first + 6u);
        k = shared_front(s, k, share7(mine), first + 7u);
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
fn share4(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 4u), subgroupBroadcast(f.column, 4u), subgroupBroadcast(f.row, 4u),
        subgroupBroadcast(f.rho2, 4u), subgroupBroadcast(f.error, 4u),
        subgroupBroadcast(f.size, 4u), subgroupBroadcast(f.low, 4u),
    );
}
fn share5(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 5u), subgroupBroadcast(f.column, 5u), subgroupBroadcast(f.row, 5u),
        subgroupBroadcast(f.rho2, 5u), subgroupBroadcast(f.error, 5u),
        subgroupBroadcast(f.size, 5u), subgroupBroadcast(f.low, 5u),
    );
}
fn share6(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 6u), subgroupBroadcast(f.column, 6u), subgroupBroadcast(f.row, 6u),
        subgroupBroadcast(f.rho2, 6u), subgroupBroadcast(f.error, 6u),
        subgroupBroadcast(f.size, 6u), subgroupBroadcast(f.low, 6u),
    );
}
fn share7(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.rest, 7u), subgroupBroadcast(f.column, 7u), subgroupBroadcast(f.row, 7u),
        subgroupBroadcast(f.rho2, 7u), subgroupBroadcast(f.error, 7u),
        subgroupBroadcast(f.size, 7u), subgroupBroadcast(f.low, 7u),
    );
}
