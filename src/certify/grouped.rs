//! Bins spheres group by group from front to back, without those that the groups in front hide: docs/certificate.md,
//! section 11.

use super::entry::Bin;
use super::general::GeneralRecord;
use super::projection::ProjectionBounds;
use super::projection::enclose::Enclosed;
use super::projection::pyramid::DepthPyramid;
use super::projection::stage::Staged;
use super::reference::{joined, reference};
use super::sieve::{Fate, Fates, GroupFate, Sieve};
use crate::scene::instances::enclosure::Enclosure;
use crate::scene::{Ball, NumberedBall};
use crate::window::Window;
use halfline_ground::parallel;
use pulp::NullaryFnOnce;
use std::ops::Range;

/// Spheres of a group, and groups of a larger one.
const SPHERES_PER_GROUP: usize = 64;
const GROUPS_PER_LARGE_GROUP: usize = 8;

/// Refreshes of the pyramid in a frame, and large groups of one job.
const REFRESHES: usize = 8;
const GROUPS_PER_JOB: usize = 4;
const BOXES_PER_JOB: usize = 64;

/// Boxes around groups of spheres.
#[derive(Debug)]
pub(crate) struct Boxes {
    small: Vec<Enclosure>,
    large: Vec<Enclosure>,
}

impl Boxes {
    /// Around each run of 64 and of 512 spheres: centres and radii.
    pub(crate) fn of(spheres: &[[f64; 4]]) -> Self {
        let bounds = |group: &[[f64; 4]]| {
            let each = group.iter().map(|[x, y, z, radius]| Enclosure::of([*x, *y, *z], *radius));
            each.fold(Enclosure::NOTHING, |all, one| all.with(&one))
        };
        let union = |group: &[Enclosure]| group.iter().fold(Enclosure::NOTHING, |all, one| all.with(one));
        let small = parallel::collect(spheres.len(), SPHERES_PER_GROUP * BOXES_PER_JOB, &|range, small| {
            small.extend(spheres[range].chunks(SPHERES_PER_GROUP).map(bounds));
        });
        let large = small.chunks(GROUPS_PER_LARGE_GROUP).map(union).collect();
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

/// The spheres that the groups in front do not hide, and the groups that were left out.
#[derive(Debug, Default)]
pub(super) struct GroupedBins {
    /// The open projected spheres: their places in the order, and their bins.
    pub(super) places: Vec<u32>,
    pub(super) bins: Vec<Bin>,
    pub(super) generals: Vec<GeneralRecord>,
    /// Least and largest depth of the projected spheres, as far as they were looked at one by one.
    pub(super) range: Option<[f64; 2]>,
    /// The places of groups that are hidden, or missed by every ray.
    hidden: Vec<Range<usize>>,
    missed: Vec<Range<usize>>,
}

impl GroupedBins {
    /// The union of all parts.
    fn of(mut parts: Vec<Self>) -> Self {
        let mut all = Self { range: parts.iter().filter_map(|part| part.range).reduce(joined), ..Self::default() };
        for part in &mut parts {
            all.generals.append(&mut part.generals);
            all.hidden.append(&mut part.hidden);
            all.missed.append(&mut part.missed);
        }
        let (places, bins) = parallel::join(
            || parts.iter().map(|part| &part.places[..]).collect::<Vec<_>>().concat(),
            || parts.iter().map(|part| &part.bins[..]).collect::<Vec<_>>().concat(),
        );
        Self { places, bins, ..all }
    }

    #[inline(always)]
    fn see(&mut self, depth: f64) {
        self.range = Some(joined(self.range.unwrap_or([depth; 2]), [depth; 2]));
    }

    /// The reference depth of all spheres. Groups that were left out are looked at only where they may change it.
    pub(super) fn reference(&self, projection: &ProjectionBounds, groups: Grouped<'_>) -> f32 {
        let known = reference(self.range, !self.generals.is_empty());
        // Further spheres widen the range, and one that is too wide stays so.
        if !self.generals.is_empty() || self.range.is_some() && known == 0.0 {
            return 0.0;
        }
        let stage = |place: usize| {
            let NumberedBall { id, ball: Ball { center, radius } } = groups.sphere(place);
            projection.stage(id, center, radius, 0.0)
        };
        let is_general = |place: usize| matches!(stage(place), Staged::General(_));
        if parallel::any(self.missed.len(), 1, &|groups| self.missed[groups].iter().cloned().flatten().any(is_general))
        {
            return 0.0;
        }
        let mut range = self.range;
        for group in &self.hidden {
            let [near, far] = projection.depths(&groups.bounds(group));
            if range.is_some_and(|[least, most]| least <= near && far <= most) {
                continue;
            }
            let depths = group.clone().filter_map(|place| match stage(place) {
                Staged::Projected(landed) => Some([landed.placed.depth; 2]),
                Staged::Unseen | Staged::General(_) => None,
            });
            range = range.into_iter().chain(depths).reduce(joined);
        }
        reference(range, false)
    }
}

impl Grouped<'_> {
    /// The sphere in a place.
    #[inline(always)]
    pub(super) fn sphere(&self, place: usize) -> NumberedBall {
        NumberedBall { id: self.ids[place], ball: self.spheres[place].into() }
    }

    /// The box around the spheres in these places, which are a group.
    fn bounds(&self, group: &Range<usize>) -> Enclosure {
        let is_small = group.len() <= SPHERES_PER_GROUP;
        let (boxes, size) = if is_small {
            (&self.boxes.small, SPHERES_PER_GROUP)
        } else {
            (&self.boxes.large, SPHERES_PER_GROUP * GROUPS_PER_LARGE_GROUP)
        };
        boxes[group.start / size]
    }

    /// The places of the spheres of this group, where a group has `size` spheres.
    fn places(&self, group: usize, size: usize) -> Range<usize> {
        group * size..self.ids.len().min((group + 1) * size)
    }
}

impl ProjectionBounds {
    /// The spheres that some ray of the window of an image of `size` pixels may hit first, and some that are hidden, with bins
    /// relative to depth 0.
    pub(super) fn foremost(&self, groups: Grouped<'_>, size: [u32; 2], window: Window, tolerance: f64) -> GroupedBins {
        let pyramid = DepthPyramid::new(self, size, window, tolerance);
        let mut sieve = Sieve { projection: self.clone(), pyramid };
        let large = &groups.boxes.large;
        let near = |n: usize| match self.enclose(&large[n]) {
            Enclosed::Unseen => None,
            Enclosed::Projected { least, .. } => Some((least, n as u32)),
            Enclosed::Missed | Enclosed::Unknown => Some((f32::NEG_INFINITY, n as u32)),
        };
        let mut nearest =
            parallel::collect(large.len(), BOXES_PER_JOB, &|range, out| out.extend(range.filter_map(near)));
        parallel::sort(&mut nearest, |(a, m), (b, n)| a.total_cmp(b).then(m.cmp(n)));
        let arch = pulp::Arch::new();
        let mut parts = Vec::new();
        for some in nearest.chunks(nearest.len().div_ceil(REFRESHES).max(1)) {
            let job = |large: &[(f32, u32)]| arch.dispatch(Job { sieve: &sieve, groups, large });
            parts.extend(parallel::blocks(0..some.len(), GROUPS_PER_JOB, &|range, _| job(&some[range])));
            sieve.refresh();
        }
        GroupedBins::of(parts)
    }
}

/// Some large groups, from front to back.
struct Job<'a> {
    sieve: &'a Sieve,
    groups: Grouped<'a>,
    large: &'a [(f32, u32)],
}

