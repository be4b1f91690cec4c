//! The buffers of the frame: what was requested, in its units.

use crate::answers::assemble::Answers;
use crate::answers::hits::FirstHits;
use crate::answers::light::LightBuffers;
use crate::answers::samples::Means;
use crate::frame::Buffer;
use crate::render::rendering::{Pass, Rendering};
use crate::render::setup::FrameSetup;
use crate::settings::Accuracy;
use halfline_ground::error::Result;

pub(in crate::render) const PASS: Pass =
    Pass { name: "buffers", output: "the requested buffers, in the scene's units", runs: |_, _, _| true };

/// The buffers, of hits, of the means over samples, and of lights and sky.
///
/// # Errors
/// [`crate::Error::Limits`] where memory is short.
pub(in crate::render) fn run(
    at: &mut Rendering<'_>,
    setup: &FrameSetup,
    FirstHits { raw, settled }: FirstHits,
    sampled: Option<Means>,
    light: LightBuffers,
) -> Result<Vec<Buffer>> {
    let (promised, pool, aovs) = (setup.plan.accuracy != Accuracy::Fast, &at.pool, &at.settings.aovs);
    let answers = Answers { pool, view: &setup.view, raw, promised, settled: &settled, sampled, light };
    at.log.time("assemble", || answers.assemble(aovs))
}
