//! Host preparation for the certified kernel: each sphere in one of two forms, with bounds of the rounding errors in
//! f32 and on the host. docs/certificate.md derives the bounds.

use super::answer::ProjectionRecord;
use super::general::GeneralRecord;
use super::general_lists::{GeneralLists, GeneralTree};
use super::grouped::Grouped;
use super::projection::ProjectionBounds;
use super::projection::cover::{Cover, Coverage};
use super::projection::project::Eight;
use super::projection::stage::Staged;
use super::terms::Terms;
use super::tiles::{AHEAD, Bin, Filling, Lists, Placed, Placing, sized};
use crate::error::Result;
use crate::memory::Pool;
use crate::number::vector::LANES;
use crate::scene::Scene;
use crate::view::View;
use pulp::NullaryFnOnce;
use rayon::prelude::*;

/// The scene as the certified kernel reads it.
#[derive(Debug, Clone)]
pub(crate) struct BinnedScene {
    pub(crate) projection: ProjectionRecord,
    pub(crate) lists: Lists,
    pub(crate) generals: Vec<GeneralRecord>,
    /// Which of them the rays of a tile may hit first.
    pub(crate) general_lists: GeneralLists,
    /// Projected spheres that some ray may hit.
    pub(crate) seen: u64,
}

impl BinnedScene {
    /// Returns its memory to the pool for the next frame.
    pub(crate) fn put_back(self, pool: &Pool) {
        pool.put_back(self.lists.projected);
        pool.put_back(self.lists.details);
        pool.put_back(self.lists.depths);
        pool.put_back(self.lists.chunk_min_depths);
    }
}

/// Spheres per binning job.
const TOGETHER: usize = 1 << 14;

/// The bins of all spheres.
struct SphereBins {
    /// The bin of every sphere, by id.
    bins: Vec<Bin>,
    generals: Vec<GeneralRecord>,
    /// Least and largest depth of the projected spheres.
    range: Option<[f64; 2]>,
    /// Number of projected spheres.
    seen: u64,
    /// Number of their entries in lists of single tiles.
    entries: u64,
}

impl BinnedScene {
    /// Prepares `scene`. `None` if the field of view is too wide or too narrow for f32, so that every pixel must be
    /// decided exactly. Tiles share candidate lists from `level` on ([`Lists::new`]). Of spheres in groups those that others
    /// certainly hide are left out.
    pub(crate) fn new(
        (scene, groups): (&Scene, Option<Grouped<'_>>),
        view: &View,
        tolerance: f64,
        terms: &Terms,
        level: u32,
        pool: &Pool,
    ) -> Result<Option<Self>> {
        let (width, height) = (scene.image.width, scene.image.height);
        let projection = ProjectionBounds::new(&scene.camera, view, [width, height], terms)?;
        if !projection.is_bounded() {
            return Ok(None);
        }
        let frame = Stage { projection, view, size: [width, height], tolerance, level, pool };
        Ok(Some(match groups {
            Some(groups) => frame.of_groups(groups),
            None => frame.of_all(&scene.spheres.centers, &scene.spheres.radii),
        }))
    }
}

/// What the stage of a frame knows but for the spheres.
struct Stage<'a> {
    projection: ProjectionBounds,
    view: &'a View,
    size: [u32; 2],
    tolerance: f64,
    level: u32,
    pool: &'a Pool,
}

