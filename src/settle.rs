//! Settle: what f32 could not prove is decided again, in double-double with proven bounds and then exactly.

use crate::certify::stage::Stage;
use crate::certify::{Certify, VANISH};
use crate::error::Result;
use crate::exact::{Judge, Truth};
use crate::ray::UNSURE;
use crate::scene::{Scene, Spheres};
use crate::view::View;
use rayon::prelude::*;

/// A pixel that was decided again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settled {
    /// Row times width plus column.
    pub(crate) pixel: u32,
    /// What its ray hits.
    pub(crate) truth: Option<Truth>,
}

/// The pixels of `ids` that a certified kernel left open.
pub(crate) fn unsure(ids: &[u32]) -> Vec<u32> {
    ids.par_iter().positions(|id| *id == UNSURE).map(|pixel| pixel as u32).collect()
}

/// Candidates that may be held at once: 64 MiB, and as much again for those of each pixel's own.
const AT_ONCE: usize = 1 << 24;

/// Decides every unsure pixel, among the spheres that may be its nearest hit by their lower bounds of depth. The twin asks
/// anew: its bounds hold as the kernel's do, however either rounds. `go_on` is asked before every pixel; after a `false` the
/// answers are worth nothing.
pub(crate) fn settle(
    scene: &Scene,
    view: &View,
    stage: &Stage,
    unsure: &[u32],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Settled>> {
    let settler = Settler { scene, twin: Certify::new(&view.record, stage), go_on };
    let mut settled = Vec::with_capacity(unsure.len());
    let mut left = unsure;
    while !left.is_empty() {
        let mut held = 0;
        let fits = |pixel: &&u32| {
            held += settler.most(**pixel);
            held <= AT_ONCE
        };
        let (now, later) = left.split_at(left.iter().take_while(fits).count().max(1));
        settled.extend(settler.decide(now)?);
        left = later;
    }
    Ok(settled)
}

/// Decides unsure pixels.
struct Settler<'a> {
    scene: &'a Scene,
    twin: Certify<'a, f32>,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Settler<'_> {
    /// How many candidates a pixel may have.
    fn most(&self, pixel: u32) -> usize {
        let width = self.scene.image.width;
        let [first, end] = self.twin.lists.range(pixel / width, pixel % width);
        (end - first) as usize + self.twin.nears.len()
    }

    /// The spheres that may be the nearest hit of `pixel`, in the scene's order.
    fn candidates(&self, pixel: u32) -> Vec<u32> {
        let (twin, width) = (&self.twin, self.scene.image.width);
        if !(self.go_on)() {
            return Vec::new();
        }
        let slopes = twin.slopes(pixel / width, pixel % width);
        let mut all: Vec<_> = twin.candidates(&slopes).collect();
        // The depth that the nearest hit surely does not exceed.
        let foremost = all.iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let answer = foremost.map(|(_, slot)| twin.answer(&slopes, *slot)).filter(|answer| answer.hits);
        let limit = answer.map_or(f32::MAX, |answer| answer.high + VANISH);
        all.retain(|(low, _)| *low <= limit);
        let mut ids: Vec<u32> = all.into_iter().map(|(_, slot)| twin.id(slot)).collect();
        ids.sort_unstable();
        ids
    }

    fn decide(&self, pixels: &[u32]) -> Result<Vec<Settled>> {
        let (scene, width) = (self.scene, self.scene.image.width);
        let lists: Vec<Vec<u32>> = pixels.par_iter().map(|pixel| self.candidates(*pixel)).collect();
        // Only the spheres in question are prepared; in their order, so that the lower id stays the lower.
        let mut ids: Vec<u32> = lists.concat();
        ids.par_sort_unstable();
        ids.dedup();
        let mut spheres = Spheres::default();
        for &id in &ids {
            spheres.push(scene.spheres.centers[id as usize], scene.spheres.radii[id as usize], None);
        }
        let few = Scene { camera: scene.camera, image: scene.image, spheres, skipped: Default::default() };
        let judge = Judge::new(&few)?;
        let local = |id: &u32| ids.binary_search(id).map_or(u32::MAX, |k| k as u32);
        let decide = |(&pixel, own): (&u32, &Vec<u32>)| {
            let candidates: Vec<u32> = own.iter().map(local).collect();
            let truth = judge.among(pixel / width, pixel % width, &candidates);
            Settled { pixel, truth: truth.map(|truth| Truth { id: ids[truth.id as usize], ..truth }) }
        };
        Ok(pixels.par_iter().zip(&lists).map(decide).collect())
    }
}

/// Decides every pixel among all spheres: the judge itself. `go_on` is asked before every row.
pub(crate) fn exact(scene: &Scene, go_on: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Settled>> {
    let judge = Judge::new(scene)?;
    let (width, height) = (scene.image.width, scene.image.height);
    let row = |i: u32| {
        let columns = if go_on() { 0..width } else { 0..0 };
        let judge = &judge;
        columns.map(move |j| Settled { pixel: i * width + j, truth: judge.pixel(i, j) }).collect::<Vec<_>>()
    };
    Ok((0..height).into_par_iter().flat_map_iter(row).collect())
}
