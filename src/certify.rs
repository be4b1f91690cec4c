//! The certified kernel's CPU twin and what the host prepares for both: docs/certificate.md derives every bound.
//!
//! The kernel answers a pixel in f32 and proves the answer, or says that it cannot. Directions are (x, y, -1): slopes
//! instead of u, v, d, so that t is the planar depth. Spheres wholly in front of the eye plane (nearly all) are given by
//! their projected centre, the others by centre and power.

pub(crate) mod binned;
pub(crate) mod front;
mod lens;
pub(crate) mod near;
#[cfg(test)]
mod tests;
pub(crate) mod tiles;

use crate::ray::NONE;
use crate::real::Real;
use crate::view::ViewRecord;
use binned::BinnedScene;
use bytemuck::{Pod, Zeroable};
use front::{Front, front_answer, front_low};
use near::{Near, near_answer, near_low};
use std::ops::Range;
use tiles::Lists;

/// The kernel's second uniform; certify/lens.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct LensRecord {
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
    pub(crate) nears: u32,
    pub(crate) slack: f32,
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
    /// |d|^2 rho^2 of a front sphere: alone, and for each unit of |d|^2 - 1.
    pub(crate) ball: [f32; 2],
    /// The offset's square, likewise.
    pub(crate) offset: [f32; 2],
    /// The depth of a front sphere: whole, for each unit of |d|^2 - 1, slope along the offset, root, centre.
    pub(crate) depth: [f32; 5],
    /// p.d of a near sphere: where it starts, and how it goes on.
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
    ball: [9.0, 13.0],
    offset: [10.0, 17.2],
    depth: [12.0, 6.0, 6.0, 6.2, 3.5],
    along: [2.5, 3.5],
    power: [3.0, 6.0, -0.5],
    cross: [7.0, 2.0, 5.0, 4.0],
    root: [15.0, 6.0, 11.0],
    host: 1.0,
};

/// 2^-23: WGSL rounds either way.
const UNIT: f32 = 1.192_092_9e-7;
/// 2^-48: what the host's f64 rotation leaves in a near sphere.
const HOST: f32 = 3.552_713_7e-15;
/// 2^-43: and in a front sphere's depth, of itself.
const DEPTH: f32 = 1.136_868_4e-13;
/// 1 + 2^-10: the bounds are computed in f32 themselves.
const INFLATE: f32 = 1.000_976_6;
/// 2^-100: what flushed subnormals leave, times |d|^2.
pub(crate) const VANISH: f32 = 7.888_609e-31;
/// No point of a sphere is as deep in its record's unit: |p| and r are below 2 in every component.
const FAR: f32 = 8.0;
/// The depth of nothing: above every lower bound, and so far below the largest f32 that no sum with a depth overflows.
/// Lower bounds are below 2^124: a frame spans 2^240, and its unit is in the middle.
pub(crate) const BEYOND: f32 = 8.507_059e37;
/// Radians promised, less the roundings of the unit vector.
const NORMAL: f32 = 0.97e-3;

/// A winner's answer. The depth is the centre's depth (0 for a near sphere) plus offset; it lies between low and high.
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
    pub(crate) width: R,
    pub(crate) normal: [R; 3],
}

impl<R: Real> Answer<R> {
    /// What is written where nobody can be hit.
    pub(crate) const MISS: Self = Self {
        sure: true,
        hits: true,
        id: NONE,
        offset: R::MISS,
        low: R::ZERO,
        high: R::ZERO,
        width: R::ZERO,
        normal: [R::ZERO; 3],
    };
}

/// Marks a slot in the list of near spheres.
pub(crate) const NEAR: u32 = 0x8000_0000;

/// The scene as the certified kernel sees it, in the arithmetic of a twin.
pub(crate) struct Certify<'a, R> {
    pub(crate) view: &'a ViewRecord,
    pub(crate) lens: &'a LensRecord,
    pub(crate) lists: &'a Lists,
    pub(crate) nears: Vec<Near<R>>,
    pub(crate) terms: &'a Terms,
}

impl<'a, R: Real> Certify<'a, R> {
    pub(crate) fn new(view: &'a ViewRecord, binned: &'a BinnedScene) -> Self {
        let nears = binned.nears.iter().map(Near::new).collect();
        Self { view, lens: &binned.lens, lists: &binned.lists, nears, terms: &TERMS }
    }
}

impl<R: Real> Certify<'_, R> {
    /// The ray of row `i`, column `j` of the view's frame.
    #[inline(always)]
    pub(crate) fn slopes(&self, i: u32, j: u32) -> Slopes<R> {
        let odd = |n: i64| R::exact(n as f32);
        let x = odd(2 * i64::from(j) + 1 - i64::from(self.view.width)) * R::exact(self.lens.slope_x);
        let y = odd(i64::from(self.view.height) - 1 - 2 * i64::from(i)) * R::exact(self.lens.slope_y);
        let a = R::ONE + x * x + y * y;
        let (row, column) = (i as i32, j as i32);
        let shift = self.lens.shift;
        let (fixed_row, fixed_column) = (row << shift, column << shift);
        Slopes { x, y, a, inverse: R::ONE / a, row, column, fixed_row, fixed_column }
    }

    /// The lower bounds of depth of a run of list entries, with their slots.
    fn lows(&self, s: &Slopes<R>, entries: Range<usize>) -> impl Iterator<Item = (R, u32)> {
        entries.map(|n| (front_low(s, self.lens, &self.front(n)), n as u32))
    }

    /// The same of the near spheres.
    pub(crate) fn near_lows(&self, s: &Slopes<R>) -> impl Iterator<Item = (R, u32)> {
        self.nears.iter().zip(0..).map(|(near, slot)| (near_low(s, near, self.terms), NEAR | slot))
    }

    /// Every candidate's lower bound of depth, with its slot; certain misses are left out.
    pub(crate) fn candidates(&self, s: &Slopes<R>) -> impl Iterator<Item = (R, u32)> {
        let fronts = self.lows(s, self.entries(s));
        self.near_lows(s).chain(fronts).filter(|(low, _)| *low < R::MISS)
    }

    /// The list entries of the ray's tile.
    fn entries(&self, s: &Slopes<R>) -> Range<usize> {
        let [row, column] = [s.row, s.column].map(|n| n as u32 / self.view.fine());
        let [first, end] = self.lists.range(row, column);
        first as usize..end as usize
    }

    fn front(&self, entry: usize) -> Front<R> {
        Front::new(&self.lists.fronts[entry], &self.lists.mores[entry])
    }

    /// Hit, root and normal are certain, nobody else, from the second smallest lower bound on, can be as near, and the
    /// depth is as sharp as promised. A depth that may have lost bits below the normal numbers never is.
    pub(crate) fn certain(&self, answer: &Answer<R>, second: R) -> bool {
        let depth = R::exact(self.lens.depth) + answer.low;
        let sharp = answer.width < R::exact(self.lens.tolerance) * depth && depth > R::exact(VANISH);
        answer.sure && answer.high < second && sharp
    }

    /// What the sphere in a slot answers, with its bounds.
    pub(crate) fn answer(&self, s: &Slopes<R>, slot: u32) -> Answer<R> {
        let place = (slot & !NEAR) as usize;
        if slot & NEAR != 0 {
            return near_answer(s, &self.nears[place], self.terms);
        }
        front_answer(s, self.lens, &self.front(place), self.terms)
    }

    /// The id in a slot.
    pub(crate) fn id(&self, slot: u32) -> u32 {
        let place = (slot & !NEAR) as usize;
        if slot & NEAR != 0 { self.nears[place].id } else { self.lists.mores[place].id }
    }
}
