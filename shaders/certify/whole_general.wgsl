// A general sphere, tested by one ray.
fn test_general(s: Slopes, k: NearestTwo, n: u32) -> NearestTwo {
    return with_candidate(k, general_low(s, general_at(n)), GENERAL | n);
}
