//! Renders several samples per pixel, one pass each, and averages them to colour and coverage. Samples are certified
//! and settled like pixels.

use super::lens::LensPasses;
use super::light::{FrameContext, LightRequest, LightSetup};
use super::plan::Plan;
use super::plan::lights::center_rays;
use super::renderer::Renderer;
use super::setup::FrameSetup;
use crate::answers::depth_cue::DepthCue;
use crate::answers::finish::Finish;
use crate::answers::light::{AROUND, OpenSky};
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

/// The inputs that all samples of a frame share.
#[derive(Clone, Copy)]
pub(super) struct Sampling<'a> {
    pub(super) plan: &'a Plan,
    /// Writes ids and colours.
    pub(super) kernel: Kernel,
    pub(super) scene: &'a Scene,
    pub(super) settings: &'a Settings,
    /// `None` where the kernel shades.
    pub(super) lights: Option<&'a LightSetup>,
}

impl Sampling<'_> {
    /// The effects that are drawn over the colours; `None` where colour is not requested.
    fn finish(&self) -> Option<Finish> {
        self.plan.finish.filter(|_| self.settings.asks(&[Aov::Color]))
    }

    /// The sky whose light is found at the centres of pixels, for all samples. With an open lens a sample may hit spheres that no
    /// centre sees.
    fn sky_at_centers(&self) -> Option<Sky> {
        let is_pinhole = self.settings.aperture.is_none();
        self.scene.lighting.sky.filter(|sky| self.lights.is_some() && is_pinhole && sky.at_centers)
    }

    /// The kernel's plan.
    fn plan(&self) -> Plan {
        Plan { kernel: self.kernel, ..self.plan.clone() }
    }
}

impl Renderer {
    /// Renders all samples of `raster`, in their order. `centers` are the spheres that the pixels' centres show.
    pub(super) fn sample(
        &mut self,
        sampling: Sampling<'_>,
        mut raster: Raster,
        centers: &[u32],
        timings: &mut Timings,
    ) -> Result<Means> {
        let Sampling { kernel, scene, settings, lights, .. } = sampling;
        let window = raster.window;
        let mut lens = LensPasses::new(scene, settings, raster)?;
        let pool = Arc::clone(&self.pool);
        let finish = sampling.finish();
        // Each pass draws its own lines, from samples around the window, so that their mean is smooth and a lens blurs them.
        raster.window = window.grown(finish.map_or(0, Finish::margin), scene.image.width, scene.image.height);
        let open = match sampling.sky_at_centers() {
            Some(sky) => {
                let around = self.centers(sampling, window, centers, timings)?;
                self.sky_of(sampling, &around, sky, raster.count(), timings)?
            }
            None => None,
        };
        let open = open.as_ref();
        let basis = scene.camera.basis()?;
        let cue = finish.and_then(|finish| finish.cue(scene, &basis));
        let pixels = raster.window.width() as usize * raster.window.height() as usize;
        let mut raw = Raw::new(&kernel, pixels, &pool)?;
        let mut sums = Sums::new(pixels, kernel.shade.is_some() || lights.is_some(), &pool)?;
        let mut last: Option<FrameSetup> = None;
        for sample in 0..raster.count() {
            let (scene, raster) = match &mut lens {
                Some(lens) => {
                    // Each pass has another eye.
                    if let Some(setup) = last.take() {
                        setup.put_back(&pool);
                    }
                    lens.pass(sample, raster.window)?
                }
                None => (scene, raster),
            };
            // The spheres are binned once for all passes of one eye, as only the positions within the pixels differ.
            let setup = match &mut last {
                Some(setup) => setup,
                none => none.insert(self.setup(sampling.plan(), scene, settings, raster, timings)?),
            };
            setup.view.record.sample = sample;
            self.pass(Sampling { scene, ..sampling }, setup, open, cue, &mut raw, timings)?;
            timings.time("samples", || sums.add(&raw));
        }
        let mut means = sums.means(raster.count(), &pool);
        if raster.window != window {
            means = means.part(window.inside(raster.window), raster.window.width());
        }
        raw.put_back(&pool);
        if let Some(setup) = last {
            setup.put_back(&pool);
        }
        Ok(means)
    }

    /// One sample of every pixel, with its colour. The scene is that of the pass's eye.
    fn pass(
        &mut self,
        sampling: Sampling<'_>,
        setup: &mut FrameSetup,
        open_sky: Option<&OpenSky>,
        cue: Option<DepthCue>,
        raw: &mut Raw,
        timings: &mut Timings,
    ) -> Result<()> {
        let Sampling { kernel, scene, settings, lights, .. } = sampling;
        let pool = Arc::clone(&self.pool);
        let settled = self.answer(setup, scene, settings, raw, timings)?;
        raw.settle(&settled);
        let view = &setup.view;
        if let Some(shade) = kernel.shade {
            timings.time("shade", || settle::shade(shade, scene, view, &settled, &mut raw.color));
        }
        if let Some(lights) = lights {
            let outputs = LightOutputs { color: true, ..LightOutputs::default() };
            let request = LightRequest { open_sky, ..LightRequest::of(outputs, scene.lighting.sky, &raw.id) };
            let frame = FrameContext { scene, settings, view };
            let light = timings.time("light", || self.light(lights, frame, &request, &pool))?;
            pool.put_back(std::mem::replace(&mut raw.color, light.color));
        }
        if let Some(finish) = sampling.finish() {
            let of = (view, lights.is_some());
            timings.time("finish", || finish.draw(cue, scene, of, &raw.id, &mut raw.color));
        }
        Ok(())
    }

    /// The light of the sky at every second pixel's centre, as on a chessboard.
    fn sky_of(
        &mut self,
        sampling: Sampling<'_>,
        around: &Centers<'_>,
        sky: Sky,
        samples: u32,
        timings: &mut Timings,
    ) -> Result<Option<OpenSky>> {
        let Sampling { scene, settings, lights: Some(lights), .. } = sampling else { return Ok(None) };
        let pool = Arc::clone(&self.pool);
        let ids = every_second(&around.view, &around.ids);
        let outputs = LightOutputs { sky: true, ..LightOutputs::default() };
        let sky = Sky { rays: center_rays(sky, samples), ..sky };
        let request = LightRequest { chessboard: true, ..LightRequest::of(outputs, Some(sky), &ids) };
        let frame = FrameContext { scene, settings, view: &around.view };
        let light = timings.time("light", || self.light(lights, frame, &request, &pool))?;
        Ok(Some(OpenSky { window: around.window, ids, light: light.sky }))
    }

    /// The spheres that the centres of a window's pixels show, and those around it as far as [`AROUND`] and the frame reach.
    fn centers<'a>(
        &mut self,
        sampling: Sampling<'_>,
        window: Window,
        centers: &'a [u32],
        timings: &mut Timings,
    ) -> Result<Centers<'a>> {
        let Sampling { plan, scene, settings, .. } = sampling;
        let pool = Arc::clone(&self.pool);
        let wide = window.grown(AROUND, scene.image.width, scene.image.height);
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

/// The spheres that pixels' centres show.
struct Centers<'a> {
    window: Window,
    view: View,
    ids: Cow<'a, [u32]>,
}
