//! The search for one ray at a time, in any arithmetic. Tests in src/cpu/certified.rs compare its strips of rays with it.

use crate::certify::{Answer, BEYOND, Certify, Slopes};
use crate::ray::NONE;
use crate::real::Real;
use crate::tile::CHUNK;

/// The two smallest lower bounds of depth, and the sphere of the smallest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kept<R> {
    pub(crate) low: R,
    pub(crate) second: R,
    pub(crate) slot: u32,
}

impl<R: Real> Kept<R> {
    fn keep(&mut self, (low, slot): (R, u32)) {
        if low < self.low {
            *self = Self { low, second: self.low, slot };
        } else if low < self.second {
            self.second = low;
        }
    }
}

impl<R: Real> Certify<'_, R> {
    /// The two smallest lower bounds.
    pub(crate) fn kept(&self, s: &Slopes<R>) -> Kept<R> {
        let mut k = Kept { low: R::exact(BEYOND), second: R::exact(BEYOND), slot: NONE };
        self.near_lows(s).for_each(|candidate| k.keep(candidate));
        for first in self.entries(s).step_by(CHUNK) {
            let sill = R::exact(self.lists.sills[first / CHUNK]);
            if sill - k.low > R::exact(self.lens.slack) * (R::exact(self.lens.depth) + k.low) {
                // All further spheres of the list are behind.
                k.second = if sill < k.second { sill } else { k.second };
                break;
            }
            self.lows(s, first..first + CHUNK).for_each(|candidate| k.keep(candidate));
        }
        k
    }

    /// Certifies the winner, by its own bounds.
    pub(crate) fn judge(&self, s: &Slopes<R>, k: &Kept<R>) -> Answer<R> {
        self.answer(s, k.slot)
    }
}
