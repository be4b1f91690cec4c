//! Host preparation for the certified kernel: each sphere in one of two forms, with bounds of the rounding errors in
//! f32 and on the host. docs/certificate.md derives the bounds.

use super::answer::ProjectionRecord;
use super::entry::Bin;
use super::general::GeneralRecord;
use super::general_lists::{GeneralLists, GeneralTree};
use super::grouped::{Grouped, GroupedBins};
use super::planes::{PlaneRecords, Ranks};
use super::projection::cover::Coverage;
pub(crate) use super::projection::cover::Through;
use super::projection::project::LaneBatch;
use super::projection::stage::Staged;
use super::projection::{ProjectionBounds, host_cull_margin};
use super::records::{RecordMaker, SPHERES_PER_JOB, SphereOrder};
use super::reference::{joined, reference};
use super::terms::{TERMS, Terms};
use super::tiles::Lists;
use crate::number::vector::LANES;
use crate::scene::{Scene, Spheres};
use crate::view::View;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel;
use pulp::NullaryFnOnce;

/// The scene as the certified kernel reads it.
#[derive(Debug, Clone)]
pub(crate) struct BinnedScene {
    pub(crate) projection: ProjectionRecord,
    pub(crate) lists: Lists,
    pub(crate) generals: Vec<GeneralRecord>,
    /// The general spheres that the rays of each tile may hit first.
    pub(crate) general_lists: GeneralLists,
    /// Projected spheres that some ray may hit.
    pub(crate) projected_count: u64,
    /// The planes that cut spheres, as rays pass them.
    pub(crate) planes: Option<PlaneRecords>,
}

impl BinnedScene {
    /// Returns its memory to the pool for the next frame.
    pub(crate) fn put_back(self, pool: &Pool) {
        self.lists.put_back(pool);
    }
}

/// Spheres that are in so many lists on average are projected once for all lists.
const PROJECTION_MIN_LISTS: u64 = 3;

/// Inputs of binning.
#[derive(Clone, Copy)]
pub(crate) struct Binning<'a> {
    pub(crate) scene: &'a Scene,
    /// The scene's spheres in groups: those that others certainly hide are left out. `None` to bin all spheres.
    pub(crate) groups: Option<Grouped<'a>>,
    pub(crate) view: &'a View,
    pub(crate) tolerance: f64,
    pub(crate) terms: &'a Terms,
    /// Tiles share candidate lists from this level on ([`Lists::new`]).
    pub(crate) level: u32,
    /// For hits behind the first: what hides spheres, which are left out of a tile's list. `None` where each sphere hides what lies behind it.
    pub(crate) through: Option<Through<'a>>,
    pub(crate) pool: &'a Pool,
}

impl<'a> Binning<'a> {
    /// All spheres of a scene, in lists of single tiles.
    pub(crate) fn of(scene: &'a Scene, view: &'a View, tolerance: f64, pool: &'a Pool) -> Self {
        Self { scene, groups: None, view, tolerance, terms: &TERMS, level: 0, through: None, pool }
    }
}

/// The bins of spheres.
struct SphereBins {
    /// The bin of every sphere, by its number.
    bins: Vec<Bin>,
    generals: Vec<GeneralRecord>,
    /// Least and largest depth of the projected spheres.
    range: Option<[f64; 2]>,
    /// Number of projected spheres.
    projected_count: u64,
    /// Number of their entries in lists of single tiles.
    entries: u64,
}

impl BinnedScene {
    /// Prepares a scene. `None` if the field of view is too wide or too narrow for f32, so that every pixel must be decided exactly.
    ///
    /// # Errors
    /// Errors of the camera.
    pub(crate) fn new(inputs: &Binning<'_>) -> Result<Option<Self>> {
        let projection = inputs.projection()?;
        Ok(projection.is_bounded().then(|| match inputs.groups {
            Some(groups) => inputs.bin_groups(&projection, groups),
            None => inputs.bin_all(&projection),
        }))
    }
}

