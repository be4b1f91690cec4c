//! How a test says that it cannot check what it is for.

/// Says that the running test checks nothing here, and why. `tests/count` counts such a test as skipped, never as passed, so
/// that nothing but `return` may follow.
pub(crate) fn skip(reason: impl std::fmt::Display) {
    println!("SKIPPED: {reason}");
}
