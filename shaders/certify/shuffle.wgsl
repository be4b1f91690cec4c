// All spheres as candidates; those in front, nearly all, are loaded once per subgroup and shared. Lanes past the end
// repeat the last sphere; a repeated sphere is nobody's second.
fn candidates(s: Slopes, start: Kept) -> Kept {
    var k = start;
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, nears[slot]), NEAR | slot);
    }
    for (var first = 0u; first < lens.fronts; first += lanes) {
        let mine = fronts[min(first + lane, lens.fronts - 1u)];
        for (var l = 0u; l < lanes; l++) {
            k = shared_front(s, k, share(mine, l), first + l);
        }
    }
    return k;
}

fn share(f: Front, l: u32) -> Front {
    return Front(
        subgroupShuffle(f.rest, l), subgroupShuffle(f.column, l), subgroupShuffle(f.row, l),
        subgroupShuffle(f.rho2, l), subgroupShuffle(f.error, l),
        subgroupShuffle(f.size, l), subgroupShuffle(f.low, l),
    );
}
