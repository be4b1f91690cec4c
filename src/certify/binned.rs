//! What the host prepares for the certified kernel: spheres in one of two forms, each with the bounds of what f32 and
//! the host's own rounding can do to it. docs/certificate.md derives the bounds.

use super::lens::cover::Cover;
use super::lens::project::{Eight, LANES};
use super::lens::{Lens, Rotation, Staged};
use super::near::NearRecord;
use super::tiles::{Bin, Filling, Lists, Placed, Placing};
use super::{LensRecord, Terms};
use crate::dd;
use crate::error::Result;
use crate::memory::Pool;
use crate::scene::Scene;
use crate::view::View;
use pulp::NullaryFnOnce;
use rayon::prelude::*;

/// The scene as the certified kernel sees it.
#[derive(Debug, Clone)]
pub(crate) struct BinnedScene {
    pub(crate) lens: LensRecord,
    pub(crate) lists: Lists,
    pub(crate) nears: Vec<NearRecord>,
    /// Front spheres that some ray may meet.
    pub(crate) seen: u64,
}

impl BinnedScene {
    /// Leaves its memory to the next frame.
    pub(crate) fn put_back(self, pool: &Pool) {
        pool.put_back(self.lists.fronts);
        pool.put_back(self.lists.mores);
        pool.put_back(self.lists.sills);
    }
}

/// What a certified hit's depth is counted from.
pub(crate) struct Depths<'a> {
    rotation: Rotation,
    unit: i32,
    centers: &'a [[f64; 3]],
    nears: &'a [NearRecord],
}

impl<'a> Depths<'a> {
    /// Of the spheres of `scene`, some of them staged as near ones.
    pub(crate) fn new(scene: &'a Scene, view: &View, binned: Option<&'a BinnedScene>) -> Self {
        let nears = binned.map_or(&[][..], |binned| &binned.nears);
        Self {
            rotation: Rotation::new(&view.basis, view.unit),
            unit: view.unit,
            centers: &scene.spheres.centers,
            nears,
        }
    }

    /// Depth of a front sphere's centre in the scene's unit, as it was staged; 0 for a near sphere. A hit's depth is
    /// this plus its offset.
    pub(crate) fn of(&self, id: u32) -> f64 {
        if self.nears.binary_search_by_key(&id, |near| near.id).is_ok() {
            return 0.0;
        }
        let depth = |center: &[f64; 3]| dd::ldexp(self.rotation.of(*center).1[2], self.unit);
        self.centers.get(id as usize).map_or(0.0, depth)
    }
}

/// Spheres that one job bins.
const TOGETHER: usize = 1 << 14;

/// Where all spheres belong.
struct SphereBins {
    /// Of every sphere, by its id.
    bins: Vec<Bin>,
    nears: Vec<NearRecord>,
    /// Least and largest depth of the front spheres.
    range: Option<[f64; 2]>,
    /// How many there are.
    seen: u64,
}

impl BinnedScene {
    /// Prepares `scene`; `None` when its lens is too wide or too narrow for f32, and everything must be judged exactly.
    /// Tiles share the lists of candidates from `level` on ([`Lists::new`]).
    pub(crate) fn new(
        scene: &Scene,
        view: &View,
        tolerance: f64,
        terms: &Terms,
        level: u32,
        pool: &Pool,
    ) -> Result<Option<Self>> {
        let (width, height) = (scene.image.width, scene.image.height);
        let viewport = scene.camera.viewport(width, height)?;
        let lens = Lens::new(&scene.camera, view, &viewport, terms)?;
        if !lens.is_bounded() {
            return Ok(None);
        }
        let mut sphere_bins = lens.bin_spheres(scene, 0.0, pool);
        let reference = reference(&sphere_bins);
        if reference > 0.0 {
            pool.put_back(sphere_bins.bins);
            sphere_bins = lens.bin_spheres(scene, reference.into(), pool);
        }
        let mut record = lens.record(reference, tolerance);
        record.nears = sphere_bins.nears.len() as u32;
        let placing = Scenery { lens: &lens, scene, size: [width, height], reference: reference.into() };
        let lists = Lists::new(&sphere_bins.bins, view.record.tiles(), level, &placing, pool);
        pool.put_back(sphere_bins.bins);
        Ok(Some(Self { lens: record, lists, nears: sphere_bins.nears, seen: sphere_bins.seen }))
    }
}

/// A depth to keep the others relative to: where all spheres are far and close together, so that their order survives.
fn reference(sphere_bins: &SphereBins) -> f32 {
    match sphere_bins.range {
        // The nearest surface is no nearer than a quarter of the nearest centre's depth.
        Some([least, most]) if sphere_bins.nears.is_empty() && least > 4.0 * (most - least) => least as f32,
        _ => 0.0,
    }
}

