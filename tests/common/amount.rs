//! The amount of work of a test, by HALFLINE_TESTS: nothing for what shows that halfline is right on a machine, `ci` for what finds
//! faults of every kind, `all` for further faults of the same kinds. `tests/run` sets it.

/// The index of the level in the amounts of a test.
fn level() -> usize {
    match std::env::var("HALFLINE_TESTS").as_deref() {
        Ok("all") => 2,
        Ok("ci") => 1,
        _ => 0,
    }
}

/// Whether tests do everything.
pub(crate) fn everything() -> bool {
    level() == 2
}

/// The amount for this level, of those for each: seeds, rays, scenes. `tests/run` counts what the words that are printed say was
/// left out.
pub(crate) fn amount<T: Copy + PartialOrd + std::fmt::Display>(what: &str, amounts: [T; 3]) -> T {
    let [_, ci, all] = amounts;
    let own = amounts[level()];
    if own < ci && ci < all {
        println!("LEFT OUT: {what}: {own} of {ci} with --ci, of {all} with --all");
    } else if own < all {
        println!("LEFT OUT: {what}: {own} of {all} with {}", if own < ci { "--ci" } else { "--all" });
    }
    own
}