impl NullaryFnOnce for Job<'_> {
    type Output = GroupedBins;

    #[inline(always)]
    fn call(self) -> GroupedBins {
        let mut found = GroupedBins::default();
        for (_, group) in self.large {
            let large = *group as usize;
            if self.is_decided(self.groups.places(large, SPHERES_PER_GROUP * GROUPS_PER_LARGE_GROUP), &mut found) {
                continue;
            }
            for small in
                large * GROUPS_PER_LARGE_GROUP..self.groups.boxes.small.len().min((large + 1) * GROUPS_PER_LARGE_GROUP)
            {
                let places = self.groups.places(small, SPHERES_PER_GROUP);
                if !self.is_decided(places.clone(), &mut found) {
                    self.sieve.settle(places, |place| self.groups.sphere(place), true, &mut found);
                }
            }
        }
        found
    }
}

impl Job<'_> {
    /// Whether a group is left out as a whole. A hidden or missed one is noted in `found`.
    #[inline(always)]
    fn is_decided(&self, places: Range<usize>, found: &mut GroupedBins) -> bool {
        match self.sieve.settle_group(&self.groups.bounds(&places)) {
            GroupFate::Unseen => {}
            GroupFate::Missed => found.missed.push(places),
            GroupFate::Hidden => found.hidden.push(places),
            GroupFate::Open => return false,
        }
        true
    }
}

impl Fates for GroupedBins {
    #[inline(always)]
    fn add(&mut self, place: usize, fate: Fate) {
        match fate {
            Fate::Hidden { depth } => self.see(depth),
            Fate::Open { depth, bin } => {
                self.see(depth);
                self.places.push(place as u32);
                self.bins.push(bin);
            }
            Fate::General(record) => self.generals.push(record),
        }
    }
}
