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
use crate::answers::open_sky::{OpenSky, Smoothing};
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
use crate::view::{Records, View};
use crate::window::Window;
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

    /// The sky that lights the picture, with the rays of a pixel's centre or of a sample, and the smoothing for pixels of so many
    /// samples.
    fn sky(&self, samples: u32) -> Option<PictureSky<'_>> {
        let (lights, sky) = (self.lights?, self.scene.lighting.sky?);
        // With an open lens a sample may hit spheres that no centre sees.
        let at_centers = sky.at_centers && self.settings.aperture.is_none();
        let rays = if at_centers { center_rays(sky, samples) } else { sky.rays };
        let of_pixel = if at_centers { rays } else { rays.saturating_mul(samples) };
        Some(PictureSky { lights, sky: Sky { rays, ..sky }, at_centers, smoothing: Smoothing::of(of_pixel) })
    }

    /// The kernel's plan.
    fn plan(&self) -> Plan {
        Plan { kernel: self.kernel, ..self.plan.clone() }
    }
}

/// The sky of a picture.
#[derive(Clone, Copy)]
struct PictureSky<'a> {
    lights: &'a LightSetup,
    sky: Sky,
    /// Rays leave from the centres of pixels, for all samples.
    at_centers: bool,
    smoothing: Smoothing,
}

impl PictureSky<'_> {
    /// Pixels on each side of a window from which each pass of samples traces rays toward the sky.
    fn margin(&self) -> u32 {
        if self.at_centers { 0 } else { self.smoothing.margin() }
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
        let sky = sampling.sky(raster.count());
        // Each pass draws its own lines, and has its own rays toward the sky, with samples around the window, so that their mean is
        // smooth and a lens blurs them.
        let margin = finish.map_or(0, Finish::margin).max(sky.map_or(0, |sky| sky.margin()));
        raster.window = window.grown(margin, scene.image.width, scene.image.height);
        let at_centers = match sky.filter(|sky| sky.at_centers) {
            Some(sky) => {
                let Centers { view, ids } = self.centers(sampling, window, sky.smoothing, centers, timings)?;
                Some(self.open_sky(sampling, &view, &ids, sky, timings)?)
            }
            None => None,
        };
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
            let sampling = Sampling { scene, ..sampling };
            self.pass(sampling, setup, at_centers.as_ref(), cue, &mut raw, timings)?;
            timings.time("samples", || sums.add(&raw));
        }
        let mut means = sums.means(raster.count(), &pool);
        if raster.window != window {
            means = means.part(window.inside(raster.window), raster.window.width());
        }
        raw.put_back(&pool);
        if let Some(open) = at_centers {
            open.put_back(&pool);
        }
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
        at_centers: Option<&OpenSky>,
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
            let sky = sampling.sky(view.record.strata * view.record.strata);
            let own = match sky.filter(|sky| !sky.at_centers && !sky.smoothing.is_none()) {
                Some(sky) => Some(self.open_sky(sampling, view, &raw.id, sky, timings)?),
                None => None,
            };
            let outputs = LightOutputs { color: true, ..LightOutputs::default() };
            let of = LightRequest::of(outputs, scene.lighting.sky, &raw.id);
            let request = LightRequest { open_sky: at_centers.or(own.as_ref()), ..of };
            let frame = FrameContext { scene, settings, view };
            let light = timings.time("light", || self.light(lights, frame, &request, &pool))?;
            pool.put_back(std::mem::replace(&mut raw.color, light.color));
            if let Some(own) = own {
                own.put_back(&pool);
            }
        }
        if let Some(finish) = sampling.finish() {
            let of = (view, lights.is_some());
            timings.time("finish", || finish.draw(cue, scene, of, &raw.id, &mut raw.color));
        }
        Ok(())
    }

    /// The rays toward the sky from the hits of a view, which shows the spheres `ids`, with those of neighbours.
    fn open_sky(
        &mut self,
        sampling: Sampling<'_>,
        view: &View,
        ids: &[u32],
        PictureSky { lights, sky, smoothing, .. }: PictureSky<'_>,
        timings: &mut Timings,
    ) -> Result<OpenSky> {
        let Sampling { scene, settings, .. } = sampling;
        let pool = Arc::clone(&self.pool);
        let outputs = LightOutputs { sky: true, ..LightOutputs::default() };
        let frame = FrameContext { scene, settings, view };
        let request = LightRequest { interleaved: !smoothing.is_none(), ..LightRequest::of(outputs, Some(sky), ids) };
        let hits = timings.time("light", || self.light(lights, frame, &request, &pool))?.sky;
        let mut own = pool.values(ids.len())?;
        own.copy_from_slice(ids);
        timings.time("smooth", || OpenSky::new(view.record.window(), own, hits, smoothing, &pool))
    }

    /// The spheres that the centres of a window's pixels show, and those around it as far as smoothing, the neighbours of a sample, and
    /// the frame reach.
    fn centers<'a>(
        &mut self,
        sampling: Sampling<'_>,
        window: Window,
        smoothing: Smoothing,
        centers: &'a [u32],
        timings: &mut Timings,
    ) -> Result<Centers<'a>> {
        let Sampling { plan, scene, settings, .. } = sampling;
        let pool = Arc::clone(&self.pool);
        let wide = window.grown(smoothing.margin() + 1, scene.image.width, scene.image.height);
        let raster = Raster::centres(wide);
        if wide == window {
            let view = View::for_rays(scene, raster, Records::None)?;
            return Ok(Centers { view, ids: centers.into() });
        }
        let kernel = plan.kernel.ids_only();
        let mut setup = self.setup(Plan { kernel, ..plan.clone() }, scene, settings, raster, timings)?;
        let mut raw = Raw::new(&setup.plan.kernel, setup.view.record.pixels(), &pool)?;
        let settled = self.answer(&mut setup, scene, settings, &mut raw, timings)?;
        raw.settle(&settled);
        let ids = std::mem::take(&mut raw.id).into();
        raw.put_back(&pool);
        let view = setup.put_back(&pool);
        Ok(Centers { view, ids })
    }
}

/// The spheres that pixels' centres show.
struct Centers<'a> {
    view: View,
    ids: Cow<'a, [u32]>,
}
