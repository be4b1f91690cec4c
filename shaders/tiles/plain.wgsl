// Every invocation loads every candidate for itself: right on every adapter.
fn all_of_us(yes: bool) -> bool {
    return yes;
}

fn ask(ray: Ray, start: Found, first: u32) -> Found {
    var found = start;
    for (var n = first; n < first + CHUNK; n++) {
        found = consider(found, ray, candidate(packed(n)), n);
    }
    return found;
}
