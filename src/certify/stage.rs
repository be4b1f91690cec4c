//! What the host prepares for the certified kernel: spheres in one of two forms, each with the bounds of what f32 and
//! the host's own rounding can do to it. docs/certificate.md derives the bounds.

use super::lens::{Lens, Staged, moved};
use super::near::NearRecord;
use super::tiles::{Lists, Run, TOGETHER};
use super::{LensRecord, Terms};
use crate::camera::Basis;
use crate::error::Result;
use crate::memory::Pool;
use crate::scene::Scene;
use crate::view::View;
use rayon::prelude::*;

/// Largest |d|^2 whose squares a near sphere's bound can hold; a wider lens is judged exactly.
const UNBOUNDED: f64 = (1u64 << 40) as f64;
/// The scene as the certified kernel sees it.
#[derive(Debug, Clone)]
pub(crate) struct Stage {
    pub(crate) lens: LensRecord,
    pub(crate) lists: Lists,
    pub(crate) nears: Vec<NearRecord>,
    /// Front spheres that some ray may meet.
    pub(crate) seen: u64,
}

impl Stage {
    /// Leaves its memory to the next frame.
    pub(crate) fn give_to(self, pool: &Pool) {
        pool.give(self.lists.fronts);
        pool.give(self.lists.mores);
        pool.give(self.lists.sills);
    }
}

/// What a certified hit's depth is counted from.
pub(crate) struct Depths<'a> {
    basis: Basis,
    centers: &'a [[f64; 3]],
    nears: &'a [NearRecord],
}

impl<'a> Depths<'a> {
    /// Of the spheres of `scene`, some of them staged as near ones.
    pub(crate) fn new(scene: &'a Scene, view: &View, stage: Option<&'a Stage>) -> Self {
        let nears = stage.map_or(&[][..], |stage| &stage.nears);
        Self { basis: view.basis, centers: &scene.spheres.centers, nears }
    }

    /// Depth of a front sphere's centre in the scene's unit, as it was staged; 0 for a near sphere. A hit's depth is
    /// this plus its offset.
    pub(crate) fn of(&self, id: u32) -> f64 {
        if self.nears.binary_search_by_key(&id, |near| near.id).is_ok() {
            return 0.0;
        }
        self.centers.get(id as usize).map_or(0.0, |center| moved(&self.basis, *center).1[2])
    }
}

/// Spheres that were staged together.
#[derive(Default)]
struct Batch {
    run: Run,
    nears: Vec<NearRecord>,
    /// Least and largest depth of the front spheres.
    range: Option<(f64, f64)>,
}

impl Stage {
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
        let (width, height) = (view.record.width, view.record.height);
        let viewport = scene.camera.viewport(width, height)?;
        let lens = Lens::new(&scene.camera, view, &viewport, terms)?;
        let narrow = lens.slope.iter().any(|slope| *slope < 2f64.powi(-100));
        if narrow || lens.widest > UNBOUNDED {
            return Ok(None);
        }
        let mut batches = lens.batches(scene, 0.0, pool);
        let reference = reference(&batches);
        if reference > 0.0 {
            batches = lens.batches(scene, reference, pool);
        }
        let mut record = lens.record(reference, tolerance);
        let nears: Vec<_> = batches.iter_mut().flat_map(|batch| std::mem::take(&mut batch.nears)).collect();
        record.nears = nears.len() as u32;
        let runs: Vec<_> = batches.into_iter().map(|batch| batch.run).collect();
        let seen = runs.iter().map(|run| run.bins.len() as u64).sum();
        let lists = Lists::new(&runs, [width, height], level, pool);
        for run in runs {
            pool.give(run.placed);
            pool.give(run.bins);
        }
        Ok(Some(Self { lens: record, lists, nears, seen }))
    }
}

/// A depth to keep the others relative to: where all spheres are far and close together, so that their order survives.
fn reference(batches: &[Batch]) -> f32 {
    if batches.iter().any(|batch| !batch.nears.is_empty()) {
        return 0.0;
    }
    let ranges = batches.iter().filter_map(|batch| batch.range);
    let (least, most) = ranges.fold((f64::INFINITY, 0.0f64), |(a, b), (c, d)| (a.min(c), b.max(d)));
    // The nearest surface is no nearer than a quarter of the nearest centre's depth.
    if least.is_finite() && least > 4.0 * (most - least) { least as f32 } else { 0.0 }
}

impl Lens {
    /// Stages all spheres; depths of front spheres are kept relative to `reference`.
    fn batches(&self, scene: &Scene, reference: f32, pool: &Pool) -> Vec<Batch> {
        let spheres = scene.spheres.centers.par_chunks(TOGETHER).zip(scene.spheres.radii.par_chunks(TOGETHER));
        let stage = |(n, (centers, radii)): (usize, (&[[f64; 3]], &[f64]))| {
            let mut batch = Batch { run: Run::with_capacity(centers.len(), pool), ..Batch::default() };
            for (k, (center, radius)) in centers.iter().zip(radii).enumerate() {
                let id = (n * TOGETHER + k) as u32;
                match self.stage(id, *center, *radius) {
                    Staged::Unseen => {}
                    Staged::Near(record) => batch.nears.push(record),
                    Staged::Front(p) => {
                        let (least, most) = batch.range.unwrap_or((p.depth, p.depth));
                        batch.range = Some((least.min(p.depth), most.max(p.depth)));
                        let (placed, bin) = self.place(id, &p, reference);
                        batch.run.placed.push(placed);
                        batch.run.bins.push(bin);
                    }
                }
            }
            batch
        };
        spheres.enumerate().map(stage).collect()
    }
}
