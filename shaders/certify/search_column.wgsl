// The search for ROWS rays of a column of pixels in one invocation: a load, and what depends on the sphere or the column alone,
// serve all of them. On software adapters this takes half of the time.

struct Column {
    a: Slopes,
    b: Slopes,
    c: Slopes,
    d: Slopes,
}

struct NearestOfColumn {
    a: NearestTwo,
    b: NearestTwo,
    c: NearestTwo,
    d: NearestTwo,
}

alias Searcher = Column;
alias Best = NearestOfColumn;

fn test(s: Column, k: NearestOfColumn, r: Record, n: u32) -> NearestOfColumn {
    return NearestOfColumn(test_ray(s.a, k.a, r, n), test_ray(s.b, k.b, r, n), test_ray(s.c, k.c, r, n), test_ray(s.d, k.d, r, n));
}

fn nearest_two(s: Column, tile: vec3<u32>) -> NearestOfColumn {
    var k = nearest_two_generals(s, NearestOfColumn(NOTHING_YET, NOTHING_YET, NOTHING_YET, NOTHING_YET), tile);
    let range = tile_list(tile);
    for (var first = range.x; first < range.y; first += CHUNK) {
        let min_depth = chunk_min_depth(s.a, first);
        let a = is_behind(s.a, k.a, min_depth);
        let b = is_behind(s.b, k.b, min_depth);
        let c = is_behind(s.c, k.c, min_depth);
        let d = is_behind(s.d, k.d, min_depth);
        k = NearestOfColumn(
            passed(k.a, min_depth, a), passed(k.b, min_depth, b), passed(k.c, min_depth, c), passed(k.d, min_depth, d),
        );
        if (all_of_subgroup(a & b & c & d)) {
            break;
        }
        k = test_chunk(s, k, first, CHUNK);
    }
    return k;
}
