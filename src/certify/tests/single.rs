//! The search for one ray at a time, in any arithmetic. Tests in src/cpu/certified.rs compare its strips of rays with it.

use crate::certify::constants::BEYOND;
use crate::certify::{Answer, Certify, Slopes};
use crate::number::Number;
use crate::tile::CHUNK;
use crate::view::ray::NONE;

/// The two smallest lower bounds of depth, and the sphere of the smallest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearestTwo<R> {
    pub(crate) low: R,
    pub(crate) second: R,
    pub(crate) slot: u32,
}

impl<R: Number> NearestTwo<R> {
    fn keep(&mut self, (low, slot): (R, u32)) {
        if low < self.low {
            *self = Self { low, second: self.low, slot };
        } else if low < self.second {
            self.second = low;
        }
    }
}

impl<R: Number> Certify<'_, R> {
    /// The two smallest lower bounds.
    pub(crate) fn nearest_two(&self, s: &Slopes<R>) -> NearestTwo<R> {
        let mut k = NearestTwo { low: R::from_f32(BEYOND), second: R::from_f32(BEYOND), slot: NONE };
        self.general_lows(s).for_each(|candidate| k.keep(candidate));
        for first in self.entries(s).step_by(CHUNK) {
            let chunk_min_depth = R::from_f32(self.lists.chunk_min_depths[first / CHUNK]);
            if chunk_min_depth - k.low
                > R::from_f32(self.projection.cull_margin) * (R::from_f32(self.projection.depth) + k.low)
            {
                // All further spheres of the list are behind the winner.
                k.second = if chunk_min_depth < k.second { chunk_min_depth } else { k.second };
                break;
            }
            self.lows(s, first..first + CHUNK).for_each(|candidate| k.keep(candidate));
        }
        k
    }

    /// Certifies the winner by its own bounds.
    pub(crate) fn certify_winner(&self, s: &Slopes<R>, k: &NearestTwo<R>) -> Answer<R> {
        self.answer(s, k.slot)
    }
}
