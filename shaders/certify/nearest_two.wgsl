// The search of the certified kernel.

// The two smallest lower bounds of depth, and the slot of the smallest.
struct NearestTwo {
    low: f32,
    second: f32,
    slot: u32,
}

const GENERAL: u32 = 0x80000000u; // marks a slot in the list of general spheres

fn with_candidate(k: NearestTwo, low: f32, slot: u32) -> NearestTwo {
    return NearestTwo(min(k.low, low), min(k.second, max(k.low, low)), select(k.slot, slot, low < k.low));
}

// Whether every sphere at or behind the chunk's minimum depth is too far behind the winner to change the result.
fn is_behind(s: Slopes, k: NearestTwo, chunk_min_depth: f32) -> bool {
    return chunk_min_depth - k.low > s.cull_margin * (s.depth + k.low);
}

alias Searcher = Slopes;
alias Best = NearestTwo;

// A projected sphere as loaded and shared by a subgroup.
struct Record {
    bits: vec4<i32>,
}

fn load(n: u32) -> Record {
    return Record(projected[n]);
}

fn test(s: Slopes, k: NearestTwo, r: Record, n: u32) -> NearestTwo {
    return with_candidate(k, projected_low(s, projected_of(r.bits)), n);
}

// Tests the general spheres and then the candidates of a tile, nearest chunk first. Invocations that share loads leave the
// list together. For those that could leave earlier the remaining candidates change nothing: all of them are behind the
// chunk's minimum depth.
fn nearest_two(s: Slopes, tile: vec3<u32>) -> NearestTwo {
    var k = nearest_two_generals(s, tile);
    let range = tile_list(tile);
    for (var first = range.x; first < range.y; first += CHUNK) {
        let chunk_min_depth = bitcast<f32>(lists[s.chunk_min_depths + first / CHUNK]);
        let behind = is_behind(s, k, chunk_min_depth);
        k.second = select(k.second, min(k.second, chunk_min_depth), behind);
        if (all_of_subgroup(behind)) {
            break;
        }
        k = test_chunk(s, k, first, CHUNK);
    }
    return k;
}
