//! Makes the records of lists from front to back, and tracks the pixels that they cover.

use super::entry::Placed;
use super::grouped::Grouped;
use super::projection::ProjectionBounds;
use super::projection::cover::{Cover, Coverage, Through};
use super::projection::project::LaneBatch;
use super::projection::stage::Staged;
use crate::number::vector::LANES;
use crate::scene::{Cuts, NumberedBall, Spheres};
use crate::tile::CHUNK;
use halfline_ground::memory::Pool;
use halfline_ground::parallel;
use pulp::NullaryFnOnce;

/// The spheres of lists, by their numbers.
#[derive(Clone, Copy)]
pub(super) enum SphereOrder<'a> {
    /// All of a scene: their numbers are their ids.
    InMemory { centers: &'a [[f64; 3]], radii: &'a [f64] },
    /// Spheres in some places of the order of groups.
    Places { groups: Grouped<'a>, places: &'a [u32] },
}

impl<'a> SphereOrder<'a> {
    /// All spheres of a scene.
    pub(super) fn of(spheres: &'a Spheres) -> Self {
        Self::InMemory { centers: &spheres.centers, radii: &spheres.radii }
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::InMemory { radii, .. } => radii.len(),
            Self::Places { places, .. } => places.len(),
        }
    }

    /// The sphere with this number.
    #[inline(always)]
    pub(super) fn sphere(&self, number: usize) -> NumberedBall {
        match self {
            Self::InMemory { centers, radii } => NumberedBall::of(centers, radii, number),
            Self::Places { groups, places } => groups.sphere(places[number] as usize),
        }
    }
}

/// Spheres that are read together: they lie anywhere in memory, and a processor waits for many of them at once.
pub(super) const AHEAD: usize = 8 * CHUNK;

// A chunk is a batch.
const _: () = assert!(CHUNK == LANES);

/// Creates the records of lists.
pub(super) struct RecordMaker<'a> {
    pub(super) projection: &'a ProjectionBounds,
    pub(super) order: SphereOrder<'a>,
    pub(super) coverage: Coverage,
    /// The layers that a ray shows; `None` for the first hit alone.
    pub(super) through: Option<Through<'a>>,
    pub(super) reference: f64,
    /// The planes that cut spheres.
    pub(super) cuts: Option<&'a Cuts>,
    /// The records of all spheres by their numbers, where most spheres are in several lists; else empty.
    pub(super) ready: Vec<Placed>,
}

/// Spheres that one job projects.
pub(super) const SPHERES_PER_JOB: usize = 1 << 14;

impl RecordMaker<'_> {
    /// Projects all spheres, also spheres that are in no list.
    pub(super) fn project_all(&mut self, pool: &Pool) {
        let mut ready: Vec<Placed> = pool.sized(self.order.len());
        let (maker, arch) = (&*self, pulp::Arch::new());
        parallel::fill(&mut ready[..], SPHERES_PER_JOB, &|places, to| {
            arch.dispatch(Ready { maker, first: places.start, to });
        });
        self.ready = ready;
    }

    /// The records of lists, one after the other.
    pub(super) fn lists(&self) -> ListRecords<'_> {
        ListRecords { maker: self, cover: None, numbers: [0; AHEAD], batches: [LaneBatch::NONE; AHEAD / LANES] }
    }

    /// Writes the records of the spheres of a batch to `to`. Spheres without one leave theirs unchanged.
    #[inline(always)]
    fn project(&self, batch: &LaneBatch, to: &mut [Placed]) {
        let Self { projection, reference, .. } = *self;
        let LaneBatch { ids, centers, radii, .. } = batch;
        let eight = projection.eight(batch, reference);
        for (l, placed) in to.iter_mut().enumerate() {
            if eight.projected[l] != 0 {
                *placed = eight.placed(l, ids[l]);
            } else if let Staged::Projected(landed) = projection.stage(ids[l], centers[l], radii[l], reference) {
                *placed = landed.placed;
            }
        }
    }
}

/// The spheres from number `first` on, all of them projected.
struct Ready<'a> {
    maker: &'a RecordMaker<'a>,
    first: usize,
    to: &'a mut [Placed],
}

impl NullaryFnOnce for Ready<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { maker, first, to } = self;
        let mut batch = LaneBatch::NONE;
        for (first, to) in (first..).step_by(LANES).zip(to.chunks_mut(LANES)) {
            batch.fill(first..first + to.len(), |n| maker.order.sphere(n));
            maker.project(&batch, to);
        }
    }
}

/// The records of one list, from front to back.
pub(super) struct ListRecords<'a> {
    maker: &'a RecordMaker<'a>,
    /// The coverage of the tile's pixels, if the list serves one tile.
    cover: Option<Cover>,
    /// The numbers of the spheres that were read last, and, where no records are ready, the spheres themselves.
    numbers: [u32; AHEAD],
    batches: [LaneBatch; AHEAD / LANES],
}

impl ListRecords<'_> {
    /// Begins the list of the tile at this column and row of tiles, or of several tiles (`None`).
    pub(super) fn begin(&mut self, tile: Option<[u32; 2]>) {
        self.cover = tile.map(|tile| Cover::new(self.maker.coverage, tile));
    }

    /// Reads the spheres that come next, at most [`AHEAD`].
    #[inline(always)]
    pub(super) fn fetch(&mut self, numbers: &[u32]) {
        let RecordMaker { order, ready, .. } = self.maker;
        if !ready.is_empty() {
            self.numbers[..numbers.len()].copy_from_slice(numbers);
            return;
        }
        for (first, batch) in (0..numbers.len()).step_by(LANES).zip(&mut self.batches) {
            batch.fill(first..numbers.len(), |n| order.sphere(numbers[n] as usize));
        }
    }

    /// Writes the records of a chunk of the spheres that [`Self::fetch`] read, and marks the pixels of the tile that
    /// they cover.
    #[inline(always)]
    pub(super) fn place(&mut self, chunk: usize, to: &mut [Placed]) {
        let ready = &self.maker.ready;
        if ready.is_empty() {
            self.maker.project(&self.batches[chunk], to);
        } else {
            to.iter_mut().zip(&self.numbers[chunk * CHUNK..]).for_each(|(placed, n)| *placed = ready[*n as usize]);
        }
        if let Some(cover) = &mut self.cover {
            // A cut sphere hides nothing.
            let hiding = to.iter().filter(|placed| self.maker.cuts.is_none_or(|cuts| !cuts.is_cut(placed.detail.id)));
            match self.maker.through {
                None => hiding.for_each(|placed| cover.add(placed)),
                Some(Through { opacities, layers }) => hiding.for_each(|placed| {
                    let is_opaque = opacities[placed.detail.id as usize] == 1.0;
                    if is_opaque { cover.add(placed) } else { cover.add_layer(placed, layers) }
                }),
            }
        }
    }

    /// The depth beyond which every sphere is certainly occluded, if known: no sphere with a higher minimum is hit first.
    pub(super) fn limit(&self) -> Option<f64> {
        self.cover.as_ref().and_then(Cover::limit)
    }
}
