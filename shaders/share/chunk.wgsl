// Tests `count` records, at most a chunk.
fn test_chunk(ray: Searcher, start: Best, first: u32, count: u32) -> Best {
    var best = start;
    for (var n = 0u; n < count; n++) {
        best = test(ray, best, load(first + n), first + n);
    }
    return best;
}
