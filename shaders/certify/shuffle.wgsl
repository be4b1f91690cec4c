// All spheres as candidates; those in front, nearly all, are loaded once per subgroup and shared. The host pads their
// list with spheres that nothing hits.
fn candidates(s: Slopes, start: Kept) -> Kept {
    var k = start;
    for (var slot = 0u; slot < lens.nears; slot++) {
        k = keep(k, near_low(s, nears[slot]), NEAR | slot);
    }
    for (var first = 0u; first < lens.fronts; first += lanes) {
        let mine = fronts[first + lane];
        for (var l = 0u; l < lanes; l++) {
            k = keep(k, front_low(s, share(mine, l)), first + l);
        }
    }
    return k;
}

fn share(f: Front, l: u32) -> Front {
    return Front(
        subgroupShuffle(f.x, l), subgroupShuffle(f.y, l),
        subgroupShuffle(f.rho, l), subgroupShuffle(f.low, l),
    );
}
