// A general sphere, tested by the rays of a column.
fn test_general(s: Column, k: NearestOfColumn, n: General, slot: u32) -> NearestOfColumn {
    return NearestOfColumn(
        with_candidate(k.a, general_low(s.a, n), GENERAL | slot), with_candidate(k.b, general_low(s.b, n), GENERAL | slot),
        with_candidate(k.c, general_low(s.c, n), GENERAL | slot), with_candidate(k.d, general_low(s.d, n), GENERAL | slot),
    );
}