impl Stage<'_> {
    /// Bins all spheres.
    fn of_all(&self, centers: &[[f64; 3]], radii: &[f64]) -> BinnedScene {
        let Self { projection, pool, .. } = self;
        let mut bins = projection.bin_spheres(centers, radii, 0.0, pool);
        let reference = reference(bins.range, !bins.generals.is_empty());
        if reference > 0.0 {
            pool.put_back(bins.bins);
            bins = projection.bin_spheres(centers, radii, reference.into(), pool);
        }
        self.list(bins, Source::All { centers, radii }, reference)
    }

    /// Bins those that may be hit first.
    fn of_groups(&self, groups: Grouped<'_>) -> BinnedScene {
        let Self { projection, view, size, tolerance, pool, .. } = self;
        let mut found = projection.foremost(groups, (*size, view.record.window()), *tolerance);
        let matters = |range: Option<[f64; 2]>| range.is_none() || reference(range, false) > 0.0;
        let (range, has_generals) = found.range(projection, groups, matters);
        let reference = reference(range, has_generals);
        let bins = if reference > 0.0 {
            let spheres = found.places.par_iter().map(|place| groups.sphere(*place as usize));
            let (centers, radii): (Vec<_>, Vec<_>) = spheres.unzip();
            projection.bin_spheres(&centers, &radii, reference.into(), pool)
        } else {
            let entries = found.bins.par_iter().map(|bin| bin.entries(0)).sum();
            let (bins, generals) = (std::mem::take(&mut found.bins), std::mem::take(&mut found.generals));
            SphereBins { seen: bins.len() as u64, bins, generals, range, entries }
        };
        self.list(bins, Source::Some { groups, places: &found.places }, reference)
    }

    /// The lists of spheres with these bins.
    fn list(&self, bins: SphereBins, source: Source<'_>, reference: f32) -> BinnedScene {
        let Self { projection, view, size, tolerance, level, pool } = self;
        let mut record = projection.record(reference, *tolerance);
        record.generals = bins.generals.len() as u32;
        let reference = reference.into();
        let coverage = Coverage::new(projection, *size, reference, *tolerance);
        let mut placing = Scenery { projection, source, coverage, reference, ready: Vec::new() };
        let SphereBins { bins, generals, seen, entries, .. } = bins;
        if entries >= OFTEN * bins.len() as u64 {
            placing.project_all(bins.len(), pool);
        }
        let lists = Lists::new(&bins, entries, view.record.tiles(), *level, &placing, pool);
        pool.put_back(placing.ready);
        pool.put_back(bins);
        let near = GeneralTree::new(projection, &generals, *size, *tolerance);
        let general_lists = near.lists(view.record.tiles(), *level);
        BinnedScene { projection: record, lists, generals, general_lists, seen }
    }
}

/// The reference depth, from the least and the largest depth of the projected spheres. If all spheres are distant and close
/// together, depths relative to it keep their order in f32.
pub(super) fn reference(range: Option<[f64; 2]>, has_generals: bool) -> f32 {
    // Devices know depths in f32.
    match range.map(|range| range.map(|depth| f64::from(depth as f32))) {
        // The nearest surface is at least a quarter of the nearest centre's depth away.
        Some([least, most]) if !has_generals && least > 4.0 * (most - least) => least as f32,
        _ => 0.0,
    }
}

impl ProjectionBounds {
    /// The least and the largest depth of the projected spheres.
    pub(super) fn range(&self, scene: &Scene, pool: &Pool) -> Option<[f64; 2]> {
        let SphereBins { bins, range, .. } = self.bin_spheres(&scene.spheres.centers, &scene.spheres.radii, 0.0, pool);
        pool.put_back(bins);
        range
    }

    /// Bins all spheres, with depths of projected spheres relative to `reference`.
    fn bin_spheres(&self, centers: &[[f64; 3]], radii: &[f64], reference: f64, pool: &Pool) -> SphereBins {
        let spheres = centers.par_chunks(TOGETHER).zip(radii.par_chunks(TOGETHER));
        // New memory is zeros that the system provides when a job first writes it, on that job's core.
        let mut bins = sized(radii.len(), pool);
        let arch = pulp::Arch::new();
        let jobs = spheres.zip(bins.par_chunks_mut(TOGETHER)).enumerate();
        let done: Vec<_> = jobs
            .map(|(n, ((centers, radii), bins))| {
                let first = n * TOGETHER;
                arch.dispatch(Batch { first, projection: self, reference, centers, radii, bins })
            })
            .collect();
        let seen = done.iter().map(|job| job.seen).sum();
        let entries = done.iter().map(|job| job.entries).sum();
        let ranges = done.iter().filter_map(|job| job.range);
        let range = ranges.reduce(|[a, b], [least, most]| [a.min(least), b.max(most)]);
        SphereBins { bins, generals: done.into_iter().flat_map(|job| job.generals).collect(), range, seen, entries }
    }
}

/// The spheres of one binning job.
struct Batch<'a> {
    first: usize,
    projection: &'a ProjectionBounds,
    reference: f64,
    centers: &'a [[f64; 3]],
    radii: &'a [f64],
    bins: &'a mut [Bin],
}

/// Additional results of a job.
#[derive(Default)]
struct BatchSummary {
    generals: Vec<GeneralRecord>,
    range: Option<[f64; 2]>,
    seen: u64,
    entries: u64,
}

