//! The lines of silhouettes and the depth cue, drawn over the colours of a sample.

use super::sampling::Sampling;
use crate::answers::depth_cue::DepthCue;
use crate::frame::Aov;
use crate::render::rendering::{Pass, Rendering};
use crate::view::View;

pub(in crate::render) const PASS: Pass = Pass {
    name: "lines and depth cue",
    output: "the background in the colours of what is far, and dark lines where the depth jumps",
    runs: |plan, _, settings| plan.finish.is_some() && settings.asks(&[Aov::Color]),
};

/// Draws them over the colours of what a view shows: the spheres `ids`, at these depths where they are known.
pub(super) fn run(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    view: &View,
    (ids, depths): (&[u32], Option<&[f64]>),
    cue: Option<DepthCue>,
    color: &mut [f32],
) {
    if let Some(finish) = sampling.finish() {
        let of = (view, sampling.trees.is_some());
        at.log.time("finish", || finish.draw(cue, sampling.scene, of, (ids, depths), color));
    }
}
