// Every invocation loads every candidate for itself: right on every adapter.
fn all_of_us(yes: bool) -> bool {
    return yes;
}

fn ask(s: Slopes, start: Kept, first: u32) -> Kept {
    var k = start;
    for (var n = 0u; n < CHUNK; n++) {
        k = keep(k, front_low(s, front(first + n)), first + n);
    }
    return k;
}
