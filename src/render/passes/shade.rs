//! The shading of settled pixels. A kernel shades the hits that it proves, where the picture has no passes of its own.

use crate::answers::hits::FirstHits;
use crate::answers::settle;
use crate::render::rendering::{Pass, Rendering};
use crate::render::setup::FrameSetup;

pub(in crate::render) const PASS: Pass = Pass {
    name: "shade",
    output: "the colours of hits, by the kernel that finds them",
    runs: |plan, _, _| plan.kernel.shade.is_some(),
};

/// Colours the pixels that the judge decided.
pub(in crate::render) fn run(at: &mut Rendering<'_>, setup: &FrameSetup, hits: &mut FirstHits) {
    let (scene, FirstHits { raw, settled }) = (at.scene, hits);
    if let Some(shade) = setup.plan.kernel.shade {
        at.log.time("shade", || settle::shade(shade, scene, &setup.view, settled, &mut raw.color));
    }
}
