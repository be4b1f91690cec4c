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

// Whether every sphere at or behind the chunk's minimum depth is too far behind the winner to change the result.
fn is_behind(s: Slopes, k: NearestTwo, chunk_min_depth: f32) -> bool {
    return chunk_min_depth - k.low > s.cull_margin * (s.depth + k.low);
}

// A projected sphere as loaded and shared by a subgroup.
struct Record {
    bits: vec4<i32>,
}

fn load(n: u32) -> Record {
    return Record(projected[n]);
}

fn test_ray(s: Slopes, k: NearestTwo, r: Record, n: u32) -> NearestTwo {
    return with_candidate(k, projected_low(s, projected_of(r.bits)), n);
}

// The search goes through the general spheres and then the candidates of a tile, nearest chunk first. Invocations that share
// loads leave the list together. For those that could leave earlier the remaining candidates change nothing: all of them are
// behind the chunk's minimum depth.
fn chunk_min_depth(s: Slopes, first: u32) -> f32 {
    return bitcast<f32>(shared_entry(s.chunk_min_depths + first / CHUNK));
}

// The same state if the remaining candidates are behind.
fn passed(k: NearestTwo, min_depth: f32, behind: bool) -> NearestTwo {
    return NearestTwo(k.low, select(k.second, min_depth, behind & (min_depth < k.second)), k.slot);
}
