//! Tiles: squares of pixels that share a candidate list, and a workgroup.

/// Pixels along a side of a tile, which is a workgroup; a layout test compares it with the shaders.
pub(crate) const TILE: u32 = 8;

/// Entries that share a minimum depth; lists are padded to multiples of it.
pub(crate) const CHUNK: usize = 8;

/// The level at which one tile covers the whole image.
pub(crate) const WHOLE: u32 = 31;
