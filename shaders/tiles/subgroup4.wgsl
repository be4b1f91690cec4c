// Subgroups of 4: each invocation loads one candidate, and all share it. A broadcast takes constant lanes only.
fn all_of_us(yes: bool) -> bool {
    return subgroupAll(yes);
}

fn ask(ray: Ray, found: Found, first: u32) -> Found {
    return ask_half(ray, ask_half(ray, found, first), first + 4u);
}

fn ask_half(ray: Ray, start: Found, first: u32) -> Found {
    let p = packed(first + lane);
    var found = start;
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 0u), subgroupBroadcast(p.rest, 0u))), first + 0u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 1u), subgroupBroadcast(p.rest, 1u))), first + 1u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 2u), subgroupBroadcast(p.rest, 2u))), first + 2u);
    found = consider(found, ray, candidate(Packed(subgroupBroadcast(p.ball, 3u), subgroupBroadcast(p.rest, 3u))), first + 3u);
    return found;
}
