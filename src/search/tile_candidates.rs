//! Per-tile candidate lists for uncertified methods: the lists of the certified kernel with the method's own sphere
//! records. A method tests only the spheres that the rays of a tile may hit and that may be nearer than the current
//! hit. Its false hits on other spheres therefore do not appear; every other answer equals that of testing all spheres.

use crate::certify::binned::BinnedScene;
use crate::memory::Pool;
use crate::number::Number;
use crate::scene::Spheres;
use crate::tile::CHUNK;
use crate::view::ray::NONE;
use crate::view::{Sphere, SphereRecord, SphereResiduals, View};
use bytemuck::Pod;
use rayon::prelude::*;
use std::ops::Range;

/// The rest of a list is skipped if it begins farther behind the hit than this share of the hit's t. The share is far
/// larger than the error of t in any usable method (half of f32's digits for the lecture's). A method with a larger
/// error may skip a sphere, and then gives another wrong answer or a miss.
const MARGIN: f64 = 1.0 / (1 << 10) as f64;

/// Larger than every t of a frame and smaller than the t of a miss: without a hit no list is skipped.
const FAR: f64 = 3.0e38;

/// The candidate lists of a binned scene, with access to the scene's spheres.
#[derive(Clone, Copy)]
pub(crate) struct TileCandidates<'a> {
    pub(crate) view: &'a View,
    pub(crate) spheres: &'a Spheres,
    pub(crate) binned: &'a BinnedScene,
    /// Whether rounding errors of the spheres are read too.
    pub(crate) wide: bool,
    pool: &'a Pool,
    /// t per unit of a chunk's minimum depth, less the margin.
    per_depth: f64,
}

/// The candidate lists of a frame.
#[derive(Clone, Copy)]
pub(crate) enum CandidateList<'a> {
    /// For the certified kernel.
    Certified(&'a BinnedScene),
    /// For a method without a certificate.
    Uncertified(TileCandidates<'a>),
}

impl<'a> CandidateList<'a> {
    /// The binned scene behind the lists.
    pub(crate) fn binned(&self) -> &'a BinnedScene {
        match self {
            Self::Certified(binned) => binned,
            Self::Uncertified(tile_candidates) => tile_candidates.binned,
        }
    }
}

impl<'a> TileCandidates<'a> {
    pub(crate) fn new(
        view: &'a View,
        spheres: &'a Spheres,
        binned: &'a BinnedScene,
        wide: bool,
        pool: &'a Pool,
    ) -> Self {
        // t is the planar depth over d.
        Self { view, spheres, binned, wide, pool, per_depth: (1.0 - MARGIN) / view.pitch[2] }
    }

    /// Centre and radius of the sphere with this id.
    fn world(&self, id: u32) -> ([f64; 3], f64) {
        (self.spheres.centers[id as usize], self.spheres.radii[id as usize])
    }

    /// The sphere with this id in the arithmetic of a twin.
    pub(crate) fn sphere<R: Number>(&self, id: u32) -> Sphere<R> {
        let (center, radius) = self.world(id);
        let record = self.view.sphere(id, center, radius);
        match self.wide {
            true => Sphere::with_residuals(&record, &self.view.residuals_of(center, radius)),
            false => Sphere::from(&record),
        }
    }

    /// The ids of a range of list entries; [`NONE`] pads a list.
    pub(crate) fn ids(&self, entries: Range<usize>) -> impl Iterator<Item = u32> + '_ {
        self.binned.lists.details[entries].iter().map(|more| more.id)
    }

    /// A ray whose current hit has a smaller t than this, in the frame's unit, skips this chunk and the rest of its list.
    pub(crate) fn limit(&self, chunk: usize) -> f32 {
        let depth = f64::from(self.binned.projection.depth) + f64::from(self.binned.lists.chunk_min_depths[chunk]);
        (depth * self.per_depth).min(FAR) as f32
    }

    /// The number of entries that the general spheres take, padded to whole chunks.
    pub(crate) fn generals(&self) -> usize {
        self.binned.generals.len().next_multiple_of(CHUNK)
    }

    /// The records of the general spheres and then of a range of list entries. Chunks are padded by repeating the last
    /// sphere, which is not closer than itself.
    pub(crate) fn records(&self, entries: Range<usize>) -> Vec<SphereRecord> {
        self.places(entries, |id, (center, radius)| self.view.sphere(id, center, radius))
    }

    /// The rounding errors of each of these.
    pub(crate) fn residuals(&self, entries: Range<usize>) -> Vec<SphereResiduals> {
        self.places(entries, |_, (center, radius)| self.view.residuals_of(center, radius))
    }

    /// [`Self::limit`] of each chunk of these; every ray tests the general spheres.
    pub(crate) fn limits(&self, entries: Range<usize>) -> Vec<f32> {
        let of_lists = (entries.start / CHUNK..entries.end / CHUNK).map(|chunk| self.limit(chunk));
        std::iter::repeat_n(0.0, self.generals() / CHUNK).chain(of_lists).collect()
    }

    /// Returns an uploaded vector to the pool.
    pub(crate) fn put_back<T: Send + 'static>(&self, vector: Vec<T>) {
        self.pool.put_back(vector);
    }

    fn places<T: Pod + Send + Sync>(
        &self,
        entries: Range<usize>,
        make: impl Fn(u32, ([f64; 3], f64)) -> T + Sync,
    ) -> Vec<T> {
        let generals = self.generals();
        let mut places: Vec<T> = self.pool.take(generals + entries.len());
        places.resize(generals + entries.len(), T::zeroed());
        let fill = |chunk: &mut [T], ids: [u32; CHUNK]| {
            // All spheres are loaded before any record is made, because they lie far apart in memory.
            let worlds = ids.map(|id| if id == NONE { Default::default() } else { self.world(id) });
            let mut last = T::zeroed();
            for ((place, id), world) in chunk.iter_mut().zip(ids).zip(worlds) {
                if id != NONE {
                    last = make(id, world);
                }
                *place = last;
            }
        };
        let (of_generals, of_lists) = places.split_at_mut(generals);
        for (chunk, generals) in of_generals.chunks_mut(CHUNK).zip(self.binned.generals.chunks(CHUNK)) {
            fill(chunk, std::array::from_fn(|n| generals.get(n).map_or(NONE, |general| general.id)));
        }
        let details = &self.binned.lists.details[entries];
        of_lists.par_chunks_mut(CHUNK).zip(details.par_chunks(CHUNK)).for_each(|(chunk, details)| {
            fill(chunk, std::array::from_fn(|n| details.get(n).map_or(NONE, |more| more.id)));
        });
        places
    }
}
