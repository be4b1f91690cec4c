//! The rays of a strip: the search and the certificate, in loops over lanes.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use crate::certify::constants::BEYOND;
use crate::certify::general::{general_answer, general_low};
use crate::certify::projected::{Projected, ProjectedDetailRecord, ProjectedRecord, projected_answer, projected_low};
use crate::certify::tiles::{NO_DETAIL, NOTHING};
use crate::certify::{Answer, Certify, GENERAL, Slopes};
use crate::number::vector::{Bits, pick};
use crate::tile::{CHUNK, TILE};
use crate::view::ray::NONE;

/// The rays of a strip, one array per component: whole rows of a tile, one after the other.
pub(super) struct Strip<const N: usize> {
    x: [f32; N],
    y: [f32; N],
    a: [f32; N],
    inverse: [f32; N],
    row: [i32; N],
    column: [i32; N],
}

/// The two smallest lower bounds of depth per lane, and the entry with the smallest.
#[derive(Clone, Copy)]
pub(super) struct NearestTwos<const N: usize> {
    pub(super) low: [f32; N],
    pub(super) second: [f32; N],
    pub(super) slot: [u32; N],
}

impl<const N: usize> Strip<N> {
    /// The rays of the pixels from row `i` and column `first` of the view's frame on.
    #[inline(always)]
    pub(super) fn new(certify: &Certify<'_, f32>, [i, first]: [u32; 2]) -> Self {
        let (mut row, mut column) = ([0; N], [0; N]);
        for l in 0..N {
            (row[l], column[l]) = (i + l as u32 / TILE, first + l as u32 % TILE);
        }
        if !certify.view.is_plain() {
            for l in 0..N {
                [row[l], column[l]] = certify.view.sample_position(row[l], column[l]);
            }
        }
        let (mut x, mut y, mut a, mut inverse) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
        // Not array::from_fn, which compilers leave as a call.
        for l in 0..N {
            let s = certify.slopes(row[l], column[l]);
            (x[l], y[l], a[l], inverse[l]) = (s.x, s.y, s.a, s.inverse);
        }
        Self { x, y, a, inverse, row: row.map(|n| n as i32), column: column.map(|n| n as i32) }
    }

    #[inline(always)]
    pub(super) fn slopes(&self, shift: u32, l: usize) -> Slopes<f32> {
        let (x, y, a, inverse) = (self.x[l], self.y[l], self.a[l], self.inverse[l]);
        let (row, column) = (self.row[l], self.column[l]);
        Slopes { x, y, a, inverse, row, column, fixed_row: row << shift, fixed_column: column << shift }
    }

    /// The two smallest lower bounds of depth among the general spheres and the lists of a tile, nearest first. On a device spheres
    /// leave the same in the pixels (shaders/splat/splat.wgsl).
    #[inline(always)]
    pub(super) fn nearest_two(&self, certify: &Certify<'_, f32>, [i, first]: [u32; 2]) -> NearestTwos<N> {
        let mut k = NearestTwos::NONE;
        let (projection, terms, lists) = (certify.projection, *certify.terms, certify.lists);
        for &slot in certify.general_lists.of(i, first) {
            // Copies: of what a reference leads to, compilers may expect that the loop changes it.
            let general = certify.generals[slot as usize];
            let mut lows = [0.0; N];
            for (l, low) in lows.iter_mut().enumerate() {
                *low = general_low(&self.slopes(projection.shift, l), &general, &terms);
            }
            for (l, low) in lows.into_iter().enumerate() {
                k.keep(l, low, GENERAL | slot);
            }
        }
        let [first, end] = lists.range(i, first).map(|n| n as usize);
        let chunks =
            lists.projected[first..end].chunks_exact(CHUNK).zip(&lists.chunk_min_depths[first / CHUNK..end / CHUNK]);
        for (n, (chunk, &chunk_min_depth)) in chunks.enumerate() {
            let mut behind = true;
            for l in 0..N {
                let own = chunk_min_depth - k.low[l] > projection.cull_margin * (projection.depth + k.low[l]);
                k.second[l] = pick(u32::all_if(own & (chunk_min_depth < k.second[l])), chunk_min_depth, k.second[l]);
                behind &= own;
            }
            if behind {
                break;
            }
            // A local copy, which the compiler can keep in registers.
            let mut now = k;
            for (slot, projected) in (first + CHUNK * n..).zip(chunk) {
                if *projected == NOTHING {
                    break;
                }
                let sphere = Projected::<f32>::new(projected, &NO_DETAIL);
                for l in 0..N {
                    now.keep(l, projected_low(&self.slopes(projection.shift, l), projection, &sphere), slot as u32);
                }
            }
            k = now;
        }
        k
    }

    /// The certified answers of the winners.
    #[inline(always)]
    pub(super) fn certify_winners(&self, certify: &Certify<'_, f32>, k: &NearestTwos<N>) -> StripAnswers<N> {
        let mut answers = StripAnswers::default();
        if k.slot.iter().any(|slot| slot & GENERAL == 0) {
            self.certify_projected(certify, k, &mut answers);
        }
        let mut left = k.slot;
        while let Some(slot) = left.into_iter().find(|slot| slot & GENERAL != 0 && *slot != NONE) {
            self.certify_general(certify, &left, slot, &mut answers);
            for other in &mut left {
                *other = if *other == slot { NONE } else { *other };
            }
        }
        answers
    }

