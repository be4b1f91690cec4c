// Subgroups of 4 or 8: each invocation loads one candidate, and all share it. Not unrolled for broadcasts: a fifth
// faster, and eight times the text to compile.
fn all_of_us(yes: bool) -> bool {
    return subgroupAll(yes);
}

fn ask(ray: Ray, start: Found, first: u32) -> Found {
    var found = start;
    for (var part = first; part < first + CHUNK; part += lanes) {
        let p = packed(part + lane);
        let low = candidate_low(part + lane);
        for (var k = 0u; k < lanes; k++) {
            let other = candidate(Packed(subgroupShuffle(p.ball, k), subgroupShuffle(p.rest, k)));
            let other_low = SphereLow(subgroupShuffle(low.ball, k), subgroupShuffle(low.power, k));
            found = consider(found, ray, other, other_low, part + k);
        }
    }
    return found;
}
