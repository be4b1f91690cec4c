// The search for one ray.

alias Searcher = Slopes;
alias Best = NearestTwo;

fn test(s: Slopes, k: NearestTwo, r: Record, n: u32) -> NearestTwo {
    return test_ray(s, k, r, n);
}

fn nearest_two(s: Slopes, tile: vec3<u32>) -> NearestTwo {
    var k = nearest_two_generals(s, NOTHING_YET, tile);
    let range = tile_list(tile);
    for (var first = range.x; first < range.y; first += CHUNK) {
        let min_depth = chunk_min_depth(s, first);
        let behind = is_behind(s, k, min_depth);
        k = passed(k, min_depth, behind);
        if (all_of_subgroup(behind)) {
            break;
        }
        k = test_chunk(s, k, first, CHUNK);
    }
    return k;
}
