// The lower bound of the depth of a sphere that planes may cut, or MISS. A certain face leaves its rank in the pixel, inverted, behind
// the other minima: all faces of a ray are at one depth, which main/certified.wgsl knows.
fn solid_low(c: Frame, s: Slopes, f: Projected, slot: u32, pixel: u32) -> f32 {
    let rank = rank_of(slot);
    if (rank == 0u) {
        return projected_low(s, f);
    }
    let found = cut_hit(kept_of(s), projected_roots(s, f, projected_detail(slot)));
    if (!found.at_face || c.mode == PAIRS_OF_UNSURE) {
        return found.low;
    }
    if (c.mode == LEAST) {
        atomicMax(&minima[3u * c.pixels + pixel], ~rank);
    }
    return MISS;
}
