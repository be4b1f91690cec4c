//! The passes of a frame, in the order in which they run.

pub(super) mod buffers;
pub(super) mod finish;
pub(super) mod hits;
pub(super) mod layers;
pub(super) mod light;
pub(super) mod on_device;
pub(super) mod samples;
mod sampling;
pub(super) mod shade;
pub(super) mod sky;

use super::plan::Plan;
use super::rendering::Pass;
use crate::scene::Scene;
use crate::settings::Settings;

/// All passes. Layers, lines and depth cue are of each sample of the pixels, and so is a sky that is not of their centres.
pub(super) const PASSES: [Pass; 8] =
    [hits::PASS, light::PASS, sky::PASS, samples::PASS, layers::PASS, finish::PASS, shade::PASS, buffers::PASS];

/// The passes of a planned frame.
pub(super) fn of(plan: &Plan, scene: &Scene, settings: &Settings) -> impl Iterator<Item = &'static Pass> {
    PASSES.iter().filter(move |pass| (pass.runs)(plan, scene, settings))
}
