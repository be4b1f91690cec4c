// A candidate of the first four lanes: a broadcast takes constant lanes only.
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
