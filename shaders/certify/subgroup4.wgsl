// Subgroups of 4: each invocation loads one candidate, and all share it.
fn all_of_us(yes: bool) -> bool {
    return subgroupAll(yes);
}

fn ask(s: Slopes, k: Kept, first: u32) -> Kept {
    return ask_half(s, ask_half(s, k, first), first + 4u);
}

fn ask_half(s: Slopes, start: Kept, first: u32) -> Kept {
    let mine = front(first + lane);
    var k = start;
    k = keep(k, front_low(s, share0(mine)), first + 0u);
    k = keep(k, front_low(s, share1(mine)), first + 1u);
    k = keep(k, front_low(s, share2(mine)), first + 2u);
    k = keep(k, front_low(s, share3(mine)), first + 3u);
    return k;
}
