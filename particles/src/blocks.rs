//! The size of blocks that files are read and written in.

use std::sync::LazyLock;

/// The most rows or bytes of a block, which is `most` of them. With debug assertions, HALFLINE_BLOCKS=N divides all of them by N, so
/// that tests have many blocks in short files.
pub fn at_most(most: usize) -> usize {
    static PARTS: LazyLock<usize> = LazyLock::new(|| {
        let given = std::env::var("HALFLINE_BLOCKS").ok().filter(|_| cfg!(debug_assertions));
        given.and_then(|parts| parts.parse().ok()).map_or(1, |parts: usize| parts.max(1))
    });
    most.div_ceil(*PARTS)
}
