//! The cut spheres of a strip: the part of each ray that planes keep, and the hits there, in loops over lanes.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use super::strip::{NearestTwos, Passed, Solids, Strip, StripAnswers};
use crate::certify::constants::BEYOND;
use crate::certify::general::{general_answer, general_roots};
use crate::certify::planes::{CutLow, Kept, PlaneRecords};
use crate::certify::projected::{Roots, projected_roots};
use crate::certify::{Certify, GENERAL};
use crate::number::vector::{Bits, pick};
use crate::view::ray::NONE;

/// Planes that cut spheres, as the rays of a strip pass them.
pub(super) struct CutStrip<'a, const N: usize> {
    planes: &'a PlaneRecords,
    /// The parts of the rays that planes keep, once a sphere asks for them.
    kept: Option<KeptParts<N>>,
    /// Of the faces of each lane that are certain the rank and the entry of the one that shows.
    rank: [u32; N],
    slot: [u32; N],
    /// All bits where the nearest hit is that face.
    on_face: [u32; N],
}

/// [`Kept`] of each lane, one array per component; truth values as all bits and none.
#[derive(Clone, Copy)]
struct KeptParts<const N: usize> {
    entry: [[f32; N]; 2],
    exit: [[f32; N]; 2],
    plane: [u32; N],
    is_empty: [u32; N],
    is_unknown: [u32; N],
}

impl<const N: usize> KeptParts<N> {
    #[inline(always)]
    fn new(strip: &Strip<N>, certify: &Certify<'_, f32>, planes: &PlaneRecords) -> Self {
        let (projection, terms, head) = (*certify.projection, *certify.terms, planes.head);
        let mut all =
            Self { entry: [[0.0; N]; 2], exit: [[0.0; N]; 2], plane: [0; N], is_empty: [0; N], is_unknown: [0; N] };
        for l in 0..N {
            all.set(l, &Kept::all(&projection));
        }
        for (index, plane) in (0..).zip(&planes.planes) {
            let (plane, before) = (*plane, all);
            for l in 0..N {
                let kept = before.at(l).cut(&strip.slopes(l), (&plane, index), &head, (&projection, &terms));
                all.set(l, &kept);
            }
        }
        all
    }

    #[inline(always)]
    fn at(&self, l: usize) -> Kept<f32> {
        Kept {
            entry: [self.entry[0][l], self.entry[1][l]],
            exit: [self.exit[0][l], self.exit[1][l]],
            plane: self.plane[l],
            is_empty: self.is_empty[l] != 0,
            is_unknown: self.is_unknown[l] != 0,
        }
    }

    #[inline(always)]
    fn set(&mut self, l: usize, kept: &Kept<f32>) {
        ([self.entry[0][l], self.entry[1][l]], [self.exit[0][l], self.exit[1][l]]) = (kept.entry, kept.exit);
        (self.plane[l], self.is_empty[l], self.is_unknown[l]) =
            (kept.plane, u32::all_if(kept.is_empty), u32::all_if(kept.is_unknown));
    }
}

impl<'a, const N: usize> CutStrip<'a, N> {
    #[inline(always)]
    pub(super) fn new(planes: &'a PlaneRecords) -> Self {
        Self { planes, kept: None, rank: [u32::MAX; N], slot: [NONE; N], on_face: [0; N] }
    }

    /// The least depth of the face of a lane.
    #[inline(always)]
    fn face(&self, l: usize) -> f32 {
        let entry = self.kept.as_ref().map_or(BEYOND, |kept| kept.entry[0][l]);
        pick(u32::all_if(self.slot[l] == NONE), BEYOND, entry)
    }
}

