// The search of candidate lists for one ray.

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