impl BatchSummary {
    fn see(&mut self, depth: f64, bin: &Bin) {
        self.entries += bin.entries(0);
        let [least, most] = self.range.unwrap_or([depth; 2]);
        self.range = Some([least.min(depth), most.max(depth)]);
        self.seen += 1;
    }

    fn take(&mut self, sums: &Sums) {
        let seen = sums.seen.iter().sum::<u64>();
        if seen > 0 {
            let [least, most] = self.range.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            let [low, high] = &sums.range;
            self.range = Some([low.iter().fold(least, |a, b| a.min(*b)), high.iter().fold(most, |a, b| a.max(*b))]);
            self.seen += seen;
            self.entries += sums.entries.iter().sum::<u64>();
        }
    }
}

impl NullaryFnOnce for Batch<'_> {
    type Output = BatchSummary;

    #[inline(always)]
    fn call(self) -> BatchSummary {
        let (mut found, mut sums) = (BatchSummary::default(), Sums::NONE);
        for first in (0..self.bins.len()).step_by(LANES) {
            let there = LANES.min(self.bins.len() - first);
            // The last spheres are repeated to fill the vector; the copies are discarded.
            let (mut centers, mut radii) = ([[0.0; 3]; LANES], [0.0; LANES]);
            for l in 0..LANES {
                let at = first + l.min(there - 1);
                (centers[l], radii[l]) = (self.centers[at], self.radii[at]);
            }
            let eight = self.projection.eight(&centers, &radii, self.reference);
            match self.bins[first..].first_chunk_mut() {
                Some(bins) if eight.other == [0; LANES] => {
                    *bins = eight.bins();
                    sums.add(&eight);
                    continue;
                }
                _ => {}
            }
            for l in 0..there {
                let bin = &mut self.bins[first + l];
                *bin = Bin::NOWHERE;
                if eight.projected[l] != 0 {
                    *bin = eight.bin(l);
                    found.see(eight.depth[l], bin);
                } else if eight.other[l] != 0 {
                    let id = (self.first + first + l) as u32;
                    match self.projection.stage(id, centers[l], radii[l], self.reference) {
                        Staged::Unseen => {}
                        Staged::General(record) => found.generals.push(record),
                        Staged::Projected(landed) => {
                            *bin = landed.bin;
                            found.see(landed.placed.depth, bin);
                        }
                    }
                }
            }
        }
        found.take(&sums);
        found
    }
}

/// What [`BatchSummary::see`] adds up, per lane.
struct Sums {
    range: [[f64; LANES]; 2],
    seen: [u64; LANES],
    entries: [u64; LANES],
}

impl Sums {
    const NONE: Self =
        Self { range: [[f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]], seen: [0; LANES], entries: [0; LANES] };

    /// Adds spheres, all of which are projected or unseen.
    #[inline(always)]
    fn add(&mut self, eight: &Eight) {
        for l in 0..LANES {
            let seen = eight.projected[l] != 0;
            let [least, most] = [0, 1].map(|k| self.range[k][l]);
            self.range[0][l] = if seen & (eight.depth[l] < least) { eight.depth[l] } else { least };
            self.range[1][l] = if seen & (eight.depth[l] > most) { eight.depth[l] } else { most };
            self.seen[l] += u64::from(seen);
            self.entries[l] += if seen { eight.entries(l) } else { 0 };
        }
    }
}

/// The spheres of lists.
#[derive(Clone, Copy)]
enum Source<'a> {
    /// All of a scene, by their ids.
    All { centers: &'a [[f64; 3]], radii: &'a [f64] },
    /// Those in some places of the order of groups.
    Some { groups: Grouped<'a>, places: &'a [u32] },
}

impl Source<'_> {
    /// Id, centre and radius of a sphere by its number.
    #[inline(always)]
    fn sphere(&self, number: u32) -> (u32, [f64; 3], f64) {
        let n = number as usize;
        match self {
            Self::All { centers, radii } => (number, centers[n], radii[n]),
            Self::Some { groups, places } => {
                let place = places[n] as usize;
                let (center, radius) = groups.sphere(place);
                (groups.ids[place], center, radius)
            }
        }
    }
}

/// Creates the records of lists.
struct Scenery<'a> {
    projection: &'a ProjectionBounds,
    source: Source<'a>,
    coverage: Coverage,
    reference: f64,
    /// The records of all spheres by their numbers, where most spheres are in several lists; else empty.
    ready: Vec<Placed>,
}

