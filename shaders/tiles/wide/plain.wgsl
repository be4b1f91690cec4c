// tiles/plain.wgsl in a better arithmetic.
fn all_of_us(yes: bool) -> bool {
    return yes;
}

fn ask(ray: Ray, start: Found, first: u32) -> Found {
    var found = start;
    for (var n = first; n < first + CHUNK; n++) {
        found = consider(found, ray, candidate(packed(n)), candidate_low(n), n);
    }
    return found;
}
