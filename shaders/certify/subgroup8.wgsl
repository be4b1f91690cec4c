// The spheres of a tile as candidates, nearest first, loaded once per subgroup and shared. A subgroup leaves the list
// together: to those that could leave earlier, what follows makes no difference, since all of it lies behind the sill.
fn candidates(s: Slopes, range: vec2<u32>) -> Kept {
    var k = Kept(MISS, MISS, NONE);
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, near(slot)), NEAR | slot);
    }
    for (var first = range.x; first < range.y; first += CHUNK) {
        let least = sill(first);
        let behind = is_behind(s, k, least);
        k.second = select(k.second, min(k.second, least), behind);
        if (subgroupAll(behind)) {
            break;
        }
        let mine = front(first + lane);
        k = keep(k, front_low(s, share0(mine)), first + 0u);
        k = keep(k, front_low(s, share1(mine)), first + 1u);
        k = keep(k, front_low(s, share2(mine)), first + 2u);
        k = keep(k, front_low(s, share3(mine)), first + 3u);
        k = keep(k, front_low(s, share4(mine)), first + 4u);
        k = keep(k, front_low(s, share5(mine)), first + 5u);
        k = keep(k, front_low(s, share6(mine)), first + 6u);
        k = keep(k, front_low(s, share7(mine)), first + 7u);
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
fn share4(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 4u), subgroupBroadcast(f.y, 4u),
        subgroupBroadcast(f.rho, 4u), subgroupBroadcast(f.low, 4u),
    );
}
fn share5(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 5u), subgroupBroadcast(f.y, 5u),
        subgroupBroadcast(f.rho, 5u), subgroupBroadcast(f.low, 5u),
    );
}
fn share6(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 6u), subgroupBroadcast(f.y, 6u),
        subgroupBroadcast(f.rho, 6u), subgroupBroadcast(f.low, 6u),
    );
}
fn share7(f: Front) -> Front {
    return Front(
        subgroupBroadcast(f.x, 7u), subgroupBroadcast(f.y, 7u),
        subgroupBroadcast(f.rho, 7u), subgroupBroadcast(f.low, 7u),
    );
}
