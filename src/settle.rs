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
    let width = scene.image.width;
    let twin = Certify::<f32>::new(&view.record, stage);
    let candidates = |pixel: &u32| {
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
    };
    let lists: Vec<Vec<u32>> = unsure.par_iter().map(candidates).collect();
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
        if !go_on() {
            return Settled { pixel, truth: None };
        }
        let candidates: Vec<u32> = own.iter().map(local).collect();
        let truth = judge.among(pixel / width, pixel % width, &candidates);
        Settled { pixel, truth: truth.map(|truth| Truth { id: ids[truth.id as usize], ..truth }) }
    };
    Ok(unsure.par_iter().zip(&lists).map(decide).collect())
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
