//! Samples of a frame's pixels, pass by pass, averaged to colour and coverage. Every sample is answered like a pixel: with a
//! certificate and settled where the frame is.

use super::Renderer;
use crate::error::Result;
use crate::kernel::Kernel;
use crate::plan::Plan;
use crate::prepare::Prepared;
use crate::raster::Raster;
use crate::raw::Raw;
use crate::report::Stages;
use crate::samples::{Means, Sums};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::settle;
use std::sync::Arc;

impl Renderer {
    /// All samples of `raster`, by `kernel`, in their order.
    pub(crate) fn sample(
        &mut self,
        plan: &Plan,
        kernel: Kernel,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        stages: &mut Stages,
    ) -> Result<Means> {
        let pool = Arc::clone(&self.pool);
        let plan = Plan { kernel, ..plan.clone() };
        // The spheres are binned once for all passes: only the rays within a pixel differ.
        let mut prepared = Prepared::new(plan, scene, settings, raster, &pool, stages)?;
        let pixels = prepared.view.record.pixels();
        let mut raw = Raw::new(&prepared.plan.kernel, pixels, &pool)?;
        let mut sums = Sums::new(pixels, kernel.shade.is_some(), &pool)?;
        for sample in 0..raster.count() {
            prepared.view.record.sample = sample;
            let settled = self.answer(&prepared, scene, &mut raw, stages)?;
            raw.settle(&settled);
            if let Some(shade) = kernel.shade {
                stages.time("shade", || settle::shade(shade, scene, &prepared.view, &settled, &mut raw.color));
            }
            stages.time("samples", || sums.add(&raw));
        }
        let means = sums.means(raster.count(), &pool);
        raw.give_to(&pool);
        if let Some(stage) = prepared.stage {
            stage.give_to(&pool);
        }
        Ok(means)
    }
}
