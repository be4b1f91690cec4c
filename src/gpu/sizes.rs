//! Sizes that the host and the steps of resident frames share; compose.rs writes them into the shaders.

/// Limits of a frame on a device: spheres that the host places, pieces of large spheres, and pairs of an unsure pixel
/// and a sphere.
pub(crate) const HOST_SPHERES: u32 = 1 << 16;
pub(crate) const PIECES: u32 = 1 << 20;
pub(crate) const PAIRS: u32 = 1 << 20;
/// Indices of the summary's words: the numbers of spheres for the host, of pieces and of pairs; a word above 0 where
/// pieces are too many to be counted; the first word of the list of spheres.
pub(crate) const SUMMARY_HOST: u32 = 4;
pub(crate) const SUMMARY_PIECES: u32 = 5;
pub(crate) const SUMMARY_PAIRS: u32 = 6;
pub(crate) const SUMMARY_MORE: u32 = 7;
pub(crate) const SUMMARY_LIST: u32 = 8;
/// Pixels along a side of a piece. A sphere with more than [`CUT`] pixels has pieces up to 2^[`COARSEST`] times as
/// wide.
pub(crate) const PIECE: u32 = 32;
pub(crate) const CUT: u32 = 1 << 14;
pub(crate) const COARSEST: u32 = 3;
/// The most pixels of a sphere that one invocation visits.
pub(crate) const MAX_PIXELS_PER_INVOCATION: u32 = 256;
/// Steps through a tree of an invocation before it is left to the host. Each is at most three iterations of loops, and llvmpipe ends
/// the loops of a vector of up to 16 invocations after 65,536 iterations together.
pub(crate) const STEPS: u32 = 1300;
