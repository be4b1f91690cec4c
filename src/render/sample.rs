//! Renders several samples per pixel, one pass each, and averages them to colour and coverage. Samples are certified
//! and settled like pixels.

use super::lens::LensPasses;
use super::light::{FrameContext, LightRequest, LightSetup};
use super::plan::Plan;
use super::plan::lights::center_rays;
use super::renderer::Renderer;
use super::setup::FrameSetup;
use crate::answers::finish::fade;
use crate::answers::lit::{AROUND, OpenSky};
use crate::answers::raw::Raw;
use crate::answers::samples::{Means, Sums};
use crate::answers::settle;
use crate::cpu::light::LightOutputs;
use crate::error::Result;
use crate::frame::Aov;
use crate::frame::report::Timings;
use crate::kernel::Kernel;
use crate::scene::{Scene, Sky};
use crate::settings::Settings;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use crate::view::{Records, View};
use crate::window::Window;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::Arc;

impl Renderer {
    /// Renders all samples of `raster` with `kernel`, in their order. `centers` are the spheres that the pixels' centres
    /// show.
    pub(super) fn sample(
        &mut self,
        plan: &Plan,
        kernel: Kernel,
        (scene, settings, lights): (&Scene, &Settings, Option<&LightSetup>),
        (mut raster, centers): (Raster, &[u32]),
        timings: &mut Timings,
    ) -> Result<Means> {
        let window = raster.window;
        let mut lens = LensPasses::new(scene, settings, raster)?;
        let lens_is_open = lens.is_some();
        let pool = Arc::clone(&self.pool);
        let finish = plan.finish.filter(|_| settings.asks(&[Aov::Color]));
        let lights = lights.filter(|_| plan.wanted.color);
        let own = scene.lighting.sky;
        // What the pinhole does not see has no centre.
        let shared = own.filter(|sky| lights.is_some() && !lens_is_open && sky.at_centers);
        let margin = finish.map_or(0, |finish| finish.margin()).max(if shared.is_some() { AROUND } else { 0 });
        let around = match margin {
            0 => None,
            // Lines are blurred like what they surround: each pass draws its own, from samples around the window.
            margin if lens_is_open => {
                raster.window = window.grown(margin, scene.image.width, scene.image.height);
                None
            }
            margin => Some(self.centers(plan, (scene, settings), (window, margin), centers, timings)?),
        };
        let sky = match (&around, lights, shared) {
            (Some(around), Some(lights), Some(sky)) => {
                let ids = every_second(&around.view, &around.ids);
                let wanted = LightOutputs { sky: true, ..LightOutputs::default() };
                let of = FrameContext { scene, settings, view: &around.view };
                let sky = Some(Sky { rays: center_rays(sky, raster.count()), ..sky });
                let lit = timings.time("light", || {
                    self.light(
                        lights,
                        of,
                        &LightRequest { chessboard: true, ..LightRequest::of(wanted, sky, &ids) },
                        &pool,
                    )
                })?;
                Some((around.window, ids, lit.sky))
            }
            _ => None,
        };
        let open = sky.as_ref().map(|(window, ids, light)| OpenSky { window: *window, ids, light });
        let basis = scene.camera.basis()?;
        let cue = finish.and_then(|finish| finish.cue(scene, &basis));
        let pixels = raster.window.width() as usize * raster.window.height() as usize;
        let mut raw = Raw::new(&kernel, pixels, &pool)?;
        let wanted = LightOutputs { color: true, ..LightOutputs::default() };
        let mut sums = Sums::new(pixels, kernel.shade.is_some() || lights.is_some(), &pool)?;
        let mut last: Option<FrameSetup> = None;
        for sample in 0..raster.count() {
            let (scene, raster) = match &mut lens {
                Some(lens) => lens.pass(sample, raster.window)?,
                None => (scene, raster),
            };
            // The spheres are binned once for all passes of one eye, as only the positions within the pixels differ.
            if lens_is_open && let Some(setup) = last.take() {
                setup.put_back(&pool);
            }
            let setup = match &mut last {
                Some(setup) => setup,
                none => {
                    let plan = Plan { kernel, ..plan.clone() };
                    none.insert(self.setup(plan, scene, settings, raster, timings)?)
                }
            };
            setup.view.record.sample = sample;
            let settled = self.answer(setup, scene, settings, &mut raw, timings)?;
            raw.settle(&settled);
            if let Some(shade) = kernel.shade {
                timings.time("shade", || settle::shade(shade, scene, &setup.view, &settled, &mut raw.color));
            }
            if let Some(lights) = lights {
                let of = FrameContext { scene, settings, view: &setup.view };
                let lit = timings.time("light", || {
                    self.light(
                        lights,
                        of,
                        &LightRequest { open_sky: open, ..LightRequest::of(wanted, own, &raw.id) },
                        &pool,
                    )
                })?;
                pool.put_back(std::mem::replace(&mut raw.color, lit.color));
            }
            if let Some(cue) = cue {
                timings.time("finish", || fade(cue, scene, (&setup.view, lights.is_some()), &raw.id, &mut raw.color));
            }
            if let Some(finish) = finish.filter(|_| lens_is_open) {
                let part = raster.window.inside(raster.window);
                timings.time("finish", || finish.draw(scene, &setup.view, &raw.id, part, &mut raw.color));
            }
            timings.time("samples", || sums.add(&raw));
        }
        let mut means = sums.means(raster.count(), &pool);
        if raster.window != window {
            means = means.part(window.inside(raster.window), raster.window.width());
        }
        if let (Some(finish), Some(around)) = (finish, around) {
            let part = window.inside(around.window);
            timings.time("finish", || finish.draw(scene, &around.view, &around.ids, part, &mut means.color));
        }
        raw.put_back(&pool);
        if let Some(setup) = last {
            setup.put_back(&pool);
        }
        Ok(means)
    }

    /// What the pixels' centres of a window show, and those around it as far as `margin` and the frame reach.
    fn centers<'a>(
        &mut self,
        plan: &Plan,
        (scene, settings): (&Scene, &Settings),
        (window, margin): (Window, u32),
        centers: &'a [u32],
        timings: &mut Timings,
    ) -> Result<Centers<'a>> {
        let pool = Arc::clone(&self.pool);
        let wide = window.grown(margin, scene.image.width, scene.image.height);
        let raster = Raster::centres(wide);
        if wide == window {
            let view = View::for_rays(scene, raster, Records::None)?;
            return Ok(Centers { window, view, ids: centers.into() });
        }
        let kernel = plan.kernel.ids_only();
        let mut setup = self.setup(Plan { kernel, ..plan.clone() }, scene, settings, raster, timings)?;
        let mut raw = Raw::new(&setup.plan.kernel, setup.view.record.pixels(), &pool)?;
        let settled = self.answer(&mut setup, scene, settings, &mut raw, timings)?;
        raw.settle(&settled);
        let ids = std::mem::take(&mut raw.id).into();
        raw.put_back(&pool);
        let view = setup.put_back(&pool);
        Ok(Centers { window: wide, view, ids })
    }
}

/// The spheres of every second pixel, as on a chessboard: enough for a sky that is averaged over the pixels around.
fn every_second(view: &View, ids: &[u32]) -> Vec<u32> {
    let one = |(pixel, id): (usize, &u32)| {
        let [row, column] = view.record.place(pixel as u32);
        if (row ^ column) & 1 == 0 { *id } else { NONE }
    };
    ids.par_iter().enumerate().map(one).collect()
}

/// What pixels' centres show.
struct Centers<'a> {
    window: Window,
    view: View,
    ids: Cow<'a, [u32]>,
}
