// Subgroups of 8: each invocation loads one candidate, and all share it. A broadcast takes constant lanes only.
fn all_of_us(yes: bool) -> bool {
    return subgroupAll(yes);
}

fn ask(ray: Ray, start: Found, first: u32) -> Found {
    let p = packed(first + lane);
    var found = start;
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 0u), subgroupBroadcast(p.rest, 0u))), first + 0u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 1u), subgroupBroadcast(p.rest, 1u))), first + 1u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 2u), subgroupBroadcast(p.rest, 2u))), first + 2u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 3u), subgroupBroadcast(p.rest, 3u))), first + 3u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 4u), subgroupBroadcast(p.rest, 4u))), first + 4u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 5u), subgroupBroadcast(p.rest, 5u))), first + 5u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 6u), subgroupBroadcast(p.rest, 6u))), first + 6u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 7u), subgroupBroadcast(p.rest, 7u))), first + 7u);
    return found;
}
