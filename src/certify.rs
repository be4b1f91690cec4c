//! The CPU twin of the certified kernel, and the records that the host computes for both. docs/certificate.md derives
//! every bound.
//!
//! The kernel computes a pixel in f32 and either certifies the answer or marks it as undecided. Ray directions are (x,
//! y, -1), slopes instead of u, v, d, so t is the planar depth. A sphere entirely in front of the eye plane (nearly all
//! are) is represented by its projected centre, any other by its centre and power.

pub(crate) mod binned;
pub(crate) mod constants;
pub(crate) mod general;
pub(crate) mod projected;
mod projection;
#[cfg(test)]
mod tests;
pub(crate) mod tiles;

use crate::number::Number;
use crate::view::ViewRecord;
use crate::view::ray::NONE;
use binned::BinnedScene;
use bytemuck::{Pod, Zeroable};
use constants::{
    AC, AC_A, ALONG, AR2, AR2_A, B2, CENTER, G, GG, OFFSET2, OFFSET2_SLANT, QUOTIENT, RHO2, RHO2_SLANT, ROOT, START,
    STEP, SUM, SUM_A, TOTAL, TOTAL_SLANT, VANISH,
};
use general::{General, general_answer, general_low};
use projected::{Projected, projected_answer, projected_low};
use std::ops::Range;
use tiles::Lists;

/// The kernel's second uniform buffer, declared in certify/projection.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct ProjectionRecord {
    pub(crate) slope_x: f32,
    pub(crate) slope_y: f32,
    pub(crate) step_x: f32,
    pub(crate) step_y: f32,
    pub(crate) fixed_x: f32,
    pub(crate) fixed_y: f32,
    pub(crate) shift: u32,
    pub(crate) unit: f32,
    pub(crate) error0: f32,
    pub(crate) error1: f32,
    pub(crate) error2: f32,
    pub(crate) edge: f32,
    pub(crate) depth: f32,
    pub(crate) tolerance: f32,
    pub(crate) generals: u32,
    pub(crate) cull_margin: f32,
    pub(crate) size: f32,
}

/// The quantities of one ray: slopes, |d|^2 and its reciprocal, the pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slopes<R> {
    pub(crate) x: R,
    pub(crate) y: R,
    pub(crate) a: R,
    pub(crate) inverse: R,
    pub(crate) row: i32,
    pub(crate) column: i32,
    pub(crate) fixed_row: i32,
    pub(crate) fixed_column: i32,
}

/// The constants of the bounds, in units of the last place (docs/certificate.md). A test removes each in turn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms {
    /// |d|^2 rho^2 of a projected sphere: constant part, and part per unit of |d|^2 - 1.
    pub(crate) rho2: [f32; 2],
    /// The square of the offset, likewise.
    pub(crate) offset2: [f32; 2],
    /// The depth of a projected sphere: total, total per unit of |d|^2 - 1, slope along the offset, root, centre.
    pub(crate) depth: [f32; 5],
    /// p.d of a general sphere: the start value, and the increment.
    pub(crate) along: [f32; 2],
    /// b^2; |a c| per unit of |d|^2 and constant.
    pub(crate) power: [f32; 3],
    /// a r^2 per unit of |d|^2 and constant; g.g; a component of g.
    pub(crate) cross: [f32; 4],
    /// The quotient; the sum per unit of |d|^2 and constant.
    pub(crate) root: [f32; 3],
    /// Rounding on the host: projected centres, in units of their own last place.
    pub(crate) host: f32,
}

/// The derived constants.
pub(crate) const TERMS: Terms = Terms {
    rho2: [RHO2, RHO2_SLANT],
    offset2: [OFFSET2, OFFSET2_SLANT],
    depth: [TOTAL, TOTAL_SLANT, ALONG, ROOT, CENTER],
    along: [START, STEP],
    power: [B2, AC_A, AC],
    cross: [AR2_A, AR2, GG, G],
    root: [QUOTIENT, SUM_A, SUM],
    host: 1.0,
};

/// The answer for a winner. The depth is the centre's depth (0 for a general sphere) plus the offset; it lies between
/// low and high.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer<R> {
    /// Hit, root, depth and normal are within the promised tolerance. Excludes the order of the hits.
    pub(crate) sure: bool,
    /// The hit is certain; nothing else need be.
    pub(crate) hits: bool,
    pub(crate) id: u32,
    pub(crate) offset: R,
    pub(crate) low: R,
    pub(crate) high: R,
    /// Bound of the error of the returned depth.
    pub(crate) depth_interval: R,
    pub(crate) normal: [R; 3],
}