impl Lens {
    /// Bins all spheres; depths of front spheres are kept relative to `reference`.
    fn bin_spheres(&self, scene: &Scene, reference: f64, pool: &Pool) -> SphereBins {
        let spheres = scene.spheres.centers.par_chunks(TOGETHER).zip(scene.spheres.radii.par_chunks(TOGETHER));
        let mut bins = pool.take(scene.spheres.len());
        bins.resize(scene.spheres.len(), Bin::NOWHERE);
        let arch = pulp::Arch::new();
        let jobs = spheres.zip(bins.par_chunks_mut(TOGETHER)).enumerate();
        let done: Vec<_> = jobs
            .map(|(n, ((centers, radii), bins))| {
                let first = n * TOGETHER;
                arch.dispatch(Batch { first, lens: self, reference, centers, radii, bins })
            })
            .collect();
        let seen = done.iter().map(|job| job.seen).sum();
        let ranges = done.iter().filter_map(|job| job.range);
        let range = ranges.reduce(|[a, b], [least, most]| [a.min(least), b.max(most)]);
        SphereBins { bins, nears: done.into_iter().flat_map(|job| job.nears).collect(), range, seen }
    }
}

/// Spheres that one job bins.
struct Batch<'a> {
    first: usize,
    lens: &'a Lens,
    reference: f64,
    centers: &'a [[f64; 3]],
    radii: &'a [f64],
    bins: &'a mut [Bin],
}

/// What it finds besides.
#[derive(Default)]
struct Found {
    nears: Vec<NearRecord>,
    range: Option<[f64; 2]>,
    seen: u64,
}

impl Found {
    fn see(&mut self, depth: f64) {
        let [least, most] = self.range.unwrap_or([depth; 2]);
        self.range = Some([least.min(depth), most.max(depth)]);
        self.seen += 1;
    }
}

impl NullaryFnOnce for Batch<'_> {
    type Output = Found;

    #[inline(always)]
    fn call(self) -> Found {
        let mut found = Found::default();
        for first in (0..self.bins.len()).step_by(LANES) {
            let there = LANES.min(self.bins.len() - first);
            // The last ones are repeated, and then left alone.
            let at = |l: usize| first + l.min(there - 1);
            let (centers, radii) =
                (std::array::from_fn(|l| self.centers[at(l)]), std::array::from_fn(|l| self.radii[at(l)]));
            let eight = self.lens.eight(&centers, &radii, self.reference);
            for l in 0..there {
                let bin = &mut self.bins[first + l];
                *bin = Bin::NOWHERE;
                if eight.front[l] != 0 {
                    *bin = eight.bin(l);
                    found.see(eight.depth[l]);
                } else if eight.other[l] != 0 {
                    let id = (self.first + first + l) as u32;
                    match self.lens.stage(id, centers[l], radii[l], self.reference) {
                        Staged::Unseen => {}
                        Staged::Near(record) => found.nears.push(record),
                        Staged::Front(landed) => {
                            *bin = landed.bin;
                            found.see(landed.depth);
                        }
                    }
                }
            }
        }
        found
    }
}

/// Makes the records of lists.
struct Scenery<'a> {
    lens: &'a Lens,
    scene: &'a Scene,
    size: [u32; 2],
    reference: f64,
}

/// Those of one list.
struct Filler<'a> {
    scenery: &'a Scenery<'a>,
    cover: Option<Cover>,
}

impl Placing for Scenery<'_> {
    type Filling<'a>
        = Filler<'a>
    where
        Self: 'a;

    fn begin(&self, tile: Option<[u32; 2]>) -> Filler<'_> {
        Filler { scenery: self, cover: tile.map(|tile| Cover::new(tile, self.size)) }
    }
}

/// Spheres whose records are made together.
struct Together<'a> {
    lens: &'a Lens,
    centers: [[f64; 3]; LANES],
    radii: [f64; LANES],
    reference: f64,
}

impl NullaryFnOnce for Together<'_> {
    type Output = Eight;

    #[inline(always)]
    fn call(self) -> Eight {
        self.lens.eight(&self.centers, &self.radii, self.reference)
    }
}

impl Filling for Filler<'_> {
    fn place(&mut self, ids: &[u32], to: &mut [Placed]) {
        let Scenery { lens, scene, reference, .. } = *self.scenery;
        let id = |l: usize| ids[l.min(ids.len() - 1)];
        let (centers, radii) = (
            std::array::from_fn(|l| scene.spheres.centers[id(l) as usize]),
            std::array::from_fn(|l| scene.spheres.radii[id(l) as usize]),
        );
        let eight = pulp::Arch::new().dispatch(Together { lens, centers, radii, reference });
        for (l, placed) in to.iter_mut().enumerate() {
            if eight.front[l] != 0 {
                *placed = eight.placed(l, ids[l]);
            } else if let Staged::Front(landed) = lens.stage(ids[l], centers[l], radii[l], reference) {
                *placed = landed.placed;
            }
            if let Some(cover) = &mut self.cover {
                cover.add(lens, reference, placed);
            }
        }
    }

    fn limit(&self) -> Option<f64> {
        self.cover.as_ref().and_then(Cover::limit)
    }
}