    /// Answers of the lanes whose winner is this general sphere. All lanes are computed, since usually all share the
    /// winner.
    #[inline(always)]
    fn certify_general(
        &self,
        certify: &Certify<'_, f32>,
        winners: &[u32; N],
        slot: u32,
        answers: &mut StripAnswers<N>,
    ) {
        let (general, terms) = (certify.generals[(slot & !GENERAL) as usize], *certify.terms);
        let shift = certify.projection.shift;
        let mut found = StripAnswers::default();
        for l in 0..N {
            found.set(l, &general_answer(&self.slopes(shift, l), &general, &terms));
        }
        answers.take(&found, |l| winners[l] == slot);
    }

    #[inline(always)]
    fn certify_projected(&self, certify: &Certify<'_, f32>, k: &NearestTwos<N>, answers: &mut StripAnswers<N>) {
        let (lists, projection, terms) = (certify.lists, *certify.projection, *certify.terms);
        let mut winners = [(NOTHING, NO_DETAIL); N];
        for l in 0..N {
            if k.slot[l] & GENERAL == 0 {
                winners[l] = (lists.projected[k.slot[l] as usize], lists.details[k.slot[l] as usize]);
            }
        }
        let (mut x, mut y, mut rho) = ([0; N], [0; N], [0.0; N]);
        let (mut offset, mut center) = ([[0.0; N]; 2], [0.0; N]);
        for l in 0..N {
            let (record, detail) = &winners[l];
            (x[l], y[l], rho[l]) = (record.x, record.y, record.rho);
            (offset[0][l], offset[1][l], center[l]) =
                (detail.subpixel_offset[0], detail.subpixel_offset[1], detail.center);
        }
        for l in 0..N {
            let sphere = ProjectedRecord { x: x[l], y: y[l], rho: rho[l], low: 0.0 };
            let detail =
                ProjectedDetailRecord { subpixel_offset: [offset[0][l], offset[1][l]], center: center[l], id: 0 };
            let sphere = Projected::<f32>::new(&sphere, &detail);
            let slopes = self.slopes(projection.shift, l);
            answers.set(l, &projected_answer(&slopes, &projection, &sphere, &terms));
        }
        for l in 0..N {
            answers.id[l] = winners[l].1.id;
        }
    }
}

/// Answers as one array per component, a layout that compilers vectorize.
pub(super) struct StripAnswers<const N: usize> {
    /// [`NONE`] where nothing is hit.
    pub(super) id: [u32; N],
    flags: [[u32; N]; 2],
    /// Offset, low, high, the depth's interval and the normal of [`Answer`].
    pub(super) numbers: [[f32; N]; 7],
}

impl<const N: usize> Default for StripAnswers<N> {
    #[inline(always)]
    fn default() -> Self {
        Self { id: [NONE; N], flags: [[0; N]; 2], numbers: [[0.0; N]; 7] }
    }
}

impl<const N: usize> StripAnswers<N> {
    #[inline(always)]
    fn set(&mut self, l: usize, a: &Answer<f32>) {
        self.id[l] = a.id;
        self.flags[0][l] = u32::from(a.sure);
        self.flags[1][l] = u32::from(a.hits);
        self.numbers[0][l] = a.offset;
        self.numbers[1][l] = a.low;
        self.numbers[2][l] = a.high;
        self.numbers[3][l] = a.depth_interval;
        self.numbers[4][l] = a.normal[0];
        self.numbers[5][l] = a.normal[1];
        self.numbers[6][l] = a.normal[2];
    }

    #[inline(always)]
    pub(super) fn get(&self, l: usize) -> Answer<f32> {
        let n = &self.numbers;
        Answer {
            sure: self.flags[0][l] != 0,
            hits: self.flags[1][l] != 0,
            id: self.id[l],
            offset: n[0][l],
            low: n[1][l],
            high: n[2][l],
            depth_interval: n[3][l],
            normal: [n[4][l], n[5][l], n[6][l]],
            #[cfg(test)]
            turn: 0.0,
        }
    }

    /// Takes over the answers of some lanes.
    #[inline(always)]
    fn take(&mut self, other: &Self, lane: impl Fn(usize) -> bool) {
        let mut lanes = [0; N];
        for l in 0..N {
            lanes[l] = u32::all_if(lane(l));
            self.id[l] ^= (self.id[l] ^ other.id[l]) & lanes[l];
        }
        for k in 0..2 {
            for l in 0..N {
                self.flags[k][l] ^= (self.flags[k][l] ^ other.flags[k][l]) & lanes[l];
            }
        }
        for k in 0..7 {
            for l in 0..N {
                self.numbers[k][l] = pick(lanes[l], other.numbers[k][l], self.numbers[k][l]);
            }
        }
    }
}

impl<const N: usize> NearestTwos<N> {
    pub(super) const NONE: Self = Self { low: [BEYOND; N], second: [BEYOND; N], slot: [NONE; N] };

    /// The depths of the winners' centres, to which their answers are relative.
    #[inline(always)]
    pub(super) fn depths(&self, certify: &Certify<'_, f32>) -> [f64; N] {
        let mut depths = [0.0; N];
        for l in 0..N {
            depths[l] = certify.center_depth(self.slot[l]);
        }
        depths
    }

    #[inline(always)]
    fn keep(&mut self, l: usize, low: f32, slot: u32) {
        // Selects by masks and writes unconditionally: compilers may turn a comparison into a masked store, which
        // delays the loads that follow it.
        let before = self.low[l];
        let nearer = u32::all_if(low < before);
        self.low[l] = pick(nearer, low, before);
        self.slot[l] ^= (self.slot[l] ^ slot) & nearer;
        let farther = pick(nearer, before, low);
        self.second[l] = pick(u32::all_if(farther < self.second[l]), farther, self.second[l]);
    }
}
