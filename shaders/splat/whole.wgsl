// The lower bound of the depth of a sphere, or MISS. No plane cuts one.
fn solid_low(c: Frame, s: Slopes, f: Projected, slot: u32, pixel: u32) -> f32 {
    return projected_low(s, f);
}
