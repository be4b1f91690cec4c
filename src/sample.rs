//! Samples of a frame's pixels, pass by pass, averaged to colour and coverage. Every sample is answered like a pixel: with a
//! certificate and settled where the frame is.

use crate::error::Result;
use crate::frame::raw::Raw;
use crate::kernel::Kernel;
use crate::plan::Plan;
use crate::prepare::Prepared;
use crate::raster::Raster;
use crate::ray::NONE;
use crate::render::Renderer;
use crate::report::Stages;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::shade;
use rayon::prelude::*;
use std::sync::Arc;

/// The means over all samples of each pixel.
#[derive(Debug, Default)]
pub(crate) struct Sampled {
    /// Linear RGB, three numbers a pixel; empty where nobody asked.
    pub(crate) color: Vec<f32>,
    /// Share of the samples that hit.
    pub(crate) alpha: Vec<f32>,
}

/// Sums of them. f64 holds the sum of equal colours exactly, so that flat areas keep their colour to the last bit.
struct Sums {
    color: Vec<f64>,
    hits: Vec<u32>,
}

impl Sums {
    fn add(&mut self, raw: &Raw) {
        self.color.par_iter_mut().zip(&raw.color).for_each(|(sum, x)| *sum += f64::from(*x));
        self.hits.par_iter_mut().zip(&raw.id).for_each(|(hits, id)| *hits += u32::from(*id != NONE));
    }
}

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
    ) -> Result<Sampled> {
        let pool = Arc::clone(&self.pool);
        let plan = Plan { kernel, ..plan.clone() };
        // The spheres are binned once for all passes: only the rays within a pixel differ.
        let mut prepared = Prepared::new(plan, scene, settings, raster, &pool, stages)?;
        let pixels = prepared.view.record.pixels();
        let mut raw = Raw::new(&prepared.plan.kernel, pixels, &pool)?;
        let mut sums = Sums { color: pool.values(raw.color.len())?, hits: pool.values(pixels)? };
        sums.color.fill(0.0);
        sums.hits.fill(0);
        for sample in 0..raster.count() {
            prepared.view.record.sample = sample;
            let settled = self.answer(&prepared, scene, &mut raw, stages)?;
            raw.settle(&settled);
            if let Some(shade) = kernel.shade {
                stages.time("shade", || shade::settled(shade, scene, &prepared.view, &settled, &mut raw.color));
            }
            stages.time("samples", || sums.add(&raw));
        }
        let count = f64::from(raster.count());
        let sampled = Sampled {
            color: sums.color.par_iter().map(|sum| (sum / count) as f32).collect(),
            alpha: sums.hits.par_iter().map(|hits| (f64::from(*hits) / count) as f32).collect(),
        };
        raw.give_to(&pool);
        pool.give(sums.color);
        pool.give(sums.hits);
        if let Some(stage) = prepared.stage {
            stage.give_to(&pool);
        }
        Ok(sampled)
    }
}
