// The two smallest lower bounds of depth, and whose the smallest is.
struct Kept {
    low: f32,
    second: f32,
    slot: u32,
}

// The depth of nothing: above every lower bound, and so far below the largest f32 that no sum with a depth overflows.
const BEYOND: f32 = 8.507059173023462e37; // 2^126

const NEAR: u32 = 0x80000000u; // marks a slot in the list of near spheres

fn keep(k: Kept, low: f32, slot: u32) -> Kept {
    return Kept(min(k.low, low), min(k.second, max(k.low, low)), select(k.slot, slot, low < k.low));
}

// Whether all that lies behind the sill is too far behind the winner to matter.
fn is_behind(s: Slopes, k: Kept, sill: f32) -> bool {
    return sill - k.low > s.slack * (s.depth + k.low);
}