impl<const N: usize> Solids<N> for CutStrip<'_, N> {
    #[inline(always)]
    fn take(
        &mut self,
        strip: &Strip<N>,
        certify: &Certify<'_, f32>,
        slot: u32,
        passed: &impl Passed<N>,
        k: &mut NearestTwos<N>,
    ) -> bool {
        let rank = certify.rank(slot);
        if rank == 0 {
            return false;
        }
        let (projection, terms) = (*certify.projection, *certify.terms);
        let passed = passed.lanes(|| certify.id(slot));
        let (mut lows, mut faces) = ([0.0; N], [0; N]);
        let kept = self.kept.get_or_insert_with(|| KeptParts::new(strip, certify, self.planes));
        let mut keep = |l: usize, roots: Roots<f32>| {
            let CutLow { low, at_face, .. } = CutLow::new(&kept.at(l), &roots);
            (lows[l], faces[l]) = (low, u32::all_if(at_face) & !passed[l]);
        };
        if slot & GENERAL == 0 {
            let sphere = certify.projected(slot as usize);
            for l in 0..N {
                keep(l, projected_roots(&strip.slopes(l), &projection, &sphere, &terms));
            }
        } else {
            let sphere = certify.generals[(slot & !GENERAL) as usize];
            for l in 0..N {
                keep(l, general_roots(&strip.slopes(l), &sphere, &terms));
            }
        }
        for l in 0..N {
            let first = faces[l] & u32::all_if(rank < self.rank[l]);
            self.rank[l] ^= (self.rank[l] ^ rank) & first;
            self.slot[l] ^= (self.slot[l] ^ slot) & first;
            k.keep(l, pick(passed[l] | faces[l], BEYOND, lows[l].min(BEYOND)), slot);
        }
        true
    }

    #[inline(always)]
    fn least(&self, l: usize, low: f32) -> f32 {
        let face = self.face(l);
        pick(u32::all_if(face < low), face, low)
    }

    #[inline(always)]
    fn end(&mut self, k: &mut NearestTwos<N>) {
        for l in 0..N {
            let before = k.low[l];
            k.keep(l, self.face(l), self.slot[l]);
            self.on_face[l] = u32::all_if(k.low[l] < before);
        }
    }

    #[inline(always)]
    fn certify(&self, strip: &Strip<N>, certify: &Certify<'_, f32>, k: &NearestTwos<N>, answers: &mut StripAnswers<N>) {
        let Some(kept) = &self.kept else { return };
        let (projection, terms) = (*certify.projection, *certify.terms);
        let cut = |l: usize| k.slot[l] != NONE && certify.rank(k.slot[l]) != 0;
        // All lanes are computed, since usually all share the winner.
        let mut left: [u32; N] = k.slot;
        for l in 0..N {
            left[l] = if cut(l) && self.on_face[l] == 0 { left[l] } else { NONE };
        }
        while let Some(slot) = left.into_iter().find(|slot| *slot != NONE) {
            let mut own = [0; N];
            for l in 0..N {
                own[l] = u32::all_if(left[l] == slot);
                left[l] |= own[l];
            }
            let mut at_root = [0; N];
            if slot & GENERAL == 0 {
                let sphere = certify.projected(slot as usize);
                for l in 0..N {
                    let roots = projected_roots(&strip.slopes(l), &projection, &sphere, &terms);
                    at_root[l] = u32::all_if(CutLow::new(&kept.at(l), &roots).at_root);
                }
            } else {
                let (sphere, mut found) = (certify.generals[(slot & !GENERAL) as usize], StripAnswers::default());
                for l in 0..N {
                    let answer = general_answer(&strip.slopes(l), &sphere, &terms);
                    found.set(l, &answer, certify.certain(&answer, [k.low[l], k.second[l]]));
                }
                for l in 0..N {
                    let roots = general_roots(&strip.slopes(l), &sphere, &terms);
                    at_root[l] = u32::all_if(CutLow::new(&kept.at(l), &roots).at_root);
                }
                answers.take(&found, |l| own[l] != 0);
            }
            for l in 0..N {
                answers.certain[l] &= at_root[l] | !own[l];
            }
        }
        for l in (0..N).filter(|l| self.on_face[*l] != 0) {
            let kept = kept.at(l);
            let answer = kept.face(certify.id(k.slot[l]), self.planes.planes[kept.plane as usize].normal);
            answers.set(l, &answer, certify.certain(&answer, [k.low[l], k.second[l]]));
        }
    }

    #[inline(always)]
    fn on_face(&self, l: usize) -> u32 {
        self.on_face[l]
    }
}