impl<R: Number> Answer<R> {
    /// The answer of a pixel that no sphere covers.
    pub(crate) const MISS: Self = Self {
        sure: true,
        hits: true,
        id: NONE,
        offset: R::MISS,
        low: R::ZERO,
        high: R::ZERO,
        depth_interval: R::ZERO,
        normal: [R::ZERO; 3],
    };
}

/// Marks a slot that refers to the list of general spheres.
pub(crate) const GENERAL: u32 = 0x8000_0000;

/// The scene as the certified kernel reads it, in the number type of a twin.
pub(crate) struct Certify<'a, R> {
    pub(crate) view: &'a ViewRecord,
    pub(crate) projection: &'a ProjectionRecord,
    pub(crate) lists: &'a Lists,
    pub(crate) generals: Vec<General<R>>,
    pub(crate) terms: &'a Terms,
}

impl<'a, R: Number> Certify<'a, R> {
    pub(crate) fn new(view: &'a ViewRecord, binned: &'a BinnedScene) -> Self {
        let generals = binned.generals.iter().map(General::new).collect();
        Self { view, projection: &binned.projection, lists: &binned.lists, generals, terms: &TERMS }
    }
}

impl<R: Number> Certify<'_, R> {
    /// The ray of row `i`, column `j` of the view's frame.
    #[inline(always)]
    pub(crate) fn slopes(&self, i: u32, j: u32) -> Slopes<R> {
        let odd = |n: i64| R::from_f32(n as f32);
        let x = odd(2 * i64::from(j) + 1 - i64::from(self.view.width)) * R::from_f32(self.projection.slope_x);
        let y = odd(i64::from(self.view.height) - 1 - 2 * i64::from(i)) * R::from_f32(self.projection.slope_y);
        let a = R::ONE + x * x + y * y;
        let (row, column) = (i as i32, j as i32);
        let shift = self.projection.shift;
        let (fixed_row, fixed_column) = (row << shift, column << shift);
        Slopes { x, y, a, inverse: R::ONE / a, row, column, fixed_row, fixed_column }
    }

    /// The lower bounds of depth for a range of list entries, with their slots.
    fn lows(&self, s: &Slopes<R>, entries: Range<usize>) -> impl Iterator<Item = (R, u32)> {
        entries.map(|n| (projected_low(s, self.projection, &self.projected(n)), n as u32))
    }

    /// The same for the general spheres.
    pub(crate) fn general_lows(&self, s: &Slopes<R>) -> impl Iterator<Item = (R, u32)> {
        self.generals.iter().zip(0..).map(|(general, slot)| (general_low(s, general, self.terms), GENERAL | slot))
    }

    /// The lower bound of depth of every candidate with its slot; certain misses are omitted.
    pub(crate) fn candidates(&self, s: &Slopes<R>) -> impl Iterator<Item = (R, u32)> {
        let projected = self.lows(s, self.entries(s));
        self.general_lows(s).chain(projected).filter(|(low, _)| *low < R::MISS)
    }

    /// The list entries of the ray's tile.
    fn entries(&self, s: &Slopes<R>) -> Range<usize> {
        let [row, column] = [s.row, s.column].map(|n| n as u32 / self.view.fine());
        let [first, end] = self.lists.range(row, column);
        first as usize..end as usize
    }

    fn projected(&self, entry: usize) -> Projected<R> {
        Projected::new(&self.lists.projected[entry], &self.lists.details[entry])
    }

    /// Whether the answer is certified: hit, root and normal are certain, no other candidate can be as near (by the
    /// second smallest lower bound), and the depth is within tolerance. A depth that may have lost bits to underflow is
    /// never certified.
    pub(crate) fn certain(&self, answer: &Answer<R>, second: R) -> bool {
        let depth = R::from_f32(self.projection.depth) + answer.low;
        let sharp =
            answer.depth_interval < R::from_f32(self.projection.tolerance) * depth && depth > R::from_f32(VANISH);
        answer.sure && answer.high < second && sharp
    }

    /// The answer of the sphere in a slot, with its bounds.
    pub(crate) fn answer(&self, s: &Slopes<R>, slot: u32) -> Answer<R> {
        let place = (slot & !GENERAL) as usize;
        if slot & GENERAL != 0 {
            return general_answer(s, &self.generals[place], self.terms);
        }
        projected_answer(s, self.projection, &self.projected(place), self.terms)
    }

    /// The id of the sphere in a slot.
    pub(crate) fn id(&self, slot: u32) -> u32 {
        let place = (slot & !GENERAL) as usize;
        if slot & GENERAL != 0 { self.generals[place].id } else { self.lists.details[place].id }
    }
}
