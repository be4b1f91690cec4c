//! Pictures that are rendered together.

use halfline::parallel;

/// The most spheres and the most pixels of pictures that are in memory together: some hundred bytes each.
const MOST: usize = 1 << 22;

/// Pictures on a device: one is computed there while the host does its part of the other.
const ON_DEVICE: usize = 2;

/// The spheres of the pictures of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SpheresOf {
    /// All pictures show the same ones.
    All,
    /// Each picture has its own.
    Each,
}

/// The number of pictures of so many pixels and spheres that may be in memory together, on a device or the CPU path; 0 where one is
/// large.
pub(super) fn together(is_gpu: bool, pixels: usize, spheres: usize, of: SpheresOf) -> usize {
    // A device holds what all pictures show once. On the CPU path each picture arranges its spheres.
    let spheres = if is_gpu && of == SpheresOf::All { 0 } else { spheres };
    let most = if is_gpu { ON_DEVICE } else { parallel::threads() };
    (MOST / pixels.max(spheres).max(1)).min(most)
}
