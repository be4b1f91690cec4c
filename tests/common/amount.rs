//! The amount of work of a test. With HALFLINE_TESTS=all, which `tests/run --all` sets, it is everything; otherwise a
//! part that finds faults of the same kinds.

/// Whether tests do everything.
pub(crate) fn everything() -> bool {
    std::env::var_os("HALFLINE_TESTS").is_some_and(|tests| tests == "all")
}

/// `some`, or `all` of these: seeds, rays, scenes. `tests/run` counts what the words that are printed say was left out.
pub(crate) fn amount<T: Copy + PartialOrd + std::fmt::Display>(what: &str, some: T, all: T) -> T {
    if everything() {
        return all;
    }
    if some < all {
        println!("LEFT OUT: {what}: {some} of {all}");
    }
    some
}
