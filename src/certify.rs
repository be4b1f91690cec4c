//! The certified kernel's CPU twin and what the host prepares for both: docs/certificate.md derives every bound.
//!
//! The kernel answers a pixel in f32 and proves the answer, or says that it cannot. Directions are (x, y, -1): slopes
//! instead of u, v, d, so that t is the planar depth. Spheres wholly in front of the eye plane (nearly all) are given by
//! their projected centre, the others by centre and power.

pub(crate) mod binned;
pub(crate) mod constants;
pub(crate) mod general;
pub(crate) mod projected;
mod projection;
#[cfg(test)]
mod tests;
pub(crate) mod tiles;

use crate::number::Number;
use crate::ray::NONE;
use crate::view::ViewRecord;
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

/// The kernel's second uniform; certify/projection.wgsl declares it.
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

/// What one ray needs: slopes, |d|^2 and its reciprocal, the pixel.
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

/// The constants of the bounds, in units of the last place (docs/certificate.md). A test takes them away one by one.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms {
    /// |d|^2 rho^2 of a projected sphere: alone, and for each unit of |d|^2 - 1.
    pub(crate) rho2: [f32; 2],
    /// The offset's square, likewise.
    pub(crate) offset2: [f32; 2],
    /// The depth of a projected sphere: whole, for each unit of |d|^2 - 1, slope along the offset, root, centre.
    pub(crate) depth: [f32; 5],
    /// p.d of a general sphere: where it starts, and how it goes on.
    pub(crate) along: [f32; 2],
    /// b^2, and |a c| for each unit of |d|^2 and alone.
    pub(crate) power: [f32; 3],
    /// a r^2 for each unit of |d|^2 and alone, g.g, and a component of g.
    pub(crate) cross: [f32; 4],
    /// Quotient, and sum for each unit of |d|^2 and alone.
    pub(crate) root: [f32; 3],
    /// What the host rounds: projected centres, in the unit of their own last place.
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

/// A winner's answer. The depth is the centre's depth (0 for a general sphere) plus offset; it lies between low and high.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer<R> {
    /// Hit, root, depth and normal are within their promise; order is not judged here.
    pub(crate) sure: bool,
    /// The hit alone is certain.
    pub(crate) hits: bool,
    pub(crate) id: u32,
    pub(crate) offset: R,
    pub(crate) low: R,
    pub(crate) high: R,
    /// How far the depth given out may be from the true one.
    pub(crate) depth_interval: R,
    pub(crate) normal: [R; 3],
}

impl<R: Number> Answer<R> {
    /// What is written where nobody can be hit.
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

/// Marks a slot in the list of general spheres.
pub(crate) const GENERAL: u32 = 0x8000_0000;

/// The scene as the certified kernel sees it, in the arithmetic of a twin.
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

    /// The lower bounds of depth of a run of list entries, with their slots.
    fn lows(&self, s: &Slopes<R>, entries: Range<usize>) -> impl Iterator<Item = (R, u32)> {
        entries.map(|n| (projected_low(s, self.projection, &self.projected(n)), n as u32))
    }

    /// The same of the general spheres.
    pub(crate) fn general_lows(&self, s: &Slopes<R>) -> impl Iterator<Item = (R, u32)> {
        self.generals.iter().zip(0..).map(|(general, slot)| (general_low(s, general, self.terms), GENERAL | slot))
    }

    /// Every candidate's lower bound of depth, with its slot; certain misses are left out.
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

    /// Hit, root and normal are certain, nobody else, from the second smallest lower bound on, can be as near, and the
    /// depth is as sharp as promised. A depth that may have lost bits below the normal numbers never is.
    pub(crate) fn certain(&self, answer: &Answer<R>, second: R) -> bool {
        let depth = R::from_f32(self.projection.depth) + answer.low;
        let sharp =
            answer.depth_interval < R::from_f32(self.projection.tolerance) * depth && depth > R::from_f32(VANISH);
        answer.sure && answer.high < second && sharp
    }

    /// What the sphere in a slot answers, with its bounds.
    pub(crate) fn answer(&self, s: &Slopes<R>, slot: u32) -> Answer<R> {
        let place = (slot & !GENERAL) as usize;
        if slot & GENERAL != 0 {
            return general_answer(s, &self.generals[place], self.terms);
        }
        projected_answer(s, self.projection, &self.projected(place), self.terms)
    }

    /// The id in a slot.
    pub(crate) fn id(&self, slot: u32) -> u32 {
        let place = (slot & !GENERAL) as usize;
        if slot & GENERAL != 0 { self.generals[place].id } else { self.lists.details[place].id }
    }
}
