// The two smallest lower bounds of depth, and whose the smallest is.
struct Kept {
    low: f32,
    second: f32,
    slot: u32,
}

const NEAR: u32 = 0x80000000u; // marks a slot in the list of near spheres

fn keep(k: Kept, low: f32, slot: u32) -> Kept {
    if (low < k.low) {
        return Kept(low, k.low, slot);
    }
    if (low < k.second) {
        return Kept(k.low, low, k.slot);
    }
    return k;
}
