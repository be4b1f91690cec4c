//! Settle: what f32 could not prove is decided again, in double-double with proven bounds and then exactly.

use crate::certify::Certify;
use crate::certify::stage::Stage;
use crate::error::Result;
use crate::exact::{Judge, Truth};
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

/// A pixel that the kernel could not prove.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct Unsure {
    /// Row times width plus column.
    pub(crate) pixel: u32,
    /// The depth, in the frame's unit and as the kernel counts it, that the nearest hit surely does not exceed.
    pub(crate) limit: f32,
}

/// Decides every unsure pixel among the spheres that may be its nearest hit, by their lower bounds of depth; the order
/// of atomics leaves no trace. `go_on` is asked before every pixel; after a `false` the answers are worth nothing.
pub(crate) fn settle(
    scene: &Scene,
    view: &View,
    stage: &Stage,
    mut unsure: Vec<Unsure>,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Settled>> {
    unsure.par_sort_unstable_by_key(|u| u.pixel);
    let width = scene.image.width;
    let twin = Certify::<f32>::new(&view.record, stage);
    let candidates = |u: &Unsure| {
        let slopes = twin.slopes(u.pixel / width, u.pixel % width);
        let near = twin.candidates(&slopes).filter(|(low, _)| *low <= u.limit);
        let mut ids: Vec<u32> = near.map(|(_, slot)| twin.id(slot)).collect();
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
    let decide = |(u, own): (&Unsure, &Vec<u32>)| {
        if !go_on() {
            return Settled { pixel: u.pixel, truth: None };
        }
        let candidates: Vec<u32> = own.iter().map(local).collect();
        let truth = judge.among(u.pixel / width, u.pixel % width, &candidates);
        Settled { pixel: u.pixel, truth: truth.map(|truth| Truth { id: ids[truth.id as usize], ..truth }) }
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
