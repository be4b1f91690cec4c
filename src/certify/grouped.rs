//! Bins spheres group by group from front to back, without those that the groups in front hide: docs/certificate.md,
//! section 11.

use super::general::GeneralRecord;
use super::projection::ProjectionBounds;
use super::projection::enclose::Enclosed;
use super::projection::project::Landed;
use super::projection::pyramid::{DepthPyramid, Rectangles};
use super::projection::stage::Staged;
use super::tiles::Bin;
use crate::number::vector::LANES;
use crate::scene::instances::enclosure::Enclosure;
use crate::window::Window;
use pulp::NullaryFnOnce;
use rayon::prelude::*;
use std::ops::Range;

/// Spheres of a group, and groups of a larger one.
const GROUP: usize = 64;
const LARGE: usize = 8;

/// How often the pyramid takes over what groups cover, and large groups of one job.
const REFRESHES: usize = 8;
const TOGETHER: usize = 4;

/// Boxes around groups of spheres.
#[derive(Debug)]
pub(crate) struct Boxes {
    small: Vec<Enclosure>,
    large: Vec<Enclosure>,
}

impl Boxes {
    /// Around each run of 64 and of 512 spheres: centres and radii.
    pub(crate) fn of(spheres: &[[f64; 4]]) -> Self {
        let around = |group: &[[f64; 4]]| {
            let each = group.iter().map(|[x, y, z, radius]| Enclosure::of([*x, *y, *z], *radius));
            each.fold(Enclosure::NOTHING, |all, one| all.with(&one))
        };
        let joined = |group: &[Enclosure]| group.iter().fold(Enclosure::NOTHING, |all, one| all.with(one));
        let small: Vec<Enclosure> = spheres.par_chunks(GROUP).map(around).collect();
        let large = small.par_chunks(LARGE).map(joined).collect();
        Self { small, large }
    }
}

/// The spheres of a scene in an order in which neighbours lie together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Grouped<'a> {
    /// Their ids.
    pub(crate) ids: &'a [u32],
    /// Their centres and radii.
    pub(crate) spheres: &'a [[f64; 4]],
    pub(crate) boxes: &'a Boxes,
}

/// Spheres that may be hit first.
#[derive(Debug, Default)]
pub(super) struct Foremost {
    /// Those that are projected: their places in the order, and their bins.
    pub(super) places: Vec<u32>,
    pub(super) bins: Vec<Bin>,
    pub(super) generals: Vec<GeneralRecord>,
    /// Least and largest depth of the projected spheres, as far as they were looked at one by one.
    range: Option<[f64; 2]>,
    /// The places of groups that are hidden, or missed by every ray.
    hidden: Vec<Range<usize>>,
    missed: Vec<Range<usize>>,
}

impl Foremost {
    /// Those of all parts.
    fn of(mut parts: Vec<Self>) -> Self {
        let mut all = Self::default();
        for part in &mut parts {
            all.generals.append(&mut part.generals);
            all.hidden.append(&mut part.hidden);
            all.missed.append(&mut part.missed);
            part.range.into_iter().flatten().for_each(|depth| all.see(depth));
        }
        let (places, bins) = rayon::join(
            || parts.iter().map(|part| &part.places[..]).collect::<Vec<_>>().concat(),
            || parts.iter().map(|part| &part.bins[..]).collect::<Vec<_>>().concat(),
        );
        Self { places, bins, ..all }
    }

    fn see(&mut self, depth: f64) {
        let [least, most] = self.range.unwrap_or([depth; 2]);
        self.range = Some([least.min(depth), most.max(depth)]);
    }

    fn keep(&mut self, place: usize, bin: Bin) {
        self.places.push(place as u32);
        self.bins.push(bin);
    }

    /// Least and largest depth of all projected spheres, and whether any sphere is general, as far as a reference depends on
    /// these: `matters` tells of a range whether further spheres could change what follows from it.
    pub(super) fn range(
        &mut self,
        projection: &ProjectionBounds,
        of: Grouped<'_>,
        matters: impl Fn(Option<[f64; 2]>) -> bool,
    ) -> (Option<[f64; 2]>, bool) {
        let stage = |n: usize| {
            let (center, radius) = of.sphere(n);
            projection.stage(of.ids[n], center, radius, 0.0)
        };
        let is_general = |n: usize| matches!(stage(n), Staged::General(_));
        if self.generals.is_empty() && matters(self.range) {
            if self.missed.par_iter().any(|group| group.clone().any(is_general)) {
                return (self.range, true);
            }
            for group in std::mem::take(&mut self.hidden) {
                let [near, far] = projection.depths(&of.around(&group));
                if self.range.is_some_and(|[least, most]| least <= near && far <= most) {
                    continue;
                }
                group.for_each(|n| {
                    if let Staged::Projected(landed) = stage(n) {
                        self.see(landed.placed.depth);
                    }
                });
            }
        }
        (self.range, !self.generals.is_empty())
    }
}

