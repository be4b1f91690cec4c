// The state of the search of the certified kernel.

// The two smallest lower bounds of depth, and the slot of the smallest.
struct NearestTwo {
    low: f32,
    second: f32,
    slot: u32,
}

const NOTHING_YET: NearestTwo = NearestTwo(BEYOND, BEYOND, NONE);
const GENERAL: u32 = 0x80000000u; // marks a slot in the list of general spheres

// By comparisons, because software adapters make three instructions of min and max, which have to sort out NaN.
fn with_candidate(k: NearestTwo, low: f32, slot: u32) -> NearestTwo {
    let nearer = low < k.low;
    let farther = select(low, k.low, nearer);
    return NearestTwo(select(k.low, low, nearer), select(k.second, farther, farther < k.second), select(k.slot, slot, nearer));
}
