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

/// The spheres that each lane passes through: it looks for the nearest of the others.
pub(super) trait Passed<const N: usize> {
    /// All bits in the lanes that pass through the sphere `id`.
    fn lanes(&self, id: impl Fn() -> u32) -> [u32; N];
}

/// No sphere is passed: the rays look for first hits.
pub(super) struct NonePassed;

impl<const N: usize> Passed<N> for NonePassed {
    #[inline(always)]
    fn lanes(&self, _: impl Fn() -> u32) -> [u32; N] {
        [0; N]
    }
}

/// The hits before: of each the spheres of all lanes.
impl<const N: usize> Passed<N> for &[[u32; N]] {
    #[inline(always)]
    fn lanes(&self, id: impl Fn() -> u32) -> [u32; N] {
        let (id, mut lanes) = (id(), [0; N]);
        for passed in *self {
            for l in 0..N {
                lanes[l] |= u32::all_if(passed[l] == id);
            }
        }
        lanes
    }
}

/// The spheres of a scene as planes leave them.
pub(super) trait Solids<const N: usize> {
    /// Takes the sphere of an entry if planes cut it: a hit at a root that is possible into the nearest two, a certain face here.
    fn take(
        &mut self,
        strip: &Strip<N>,
        certify: &Certify<'_, f32>,
        slot: u32,
        passed: &impl Passed<N>,
        k: &mut NearestTwos<N>,
    ) -> bool;

    /// The least depth that a lane has found, the depth of the nearest two included.
    fn least(&self, l: usize, low: f32) -> f32;

    /// Takes the faces into the nearest two.
    fn end(&mut self, k: &mut NearestTwos<N>);

    /// Corrects the answers of the winners that planes cut.
    fn certify(&self, strip: &Strip<N>, certify: &Certify<'_, f32>, k: &NearestTwos<N>, answers: &mut StripAnswers<N>);

    /// All bits if the nearest hit of a lane is on a plane.
    fn on_face(&self, l: usize) -> u32;
}

/// No plane cuts a sphere.
pub(super) struct Whole;

impl<const N: usize> Solids<N> for Whole {
    #[inline(always)]
    fn take(&mut self, _: &Strip<N>, _: &Certify<'_, f32>, _: u32, _: &impl Passed<N>, _: &mut NearestTwos<N>) -> bool {
        false
    }

    #[inline(always)]
    fn least(&self, _: usize, low: f32) -> f32 {
        low
    }

    #[inline(always)]
    fn end(&mut self, _: &mut NearestTwos<N>) {}

