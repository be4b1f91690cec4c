//! Reports a test as skipped.

/// Prints that the running test is skipped, and why. `tests/run` counts it as skipped, never as passed, so only
/// `return` may follow.
pub(crate) fn skip(reason: impl std::fmt::Display) {
    println!("SKIPPED: {reason}");
}
