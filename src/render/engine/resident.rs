//! Spheres that a device holds: it finds and certifies the hits, and the host settles what f32 does not prove.

use super::{Engine, Found, ViewRays, settle};
use crate::answers::raw::Raw;
use crate::certify::placing::Placer;
use crate::gpu::input::Output;
use crate::gpu::resident::{Rendered, ResidentFrame};
use crate::render::renderer::NOTHING;
use crate::render::rendering::Rendering;
use halfline_ground::error::Result;
use halfline_ground::progress::Step;

/// The host's part in placing the spheres.
pub(in crate::render) struct Resident {
    pub(in crate::render) placer: Placer,
}

impl Engine for Resident {
    fn first_hits(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, raw: &mut Raw) -> Result<Found> {
        let ViewRays { scene, view, kernel } = rays;
        let Rendering { renderer, log, pool, .. } = &mut *at;
        let Some(gpu) = &mut renderer.device.gpu else { return Ok(Found::Left("there is no device".into())) };
        if gpu.hold(scene, renderer.frames)?.is_none() {
            return Ok(Found::Left(NOTHING.into()));
        }
        let doing = renderer.watch.begin(Step::Trace, raw.id.len() as u64);
        let frame = ResidentFrame { scene, view, placer: &self.placer, pool };
        let mut output = Output { raw, timings: &mut log.timings };
        let rendered = gpu.render_resident(kernel, frame, &mut output, &|done| doing.reached(done))?;
        doing.end()?;
        match rendered {
            Rendered::Frame(binned) => settle(at, rays, &binned, raw).map(Found::Hits),
            Rendered::Left(reason) => Ok(Found::Left(reason)),
        }
    }

    fn placer(&self) -> Option<&Placer> {
        Some(&self.placer)
    }
}
