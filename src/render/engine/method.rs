//! A method: every ray tests every sphere by one form of the quadratic, without a proof, on a device or by its twin.

use super::{Engine, Found, ViewRays};
use crate::answers::raw::Raw;
use crate::cpu;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::render::rendering::Rendering;
use halfline_ground::error::Result;
use halfline_ground::progress::Step;

/// The spheres of the view, all for each ray.
pub(in crate::render) struct EverySphere;

impl Engine for EverySphere {
    fn first_hits(&mut self, at: &mut Rendering<'_>, rays: ViewRays<'_>, raw: &mut Raw) -> Result<Found> {
        let ViewRays { scene, view, kernel } = rays;
        let Rendering { renderer, log, .. } = at;
        let colors = scene.spheres.colors.as_deref();
        let doing = renderer.watch.begin(Step::Trace, raw.id.len() as u64);
        match &mut renderer.device.gpu {
            Some(gpu) => {
                let input = Input { view, colors, rays: KernelRays::Viewing };
                let mut output = Output { raw, timings: &mut log.timings };
                gpu.run(kernel, &input, &mut output, &|done| doing.reached(done))?;
            }
            None => {
                let row = || doing.next(u64::from(view.record.columns));
                log.time("trace", || cpu::render(kernel, view, None, colors, raw, &row));
            }
        }
        doing.end()?;
        Ok(Found::Hits(Vec::new()))
    }
}