impl Binning<'_> {
    fn projection(&self) -> Result<ProjectionBounds> {
        let size = [self.scene.image.width, self.scene.image.height];
        ProjectionBounds::new(&self.scene.camera, self.view, size, self.terms)
    }

    /// Whether f32 can bound the projection of the lens; else there are no lists.
    ///
    /// # Errors
    /// As [`BinnedScene::new`].
    pub(crate) fn is_bounded(&self) -> Result<bool> {
        Ok(self.projection()?.is_bounded())
    }

    /// Bins all spheres.
    fn bin_all(&self, projection: &ProjectionBounds) -> BinnedScene {
        let order = SphereOrder::of(&self.scene.spheres);
        let mut bins = projection.bin_spheres(order, 0.0, self.pool);
        let reference = reference(bins.range, !bins.generals.is_empty());
        if reference > 0.0 {
            self.pool.put_back(bins.bins);
            bins = projection.bin_spheres(order, reference.into(), self.pool);
        }
        self.list(projection, bins, order, reference)
    }

    /// Bins the spheres of the groups that some ray may hit first.
    fn bin_groups(&self, projection: &ProjectionBounds, groups: Grouped<'_>) -> BinnedScene {
        let size = [self.scene.image.width, self.scene.image.height];
        let found = projection.foremost(groups, size, self.view.record.window(), self.tolerance);
        let reference = found.reference(projection, groups);
        let GroupedBins { places, bins, generals, range, .. } = found;
        let order = SphereOrder::Places { groups, places: &places };
        let bins = if reference > 0.0 {
            projection.bin_spheres(order, reference.into(), self.pool)
        } else {
            let entries = Bin::total(&bins, 0);
            SphereBins { projected_count: bins.len() as u64, bins, generals, range, entries }
        };
        self.list(projection, bins, order, reference)
    }

    /// The lists of spheres with these bins.
    fn list(
        &self,
        projection: &ProjectionBounds,
        bins: SphereBins,
        order: SphereOrder<'_>,
        reference: f32,
    ) -> BinnedScene {
        let Self { scene, view, tolerance, level, through, pool, .. } = *self;
        let SphereBins { bins, mut generals, projected_count, entries, range } = bins;
        let cuts = scene.spheres.cuts.as_ref();
        let ranks = cuts.map(|cuts| Ranks::new(&scene.spheres, cuts));
        ranks.iter().for_each(|ranks| ranks.mark(&mut generals));
        let size = [scene.image.width, scene.image.height];
        let record = projection.record(reference, tolerance, generals.len());
        let margin = host_cull_margin(tolerance);
        let coverage = Coverage::new(projection, size, reference.into(), margin, projection.per_pixel);
        let ready = Vec::new();
        let mut maker = RecordMaker { projection, order, coverage, through, reference: reference.into(), cuts, ready };
        if entries >= PROJECTION_MIN_LISTS * bins.len() as u64 {
            maker.project_all(pool);
        }
        let lists = Lists::new(&bins, entries, view.record.tiles(), level, &maker, pool);
        pool.put_back(maker.ready);
        pool.put_back(bins);
        // Among general spheres all count that translucent or cut ones may not hide: they are few.
        let margin = if through.is_none() && cuts.is_none() { margin } else { f64::INFINITY };
        let near = GeneralTree::new(projection, &generals, size, margin);
        let general_lists = near.lists(view.record.tiles(), level);
        let deepest = range.map_or(0.0, |[_, deepest]| deepest);
        let planes = cuts
            .zip(ranks.as_ref())
            .map(|cuts| PlaneRecords::new(cuts, view, projection, (&lists, &generals), (reference, deepest)));
        BinnedScene { projection: record, lists, generals, general_lists, projected_count, planes }
    }
}

impl ProjectionBounds {
    /// The reference depth of all spheres.
    pub(super) fn reference_of(&self, spheres: &Spheres, pool: &Pool) -> f32 {
        let SphereBins { bins, range, generals, .. } = self.bin_spheres(SphereOrder::of(spheres), 0.0, pool);
        pool.put_back(bins);
        reference(range, !generals.is_empty())
    }

