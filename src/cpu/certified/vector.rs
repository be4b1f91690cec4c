//! Loops over lanes that compilers make vectors of.

use crate::tile::TILE;

/// Pixels that are computed together: one row of a tile.
pub(super) const LANES: usize = TILE as usize;

#[inline(always)]
pub(super) fn mask(yes: bool) -> u32 {
    u32::from(yes).wrapping_neg()
}

/// `yes` where the mask is set, else `no`.
#[inline(always)]
pub(super) fn pick(mask: u32, yes: f32, no: f32) -> f32 {
    f32::from_bits(no.to_bits() ^ ((no.to_bits() ^ yes.to_bits()) & mask))
}
