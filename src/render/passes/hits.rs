//! The hits: what the ray through the centre of each pixel hits first.

use crate::answers::hits::FirstHits;
use crate::render::plan::Plan;
use crate::render::rendering::{Pass, Rendering};
use crate::render::setup::{self, FrameSetup};
use crate::view::raster::Raster;
use halfline_ground::error::Result;
use halfline_ground::progress::Step;

pub(in crate::render) const PASS: Pass =
    Pass { name: "hits", output: "what the ray of each pixel's centre hits first", runs: |_, _, _| true };

/// The setup of a frame for the centres of its pixels, and their hits.
///
/// # Errors
/// Errors of the setup and of the engine.
pub(in crate::render) fn run(at: &mut Rendering<'_>, plan: Plan) -> Result<(FrameSetup, FirstHits)> {
    let (scene, raster) = (at.scene, Raster::centres(at.rays.window));
    let staging = at.renderer.watch.clone();
    let staging = staging.begin(Step::Stage, scene.spheres.len() as u64);
    let mut setup = setup::make(at, plan, scene, raster)?;
    staging.end()?;
    let mut hits = FirstHits::new(&setup.plan.kernel, setup.view.record.pixels(), &at.pool)?;
    setup.find(at, scene, &mut hits)?;
    at.renderer.watch.check()?;
    Ok((setup, hits))
}