    /// Bins spheres, with depths of projected ones relative to `reference`.
    fn bin_spheres(&self, order: SphereOrder<'_>, reference: f64, pool: &Pool) -> SphereBins {
        // New memory is zeros that the system provides when a job first writes it, on that job's core. Bins of whole
        // batches need no copy of variable length.
        let mut bins: Vec<Bin> = pool.sized(order.len().next_multiple_of(LANES));
        let arch = pulp::Arch::new();
        let done = parallel::blocks(&mut bins[..], SPHERES_PER_JOB, &|places, bins| {
            let bins = bins.as_chunks_mut().0;
            arch.dispatch(Batch { projection: self, order, first: places.start, reference, bins })
        });
        bins.truncate(order.len());
        let range = done.iter().filter_map(|(sums, _)| sums.range()).reduce(joined);
        let projected_count = done.iter().flat_map(|(sums, _)| sums.projected_count).sum();
        let entries = done.iter().flat_map(|(sums, _)| sums.entries).sum();
        SphereBins {
            bins,
            generals: done.into_iter().flat_map(|(_, generals)| generals).collect(),
            range,
            projected_count,
            entries,
        }
    }
}

/// The spheres of one binning job, from number `first` on.
struct Batch<'a> {
    projection: &'a ProjectionBounds,
    order: SphereOrder<'a>,
    first: usize,
    reference: f64,
    /// A bin per lane; beyond the last sphere it has no meaning.
    bins: &'a mut [[Bin; LANES]],
}

impl NullaryFnOnce for Batch<'_> {
    type Output = (Sums, Vec<GeneralRecord>);

    #[inline(always)]
    fn call(self) -> (Sums, Vec<GeneralRecord>) {
        let Self { projection, order, first, reference, bins } = self;
        let (mut sums, mut generals) = (Sums::NONE, Vec::new());
        let mut batch = LaneBatch::NONE;
        for (first, bins) in (first..).step_by(LANES).zip(bins) {
            batch.fill(first..order.len(), |n| order.sphere(n));
            let eight = projection.eight(&batch, reference);
            *bins = eight.bins();
            for l in 0..LANES {
                let is_projected = (eight.projected[l] != 0) & (l < batch.count);
                sums.add(l, is_projected, eight.depth[l], if is_projected { eight.entries(l) } else { 0 });
            }
            if eight.other == [0; LANES] {
                continue;
            }
            for (l, bin) in bins[..batch.count].iter_mut().enumerate().filter(|(l, _)| eight.other[*l] != 0) {
                match projection.stage(batch.ids[l], batch.centers[l], batch.radii[l], reference) {
                    Staged::Projected(landed) => {
                        *bin = landed.bin;
                        sums.add(l, true, landed.placed.depth, bin.entries(0));
                    }
                    Staged::General(record) => generals.push(record),
                    Staged::Unseen => {}
                }
            }
        }
        (sums, generals)
    }
}

/// Depths and numbers of projected spheres, per lane.
struct Sums {
    range: [[f64; LANES]; 2],
    projected_count: [u64; LANES],
    entries: [u64; LANES],
}

impl Sums {
    const NONE: Self = Self {
        range: [[f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]],
        projected_count: [0; LANES],
        entries: [0; LANES],
    };

    /// Adds a sphere with its entries if it is seen, without a branch.
    #[inline(always)]
    fn add(&mut self, l: usize, is_projected: bool, depth: f64, entries: u64) {
        let [least, most] = [0, 1].map(|k| self.range[k][l]);
        self.range[0][l] = if is_projected & (depth < least) { depth } else { least };
        self.range[1][l] = if is_projected & (depth > most) { depth } else { most };
        self.projected_count[l] += u64::from(is_projected);
        self.entries[l] += entries;
    }

    /// Least and largest depth of all lanes.
    fn range(&self) -> Option<[f64; 2]> {
        let lanes = (0..LANES).filter(|l| self.projected_count[*l] > 0);
        lanes.map(|l| [self.range[0][l], self.range[1][l]]).reduce(joined)
    }
}
