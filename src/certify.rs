//! The CPU twin of the certified kernel, and the records that the host computes for both. docs/certificate.md derives
//! every bound.
//!
//! The kernel computes a pixel in f32 and either certifies the answer or marks it as undecided. Ray directions are (x,
//! y, -1), slopes instead of u, v, d, so t is the planar depth. A sphere entirely in front of the eye plane (nearly all
//! are) is represented by its projected centre, any other by its centre and power.

mod answer;
pub(crate) mod binned;
pub(crate) mod constants;
pub(crate) mod cut;
mod entry;
pub(crate) mod general;
pub(crate) mod general_lists;
pub(crate) mod given;
pub(crate) mod grouped;
pub(crate) mod placing;
mod placing_record;
pub(crate) mod planes;
pub(crate) mod projected;
mod projection;
mod records;
mod reference;
pub(crate) mod sieve;
pub(crate) mod surface;
mod terms;
#[cfg(test)]
mod tests;
pub(crate) mod tiles;

use crate::number::Number;
use crate::view::ViewRecord;
use binned::BinnedScene;
use constants::VANISH;
use general::{General, general_answer, general_low};
use general_lists::GeneralLists;
use planes::PlaneRecords;
use projected::{Projected, projected_answer, projected_low};
use std::ops::Range;
use tiles::Lists;

pub(crate) use answer::{Answer, ProjectionRecord, Slopes};
pub(crate) use general::GENERAL;
pub(crate) use terms::{TERMS, Terms};

/// The scene as the certified kernel reads it, in the number type of a twin.
pub(crate) struct Certify<'a, R> {
    pub(crate) view: &'a ViewRecord,
    pub(crate) projection: &'a ProjectionRecord,
    pub(crate) lists: &'a Lists,
    pub(crate) generals: Vec<General<R>>,
    pub(crate) general_lists: &'a GeneralLists,
    pub(crate) terms: &'a Terms,
    /// The planes that cut spheres.
    pub(crate) planes: Option<&'a PlaneRecords>,
}

impl<'a, R: Number> Certify<'a, R> {
    pub(crate) fn new(view: &'a ViewRecord, binned: &'a BinnedScene) -> Self {
        let generals = binned.generals.iter().map(General::new).collect();
        let BinnedScene { projection, lists, general_lists, planes, .. } = binned;
        Self { view, projection, lists, generals, general_lists, terms: &TERMS, planes: planes.as_ref() }
    }
}

impl<R: Number> Certify<'_, R> {
    /// The ray of row `i`, column `j` of the view's frame.
    #[inline(always)]
    pub(crate) fn slopes(&self, i: u32, j: u32) -> Slopes<R> {
        let (row, column) = (i as i32, j as i32);
        // A frame has at most 2^20 rows and columns.
        let x = R::from_i32(2 * column + 1 - self.view.width as i32) * R::from_f32(self.projection.slope[0]);
        let y = R::from_i32(self.view.height as i32 - 1 - 2 * row) * R::from_f32(self.projection.slope[1]);
        let a = R::ONE + x * x + y * y;
        Slopes { x, y, a, inverse: R::ONE / a, row, column }
    }

    /// The lower bounds of depth for a range of list entries, with their slots.
    fn lows(&self, s: &Slopes<R>, entries: Range<usize>) -> impl Iterator<Item = (R, u32)> {
        entries.map(|n| (projected_low(s, self.projection, &self.projected(n)), n as u32))
    }

    /// The same for the general spheres of the ray's tile.
    pub(crate) fn general_lows(&self, s: &Slopes<R>) -> impl Iterator<Item = (R, u32)> {
        let low = |slot: &u32| (self.general_low(s, &self.generals[*slot as usize]), GENERAL | *slot);
        let [row, column] = self.pixel(s);
        self.general_lists.of(row, column).iter().map(low)
    }

    fn general_low(&self, s: &Slopes<R>, general: &General<R>) -> R {
        // A cut sphere around the eye is hit at any depth from 0, or not at all.
        let is_open = general.rank > 0 && !R::ZERO.less(general.power);
        if is_open { R::ZERO } else { general_low(s, general, self.terms) }
    }

    /// The lower bound of depth of every candidate with its slot; certain misses are omitted.
    pub(crate) fn candidates(&self, s: &Slopes<R>) -> impl Iterator<Item = (R, u32)> {
        let projected = self.lows(s, self.entries(s));
        self.general_lows(s).chain(projected).filter(|(low, _)| *low < R::MISS)
    }

    /// The list entries of the ray's tile.
    fn entries(&self, s: &Slopes<R>) -> Range<usize> {
        let [row, column] = self.pixel(s);
        let [first, end] = self.lists.range(row, column);
        first as usize..end as usize
    }

    /// Row and column of the ray's pixel.
    fn pixel(&self, s: &Slopes<R>) -> [u32; 2] {
        self.view.pixel_of([s.row, s.column].map(|n| n as u32))
    }

    /// The sphere of a list entry.
    #[inline(always)]
    pub(crate) fn projected(&self, entry: usize) -> Projected<R> {
        Projected::new(&self.lists.projected[entry], &self.lists.details[entry])
    }

    /// Whether the answer is certified: hit, root and normal are certain, no other candidate can be as near (by the two
    /// smallest lower bounds), and the depth is within tolerance. A depth that may have lost bits to underflow is never
    /// certified, nor is one that is not in front of all that a search may skip: so the result does not depend on what is
    /// skipped.
    #[inline(always)]
    pub(crate) fn certain(&self, answer: &Answer<R>, [low, second]: [R; 2]) -> bool {
        let reference = R::from_f32(self.projection.depth);
        let depth = reference + answer.low;
        // & instead of &&: there is nothing to skip, and compilers can vectorize it.
        let sharp =
            (answer.depth_interval < R::from_f32(self.projection.tolerance) * depth) & (depth > R::from_f32(VANISH));
        let in_front = answer.high - low < R::from_f32(self.projection.cull_margin) * (reference + low);
        answer.sure & (answer.high < second) & sharp & in_front
    }

    /// The answer of the sphere in a slot, with its bounds.
    pub(crate) fn answer(&self, s: &Slopes<R>, slot: u32) -> Answer<R> {
        let place = (slot & !GENERAL) as usize;
        if slot & GENERAL != 0 {
            return general_answer(s, &self.generals[place], self.terms);
        }
        projected_answer(s, self.projection, &self.projected(place), self.terms)
    }

    /// The depth in the frame's unit to which the answer of the sphere in a slot is relative: the depth of its centre, or 0.
    #[inline(always)]
    pub(crate) fn center_depth(&self, slot: u32) -> f64 {
        if slot & GENERAL != 0 { 0.0 } else { self.lists.depths[slot as usize] }
    }

    /// The depth in the frame's unit to which depths of lists, and of planes, are relative.
    #[inline(always)]
    pub(crate) fn reference(&self) -> f64 {
        self.projection.depth.into()
    }

    /// The place of a slot's sphere among those that planes cut ([`planes::Ranks`]); 0 for a whole one.
    #[inline(always)]
    pub(crate) fn rank(&self, slot: u32) -> u32 {
        let place = (slot & !GENERAL) as usize;
        let of_entry = || self.planes.map_or(0, |planes| planes.of_entries[place]);
        if slot & GENERAL != 0 { self.generals[place].rank } else { of_entry() }
    }

    /// The id of the sphere in a slot.
    pub(crate) fn id(&self, slot: u32) -> u32 {
        let place = (slot & !GENERAL) as usize;
        if slot & GENERAL != 0 { self.generals[place].id } else { self.lists.details[place].id }
    }
}