    #[inline(always)]
    fn certify(&self, _: &Strip<N>, _: &Certify<'_, f32>, _: &NearestTwos<N>, _: &mut StripAnswers<N>) {}

    #[inline(always)]
    fn on_face(&self, _: usize) -> u32 {
        0
    }
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
    pub(super) fn slopes(&self, l: usize) -> Slopes<f32> {
        let (x, y, a, inverse) = (self.x[l], self.y[l], self.a[l], self.inverse[l]);
        Slopes { x, y, a, inverse, row: self.row[l], column: self.column[l] }
    }

    /// The two smallest lower bounds of depth among the general spheres and the lists of a tile, nearest first, without the spheres that are
    /// passed. On a device spheres leave the same in the pixels (shaders/splat/splat.wgsl).
    #[inline(always)]
    pub(super) fn nearest_two(
        &self,
        certify: &Certify<'_, f32>,
        [i, first]: [u32; 2],
        passed: &impl Passed<N>,
        solids: &mut impl Solids<N>,
    ) -> NearestTwos<N> {
        let mut k = NearestTwos::NONE;
        let (projection, terms, lists) = (certify.projection, *certify.terms, certify.lists);
        for &slot in certify.general_lists.of(i, first) {
            // Copies: of what a reference leads to, compilers may expect that the loop changes it.
            let general = certify.generals[slot as usize];
            if solids.take(self, certify, GENERAL | slot, passed, &mut k) {
                continue;
            }
            let mut lows = [0.0; N];
            for (l, low) in lows.iter_mut().enumerate() {
                *low = general_low(&self.slopes(l), &general, &terms);
            }
            let passed = passed.lanes(|| general.id);
            for (l, low) in lows.into_iter().enumerate() {
                k.keep(l, pick(passed[l], BEYOND, low), GENERAL | slot);
            }
        }
        let [first, end] = lists.range(i, first).map(|n| n as usize);
        let chunks =
            lists.projected[first..end].chunks_exact(CHUNK).zip(&lists.chunk_min_depths[first / CHUNK..end / CHUNK]);
        for (n, (chunk, &chunk_min_depth)) in chunks.enumerate() {
            let mut behind = true;
            for l in 0..N {
                let low = solids.least(l, k.low[l]);
                let own = chunk_min_depth - low > projection.cull_margin * (projection.depth + low);
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
                if solids.take(self, certify, slot as u32, passed, &mut now) {
                    continue;
                }
                let sphere = Projected::<f32>::new(projected, &NO_DETAIL);
                let passed = passed.lanes(|| lists.details[slot].id);
                for l in 0..N {
                    let low = projected_low(&self.slopes(l), projection, &sphere);
                    now.keep(l, pick(passed[l], BEYOND, low), slot as u32);
                }
            }
            k = now;
        }
        solids.end(&mut k);
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
            self.certify_general(certify, k, slot, &mut answers);
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
        k: &NearestTwos<N>,
        slot: u32,
        answers: &mut StripAnswers<N>,
    ) {
        let (general, terms) = (certify.generals[(slot & !GENERAL) as usize], *certify.terms);
        let mut found = StripAnswers::default();
        for l in 0..N {
            let answer = general_answer(&self.slopes(l), &general, &terms);
            found.set(l, &answer, certify.certain(&answer, [k.low[l], k.second[l]]));
        }
        answers.take(&found, |l| k.slot[l] == slot);
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
            let answer = projected_answer(&self.slopes(l), &projection, &sphere, &terms);
            answers.set(l, &answer, certify.certain(&answer, [k.low[l], k.second[l]]));
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
    /// All bits where the answer is certified.
    pub(super) certain: [u32; N],
    /// Offset, the depth's interval and the normal of [`Answer`].
    pub(super) numbers: [[f32; N]; 5],
}

impl<const N: usize> Default for StripAnswers<N> {
    #[inline(always)]
    fn default() -> Self {
        Self { id: [NONE; N], certain: [0; N], numbers: [[0.0; N]; 5] }
    }
}

impl<const N: usize> StripAnswers<N> {
    #[inline(always)]
    pub(super) fn set(&mut self, l: usize, a: &Answer<f32>, certain: bool) {
        self.id[l] = a.id;
        self.certain[l] = u32::all_if(certain);
        self.numbers[0][l] = a.offset;
        self.numbers[1][l] = a.depth_interval;
        self.numbers[2][l] = a.normal[0];
        self.numbers[3][l] = a.normal[1];
        self.numbers[4][l] = a.normal[2];
    }

    /// Takes over the answers of some lanes.
    #[inline(always)]
    pub(super) fn take(&mut self, other: &Self, lane: impl Fn(usize) -> bool) {
        let mut lanes = [0; N];
        for l in 0..N {
            lanes[l] = u32::all_if(lane(l));
            self.id[l] ^= (self.id[l] ^ other.id[l]) & lanes[l];
            self.certain[l] ^= (self.certain[l] ^ other.certain[l]) & lanes[l];
        }
        for k in 0..5 {
            for l in 0..N {
                self.numbers[k][l] = pick(lanes[l], other.numbers[k][l], self.numbers[k][l]);
            }
        }
    }
}

impl<const N: usize> NearestTwos<N> {
    pub(super) const NONE: Self = Self { low: [BEYOND; N], second: [BEYOND; N], slot: [NONE; N] };

    #[inline(always)]
    pub(super) fn keep(&mut self, l: usize, low: f32, slot: u32) {
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
