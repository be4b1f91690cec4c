//! Settle: what f32 could not prove is decided again, in double-double with proven bounds and then exactly.

use crate::error::Result;
use crate::exact::{Judge, Truth};
use crate::scene::{Scene, Spheres};
use rayon::prelude::*;

/// A pixel that was decided again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settled {
    /// Row times width plus column.
    pub(crate) pixel: u32,
    /// What its ray hits.
    pub(crate) truth: Option<Truth>,
}

/// What the kernel could not prove.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Open {
    /// The pixels, in any order.
    pub(crate) pixels: Vec<u32>,
    /// Pixel and id of every sphere that might be its nearest hit, in any order.
    pub(crate) pairs: Vec<[u32; 2]>,
}

/// Decides every open pixel among its candidates; the order of atomics leaves no trace.
pub(crate) fn settle(scene: &Scene, mut open: Open) -> Result<Vec<Settled>> {
    if open.pixels.is_empty() {
        return Ok(Vec::new());
    }
    open.pixels.par_sort_unstable();
    open.pairs.par_sort_unstable();
    // Only the spheres in question are prepared; in their order, so that the lower id stays the lower.
    let mut ids: Vec<u32> = open.pairs.par_iter().map(|pair| pair[1]).collect();
    ids.par_sort_unstable();
    ids.dedup();
    let mut spheres = Spheres::default();
    for &id in &ids {
        spheres.push(scene.spheres.centers[id as usize], scene.spheres.radii[id as usize], None);
    }
    let few = Scene { camera: scene.camera, image: scene.image, spheres, skipped: Default::default() };
    let judge = Judge::new(&few)?;
    let width = scene.image.width;
    let local = |id: &u32| ids.binary_search(id).map_or(u32::MAX, |k| k as u32);
    let decide = |&pixel: &u32| {
        let start = open.pairs.partition_point(|pair| pair[0] < pixel);
        let own = open.pairs[start..].iter().take_while(|pair| pair[0] == pixel);
        let candidates: Vec<u32> = own.map(|pair| local(&pair[1])).collect();
        let truth = judge.among(pixel / width, pixel % width, &candidates);
        Settled { pixel, truth: truth.map(|truth| Truth { id: ids[truth.id as usize], ..truth }) }
    };
    Ok(open.pixels.par_iter().map(decide).collect())
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
