//! Renders several samples per pixel, one pass each, and averages them to colour and coverage. Samples are certified
//! and settled like pixels.

use super::light::LightSetup;
use super::plan::Plan;
use super::renderer::Renderer;
use super::setup::FrameSetup;
use crate::answers::finish::cut;
use crate::answers::raw::Raw;
use crate::answers::samples::{Means, Sums};
use crate::answers::settle;
use crate::cpu::light::Wanted;
use crate::error::Result;
use crate::frame::Aov;
use crate::frame::report::Timings;
use crate::kernel::Kernel;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::view::raster::Raster;
use crate::window::Window;
use std::sync::Arc;

impl Renderer {
    /// Renders all samples of `raster` with `kernel`, in their order.
    pub(super) fn sample(
        &mut self,
        plan: &Plan,
        kernel: Kernel,
        (scene, settings, lights): (&Scene, &Settings, Option<&LightSetup>),
        raster: Raster,
        timings: &mut Timings,
    ) -> Result<Means> {
        let pool = Arc::clone(&self.pool);
        let plan = Plan { kernel, ..plan.clone() };
        // The spheres are binned once for all passes, since only the positions within the pixels differ.
        let window = raster.window;
        let whole = Window { x0: 0, y0: 0, x1: window.width(), y1: window.height() };
        let finish = plan.finish.filter(|_| settings.asks(&[Aov::Color]));
        let [wide, part] =
            finish.map_or([window, whole], |finish| finish.windows(window, scene.image.width, scene.image.height));
        let raster = Raster { window: wide, ..raster };
        let mut setup = FrameSetup::new(plan, scene, settings, raster, &pool, timings)?;
        let pixels = setup.view.record.pixels();
        let columns = wide.width() as usize;
        let mut raw = Raw::new(&setup.plan.kernel, pixels, &pool)?;
        let lights = lights.filter(|_| setup.plan.wanted.color);
        let wanted = Wanted { color: true, ..Wanted::default() };
        let mut sums =
            Sums::new(whole.x1 as usize * whole.y1 as usize, kernel.shade.is_some() || lights.is_some(), &pool)?;
        for sample in 0..raster.count() {
            setup.view.record.sample = sample;
            let settled = self.answer(&setup, scene, &mut raw, timings)?;
            raw.settle(&settled);
            if let Some(shade) = kernel.shade {
                timings.time("shade", || settle::shade(shade, scene, &setup.view, &settled, &mut raw.color));
            }
            if let Some(lights) = &lights {
                let lit = timings
                    .time("light", || self.light(lights, (scene, settings, &setup.view), wanted, &raw.id, &pool))?;
                pool.put_back(std::mem::replace(&mut raw.color, lit.color));
            }
            let Some(finish) = finish else {
                timings.time("samples", || sums.add(&raw.color, &raw.id));
                continue;
            };
            timings.time("finish", || {
                let mut color = cut(&raw.color, columns, part, 3);
                finish.draw(scene, &setup.view, &raw.id, part, &mut color);
                sums.add(&color, &cut(&raw.id, columns, part, 1));
            });
        }
        let means = sums.means(raster.count(), &pool);
        raw.put_back(&pool);
        if let Some(binned) = setup.binned {
            binned.put_back(&pool);
        }
        Ok(means)
    }
}
