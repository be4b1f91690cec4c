//! Tiles: squares of pixels that share a list of candidates. The constants that host, CPU path and shaders agree on.

/// Pixels along a side of a tile, which is a workgroup; a layout test holds it against the shaders.
pub(crate) const TILE: u32 = 8;

/// Entries that share a least depth, and that lists are padded to: what the largest sharing subgroup loads at once.
pub(crate) const CHUNK: usize = 8;

/// The level at which every image is one square of tiles.
pub(crate) const WHOLE: u32 = 31;
