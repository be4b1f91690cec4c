//! Sizes that the host and the steps of resident frames share; compose.rs writes them into the shaders.

/// The most spheres that the host looks at, pieces of large spheres, and pairs of an unsure pixel and a sphere.
pub(crate) const HOST_SPHERES: u32 = 1 << 16;
pub(crate) const PIECES: u32 = 1 << 20;
pub(crate) const PAIRS: u32 = 1 << 20;
/// Where the list of spheres begins in the summary.
pub(crate) const SUMMARY_LIST: u32 = 8;
/// Pixels along a side of a piece; those of a sphere with more than [`CUT`] are up to 2^[`COARSEST`] times as wide.
pub(crate) const PIECE: u32 = 32;
pub(crate) const CUT: u32 = 1 << 14;
pub(crate) const COARSEST: u32 = 3;
/// Pixels of a sphere that one invocation goes through.
pub(crate) const SMALL: u32 = 256;