/// Spheres that are in so many lists on average are projected once for all lists.
const OFTEN: u64 = 3;

impl Scenery<'_> {
    /// Projects all spheres, those that are in no list too.
    fn project_all(&mut self, count: usize, pool: &Pool) {
        let mut ready: Vec<Placed> = sized(count, pool);
        let (scenery, arch) = (&*self, pulp::Arch::new());
        let job = |(n, to): (usize, &mut [Placed])| arch.dispatch(Ready { scenery, first: n * TOGETHER, to });
        ready.par_chunks_mut(TOGETHER).enumerate().for_each(job);
        self.ready = ready;
    }

    /// The records of the spheres with these ids, centres and radii; as they are for those that have none.
    #[inline(always)]
    fn project(&self, ids: &[u32], centers: &[[f64; 3]; LANES], radii: &[f64; LANES], to: &mut [Placed]) {
        let Self { projection, reference, .. } = *self;
        let eight = projection.eight(centers, radii, reference);
        for (l, (placed, id)) in to.iter_mut().zip(ids).enumerate() {
            if eight.projected[l] != 0 {
                *placed = eight.placed(l, *id);
            } else if let Staged::Projected(landed) = projection.stage(*id, centers[l], radii[l], reference) {
                *placed = landed.placed;
            }
        }
    }
}

/// The spheres from `first` on, all of which are projected.
struct Ready<'a> {
    scenery: &'a Scenery<'a>,
    first: usize,
    to: &'a mut [Placed],
}

impl NullaryFnOnce for Ready<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { scenery, first, to } = self;
        for (n, to) in to.chunks_mut(LANES).enumerate() {
            let first = first + n * LANES;
            // The last sphere is repeated to fill the vector; the copies are discarded.
            let (mut ids, mut centers, mut radii) = ([0; LANES], [[0.0; 3]; LANES], [0.0; LANES]);
            for l in 0..LANES {
                let at = first + l.min(to.len() - 1);
                (ids[l], centers[l], radii[l]) = scenery.source.sphere(at as u32);
            }
            scenery.project(&ids, &centers, &radii, to);
        }
    }
}

/// The records of one list.
struct Filler<'a> {
    scenery: &'a Scenery<'a>,
    cover: Option<Cover>,
    /// The spheres that were read last.
    ids: [u32; AHEAD],
    centers: [[f64; 3]; AHEAD],
    radii: [f64; AHEAD],
}

impl Placing for Scenery<'_> {
    type Filling<'a>
        = Filler<'a>
    where
        Self: 'a;

    fn begin(&self, tile: Option<[u32; 2]>) -> Filler<'_> {
        let cover = tile.map(|tile| Cover::new(self.coverage, tile));
        Filler { scenery: self, cover, ids: [0; AHEAD], centers: [[0.0; 3]; AHEAD], radii: [0.0; AHEAD] }
    }
}

impl Filling for Filler<'_> {
    #[inline(always)]
    fn fetch(&mut self, ids: &[u32]) {
        let Scenery { source, ready, .. } = self.scenery;
        if !ready.is_empty() {
            self.ids[..ids.len()].copy_from_slice(ids);
            return;
        }
        // The last sphere is repeated to fill the vector; the copies are discarded.
        for n in 0..ids.len().next_multiple_of(LANES) {
            let id = ids[n.min(ids.len() - 1)];
            (self.ids[n], self.centers[n], self.radii[n]) = source.sphere(id);
        }
    }

    #[inline(always)]
    fn place(&mut self, first: usize, to: &mut [Placed]) {
        let ids = &self.ids[first..];
        if self.scenery.ready.is_empty() {
            let (mut centers, mut radii) = ([[0.0; 3]; LANES], [0.0; LANES]);
            centers.copy_from_slice(&self.centers[first..first + LANES]);
            radii.copy_from_slice(&self.radii[first..first + LANES]);
            self.scenery.project(ids, &centers, &radii, to);
        } else {
            to.iter_mut().zip(ids).for_each(|(placed, id)| *placed = self.scenery.ready[*id as usize]);
        }
        if let Some(cover) = &mut self.cover {
            to.iter().for_each(|placed| cover.add(placed));
        }
    }

    fn limit(&self) -> Option<f64> {
        self.cover.as_ref().and_then(Cover::limit)
    }
}
