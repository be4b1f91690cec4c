// Subgroups of 8: each invocation loads one candidate, and all share it.
fn all_of_us(yes: bool) -> bool {
    return subgroupAll(yes);
}

fn ask(s: Slopes, start: Kept, first: u32) -> Kept {
    let mine = front(first + lane);
    var k = start;
    k = keep(k, front_low(s, share0(mine)), first + 0u);
    k = keep(k, front_low(s, share1(mine)), first + 1u);
    k = keep(k, front_low(s, share2(mine)), first + 2u);
    k = keep(k, front_low(s, share3(mine)), first + 3u);
    k = keep(k, front_low(s, share4(mine)), first + 4u);
    k = keep(k, front_low(s, share5(mine)), first + 5u);
    k = keep(k, front_low(s, share6(mine)), first + 6u);
    k = keep(k, front_low(s, share7(mine)), first + 7u);
    return k;
}

// And of the other four.
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