impl Grouped<'_> {
    /// Centre and radius of the sphere in a place.
    #[inline(always)]
    pub(super) fn sphere(&self, place: usize) -> ([f64; 3], f64) {
        let [x, y, z, radius] = self.spheres[place];
        ([x, y, z], radius)
    }

    /// The box around these spheres, which are a group.
    fn around(&self, group: &Range<usize>) -> Enclosure {
        let is_small = group.len() <= GROUP;
        let (boxes, size) = if is_small { (&self.boxes.small, GROUP) } else { (&self.boxes.large, GROUP * LARGE) };
        boxes[group.start / size]
    }

    /// The places of the spheres of a group of so many.
    fn places(&self, group: usize, size: usize) -> Range<usize> {
        group * size..self.ids.len().min((group + 1) * size)
    }
}

impl ProjectionBounds {
    /// The spheres that some ray of the window of an image of `size` pixels may hit first, and some that are hidden, with bins
    /// relative to depth 0.
    pub(super) fn foremost(&self, of: Grouped<'_>, frame: ([u32; 2], Window), tolerance: f64) -> Foremost {
        let mut pyramid = DepthPyramid::new(self, frame, 0.0, tolerance);
        let near = |(n, around): (usize, &Enclosure)| match self.enclose(around) {
            Enclosed::Unseen => None,
            Enclosed::Projected { least, .. } => Some((least, n as u32)),
            Enclosed::Unknown => Some((f32::NEG_INFINITY, n as u32)),
        };
        let mut groups: Vec<(f32, u32)> = of.boxes.large.par_iter().enumerate().filter_map(near).collect();
        groups.par_sort_unstable_by(|(a, m), (b, n)| a.total_cmp(b).then(m.cmp(n)));
        let arch = pulp::Arch::new();
        let mut parts = Vec::new();
        for groups in groups.chunks(groups.len().div_ceil(REFRESHES).max(1)) {
            let job = |groups: &[(f32, u32)]| arch.dispatch(Job { projection: self, pyramid: &pyramid, of, groups });
            parts.par_extend(groups.par_chunks(TOGETHER).map(job));
            pyramid.refresh();
        }
        Foremost::of(parts)
    }
}

/// Some large groups.
struct Job<'a> {
    projection: &'a ProjectionBounds,
    pyramid: &'a DepthPyramid,
    of: Grouped<'a>,
    groups: &'a [(f32, u32)],
}

impl NullaryFnOnce for Job<'_> {
    type Output = Foremost;

    #[inline(always)]
    fn call(self) -> Foremost {
        let (boxes, mut found) = (self.of.boxes, Foremost::default());
        for (_, group) in self.groups {
            let large = *group as usize;
            if self.passes(self.of.places(large, GROUP * LARGE), &mut found) {
                continue;
            }
            for small in large * LARGE..boxes.small.len().min((large + 1) * LARGE) {
                let places = self.of.places(small, GROUP);
                if !self.passes(places.clone(), &mut found) {
                    self.add(places, &mut found);
                }
            }
        }
        found
    }
}

impl Job<'_> {
    /// Whether no sphere of a group is hit first.
    #[inline(always)]
    fn passes(&self, places: Range<usize>, found: &mut Foremost) -> bool {
        let around = self.of.around(&places);
        match self.projection.enclose(&around) {
            Enclosed::Unseen => return true,
            Enclosed::Projected { least, pixels } if self.pyramid.hides(&pixels, least) => found.hidden.push(places),
            Enclosed::Unknown if self.projection.misses(&around) => found.missed.push(places),
            _ => return false,
        }
        true
    }

    /// Adds those spheres of a group that may be hit first.
    #[inline(always)]
    fn add(&self, places: Range<usize>, found: &mut Foremost) {
        let Self { projection, pyramid, of, .. } = *self;
        for first in places.clone().step_by(LANES) {
            let there = LANES.min(places.end - first);
            // The last sphere is repeated to fill the vector; the copies are discarded.
            let (mut centers, mut radii) = ([[0.0; 3]; LANES], [0.0; LANES]);
            for l in 0..LANES {
                (centers[l], radii[l]) = of.sphere(first + l.min(there - 1));
            }
            let mut rectangles = Rectangles::NONE;
            let see = |l: usize, landed: &Landed| rectangles.set(l, landed, pyramid);
            let eight = projection.eight_and(&centers, &radii, 0.0, see);
            for l in 0..there {
                let id = of.ids[first + l];
                if eight.projected[l] != 0 {
                    found.see(eight.depth[l]);
                    let bin = eight.bin(l);
                    if !pyramid.hides_one(&rectangles, l, bin.chunk_min_depth) {
                        found.keep(first + l, bin);
                        pyramid.cover(&eight.placed(l, id));
                    }
                } else if eight.other[l] != 0 {
                    match projection.stage(id, centers[l], radii[l], 0.0) {
                        Staged::Unseen => {}
                        Staged::General(record) => found.generals.push(record),
                        Staged::Projected(landed) => {
                            found.see(landed.placed.depth);
                            found.keep(first + l, landed.bin);
                            pyramid.cover(&landed.placed);
                        }
                    }
                }
            }
        }
    }
}
