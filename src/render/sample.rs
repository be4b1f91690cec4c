//! Renders several samples per pixel, one pass each, and averages them to colour and coverage. Samples are certified
//! and settled like pixels.

use super::lens::LensPasses;
use super::light::{FrameContext, LightRequest, LightSetup};
use super::opaque::Opaque;
use super::plan::Plan;
use super::renderer::Renderer;
use super::see_through::{WholeFrame, lay_over};
use super::setup::FrameSetup;
use crate::answers::depth_cue::DepthCue;
use crate::answers::finish::Finish;
use crate::answers::layers;
use crate::answers::open_sky::{OpenSky, Smoothing};
use crate::answers::raw::Raw;
use crate::answers::samples::{Means, Sums};
use crate::answers::settle;
use crate::cpu::light::LightOutputs;
use crate::error::Result;
use crate::frame::Aov;
use crate::frame::coverage::Coverage;
use crate::frame::report::Timings;
use crate::kernel::Kernel;
use crate::memory::Pool;
use crate::scene::{Scene, Sky};
use crate::settings::Settings;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
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
    /// The opaque spheres, where some are translucent. The samples are then those of the opaque ones, with layers over them.
    pub(super) opaque: Option<&'a Opaque>,
}

impl Sampling<'_> {
    /// The effects that are drawn over the colours; `None` where colour is not requested.
    pub(super) fn finish(&self) -> Option<Finish> {
        self.plan.finish.filter(|_| self.settings.asks(&[Aov::Color]))
    }

    /// The sky that lights the picture, with the rays of a pixel's centre or of a sample, and the smoothing for pixels of so many
    /// samples.
    fn sky(&self, samples: u32) -> Option<PictureSky<'_>> {
        let (lights, sky) = (self.lights?, self.scene.lighting.sky?);
        // With an open lens a sample may hit spheres that no centre sees.
        let at_centers = sky.at_centers && self.settings.aperture.is_none();
        let rays = if at_centers { sky.rays_at_center(samples) } else { sky.rays };
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
pub(super) struct PictureSky<'a> {
    pub(super) lights: &'a LightSetup,
    pub(super) sky: Sky,
    /// Rays leave from the centres of pixels, for all samples.
    pub(super) at_centers: bool,
    pub(super) smoothing: Smoothing,
}

impl PictureSky<'_> {
    /// A request for the rays toward the sky from the hits of pixels that show these spheres.
    pub(super) fn request<'a>(&self, ids: &'a [u32]) -> LightRequest<'a> {
        let outputs = LightOutputs { sky: true, ..LightOutputs::default() };
        LightRequest { interleaved: !self.smoothing.is_none(), ..LightRequest::of(outputs, Some(self.sky), ids) }
    }

    /// The window of the pixels from whose centres rays leave, for the samples of a window: with those around it as far as smoothing,
    /// and the neighbours of a sample, reach.
    pub(super) fn window(&self, window: Window, scene: &Scene) -> Window {
        window.grown(self.smoothing.margin() + 1, scene.image.width, scene.image.height)
    }

    /// Pixels on each side of a window from which each pass of samples traces rays toward the sky.
    fn margin(&self) -> u32 {
        if self.at_centers { 0 } else { self.smoothing.margin() }
    }
}

impl Renderer {
    /// Renders all samples of `raster`, in their order, on the device where it draws pictures, and counts them in `coverage`. `centers` are the spheres that the pixels' centres show.
    pub(super) fn sample(
        &mut self,
        sampling: Sampling<'_>,
        mut raster: Raster,
        centers: &[u32],
        mut coverage: Option<&mut Coverage>,
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
        // The spheres of samples that a device draws stay there.
        if let Some(sky) = sky.filter(|sky| sky.at_centers && coverage.is_none())
            && let Some(means) = self.draw_on_device(sampling, sky, (window, raster), centers, timings)?
        {
            return Ok(means);
        }
        let at_centers = match sky.filter(|sky| sky.at_centers) {
            Some(sky) => self.sky_at_centers(sampling, window, sky, centers, timings)?,
            None => Vec::new(),
        };
        let basis = scene.camera.basis()?;
        let cue = finish.and_then(|finish| finish.cue(scene, &basis));
        let pixels = raster.window.width() as usize * raster.window.height() as usize;
        let mut raw = Raw::new(&kernel, pixels, &pool)?;
        let mut passing = pool.values(if sampling.opaque.is_some() { pixels } else { 0 })?;
        let mut sums = Sums::new(pixels, kernel.shade.is_some() || lights.is_some(), &pool)?;
        let mut last: Option<Setups> = None;
        for sample in 0..raster.count() {
            let (scene, raster) = match &mut lens {
                Some(lens) => {
                    // Each pass has another eye.
                    if let Some(setups) = last.take() {
                        setups.put_back(&pool);
                    }
                    lens.pass(sample, raster.window)?
                }
                None => (scene, raster),
            };
            let sampling = Sampling { scene, ..sampling };
            // The spheres are binned once for all passes of one eye, as only the positions within the pixels differ.
            let setups = match &mut last {
                Some(setups) => setups,
                none => none.insert(self.setups(&sampling, sampling.plan(), raster, timings)?),
            };
            setups.set_sample(sample);
            self.pass(sampling, setups, (&at_centers, cue), (&mut raw, &mut passing), timings)?;
            timings.time("samples", || sums.add(&raw, &passing));
            if let Some(coverage) = &mut coverage {
                timings.time("coverage", || coverage.add(&raw.id, window.inside(raster.window), raster.window.width()));
            }
        }
        let mut means = sums.means(raster.count(), &pool);
        if raster.window != window {
            means = means.part(window.inside(raster.window), raster.window.width());
        }
        raw.put_back(&pool);
        pool.put_back(passing);
        at_centers.into_iter().for_each(|open| open.put_back(&pool));
        if let Some(setups) = last {
            setups.put_back(&pool);
        }
        Ok(means)
    }

    /// The setups for the rays of a raster.
    fn setups(&mut self, sampling: &Sampling<'_>, plan: Plan, raster: Raster, timings: &mut Timings) -> Result<Setups> {
        let Sampling { scene, settings, opaque, .. } = *sampling;
        let Some(opaque) = opaque else {
            let first = self.setup(plan, scene, settings, raster, timings)?;
            return Ok(Setups { first, opaque: None, whole: None });
        };
        let alone = opaque.scene(scene);
        let whole = self.whole_frame(&plan, scene, settings, raster, timings)?;
        let refused = self.refused.clone();
        let first = self.setup(plan, &alone, settings, raster, timings)?;
        if alone.spheres.is_empty() {
            // No sphere is opaque, and the device renders those that there are.
            self.refused = refused;
        }
        Ok(Setups { first, opaque: Some(alone), whole: Some(whole) })
    }

    /// One sample of every pixel, with its colour, and the share of it that layers let pass. The scene is that of the pass's eye.
    fn pass(
        &mut self,
        sampling: Sampling<'_>,
        setups: &mut Setups,
        (at_centers, cue): (&[OpenSky], Option<DepthCue>),
        (raw, passing): (&mut Raw, &mut [f32]),
        timings: &mut Timings,
    ) -> Result<()> {
        let Sampling { kernel, scene, settings, lights, opaque, .. } = sampling;
        let Setups { first, opaque: alone, whole } = setups;
        let of = alone.as_ref().unwrap_or(scene);
        let settled = self.answer(first, of, settings, raw, timings)?;
        raw.settle(&settled);
        let view = &first.view;
        if let Some(shade) = kernel.shade {
            timings.time("shade", || settle::shade(shade, of, view, &settled, &mut raw.color));
        }
        if let Some(opaque) = opaque {
            opaque.rename(&mut raw.id);
        }
        let mut below = at_centers.iter();
        if let Some(lights) = lights {
            let color = self.light_color(sampling, lights, view, &raw.id, below.next(), timings)?;
            self.pool.put_back(std::mem::replace(&mut raw.color, color));
        }
        self.finish(sampling, view, &raw.id, cue, &mut raw.color, timings);
        if let Some(whole) = whole {
            passing.fill(1.0);
            let mut layers = self.layers(whole, scene, settings, &raw.id, timings)?;
            let view = &whole.setup.view;
            // Back to front.
            while let Some(layer) = layers.pop() {
                let open = at_centers.get(1 + layers.len());
                let mut over = match (lights, kernel.shade) {
                    (Some(lights), _) => self.light_color(sampling, lights, view, &layer, open, timings)?,
                    (None, Some(shade)) => timings.time("shade", || layers::shade(shade, scene, view, &layer))?,
                    (None, None) => Vec::new(),
                };
                // Where the layer shows nothing, what is behind it is no farther surface to draw a line before.
                let shown = layer.iter().zip(&raw.id).map(|(id, behind)| if *id == NONE { *behind } else { *id });
                self.finish(sampling, view, &shown.collect::<Vec<_>>(), cue, &mut over, timings);
                lay_over(&scene.spheres, &layer, &over, &mut raw.color, passing);
            }
        }
        Ok(())
    }

    /// The colours of what a view shows under lights and a sky.
    fn light_color(
        &mut self,
        sampling: Sampling<'_>,
        lights: &LightSetup,
        view: &View,
        ids: &[u32],
        at_centers: Option<&OpenSky>,
        timings: &mut Timings,
    ) -> Result<Vec<f32>> {
        let Sampling { scene, settings, .. } = sampling;
        let pool = Arc::clone(&self.pool);
        let sky = sampling.sky(view.record.strata * view.record.strata);
        let own = match sky.filter(|sky| !sky.at_centers && !sky.smoothing.is_none()) {
            Some(sky) => Some(self.open_sky(sampling, view, ids, sky, timings)?),
            None => None,
        };
        let outputs = LightOutputs { color: true, ..LightOutputs::default() };
        let of = LightRequest::of(outputs, scene.lighting.sky, ids);
        let request = LightRequest { open_sky: at_centers.or(own.as_ref()), ..of };
        let frame = FrameContext { scene, settings, view };
        let light = timings.time("light", || self.light(lights, frame, &request, &pool))?;
        if let Some(own) = own {
            own.put_back(&pool);
        }
        Ok(light.color)
    }

    /// Draws the depth cue and the lines over the colours of what a view shows.
    fn finish(
        &self,
        sampling: Sampling<'_>,
        view: &View,
        ids: &[u32],
        cue: Option<DepthCue>,
        color: &mut [f32],
        timings: &mut Timings,
    ) {
        if let Some(finish) = sampling.finish() {
            let of = (view, sampling.lights.is_some());
            timings.time("finish", || finish.draw(cue, sampling.scene, of, ids, color));
        }
    }

    /// The rays toward the sky from the hits of a view, which shows the spheres `ids`, with those of neighbours.
    fn open_sky(
        &mut self,
        sampling: Sampling<'_>,
        view: &View,
        ids: &[u32],
        sky: PictureSky<'_>,
        timings: &mut Timings,
    ) -> Result<OpenSky> {
        let Sampling { scene, settings, .. } = sampling;
        let pool = Arc::clone(&self.pool);
        let frame = FrameContext { scene, settings, view };
        let request = sky.request(ids);
        let hits = timings.time("light", || self.light(sky.lights, frame, &request, &pool))?.sky;
        let mut own = pool.values(ids.len())?;
        own.copy_from_slice(ids);
        timings.time("smooth", || OpenSky::new(view.record.window(), own, hits, sky.smoothing, &pool))
    }

    /// The rays toward the sky from the centres of a window's pixels, and from those around it as far as smoothing, the neighbours
    /// of a sample, and the frame reach: from the opaque hits, then from those of each layer. `centers` are the spheres that the
    /// centres show.
    fn sky_at_centers(
        &mut self,
        sampling: Sampling<'_>,
        window: Window,
        sky: PictureSky<'_>,
        centers: &[u32],
        timings: &mut Timings,
    ) -> Result<Vec<OpenSky>> {
        let Sampling { scene, settings, .. } = sampling;
        let mut hits = self.center_hits(sampling, (window, sky.window(window, scene)), centers, timings)?;
        let mut all = vec![self.open_sky(sampling, &hits.view, &hits.ids, sky, timings)?];
        if let Some(whole) = &mut hits.whole {
            for layer in self.layers(whole, scene, settings, &hits.ids, timings)? {
                all.push(self.open_sky(sampling, &whole.setup.view, &layer, sky, timings)?);
            }
        }
        hits.put_back(&self.pool);
        Ok(all)
    }

    /// The hits from which rays toward the sky leave: of the centres of the pixels of `wide`, around a window whose centres show the spheres
    /// `centers`. On a device they are the last ones.
    pub(super) fn center_hits<'a>(
        &mut self,
        sampling: Sampling<'_>,
        (window, wide): (Window, Window),
        centers: &'a [u32],
        timings: &mut Timings,
    ) -> Result<CenterHits<'a>> {
        let Sampling { plan, scene, settings, opaque, .. } = sampling;
        let (raster, pool) = (Raster::centres(wide), Arc::clone(&self.pool));
        if wide == window && opaque.is_none() {
            let view = View::for_rays(scene, raster, Records::None)?;
            return Ok(CenterHits { view, ids: centers.into(), whole: None });
        }
        let plan = Plan { kernel: plan.kernel.ids_only(), ..plan.clone() };
        let Setups { mut first, opaque: alone, whole } = self.setups(&sampling, plan, raster, timings)?;
        let mut raw = Raw::new(&first.plan.kernel, first.view.record.pixels(), &pool)?;
        let settled = self.answer(&mut first, alone.as_ref().unwrap_or(scene), settings, &mut raw, timings)?;
        raw.settle(&settled);
        if let Some(opaque) = opaque {
            opaque.rename(&mut raw.id);
        }
        let ids = std::mem::take(&mut raw.id).into();
        raw.put_back(&pool);
        Ok(CenterHits { view: first.into_view(&pool), ids, whole })
    }
}

/// The spheres that the centres of pixels show.
pub(super) struct CenterHits<'a> {
    pub(super) view: View,
    /// The opaque sphere of each pixel.
    pub(super) ids: Cow<'a, [u32]>,
    /// The frame of all spheres, where some are translucent.
    whole: Option<WholeFrame>,
}

impl CenterHits<'_> {
    /// Returns the memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) {
        if let Cow::Owned(ids) = self.ids {
            pool.put_back(ids);
        }
        if let Some(whole) = self.whole {
            whole.put_back(pool);
        }
    }
}

/// The setups for the rays of a raster, of all passes of one eye.
struct Setups {
    /// The frame of the opaque spheres, which may be all.
    first: FrameSetup,
    /// The scene of the opaque spheres, where some are translucent.
    opaque: Option<Scene>,
    /// The frame of all spheres, where some are translucent.
    whole: Option<WholeFrame>,
}

impl Setups {
    fn set_sample(&mut self, sample: u32) {
        self.first.view.record.sample = sample;
        if let Some(whole) = &mut self.whole {
            whole.setup.view.record.sample = sample;
        }
    }

    /// Returns the memory to the pool for the next frame.
    fn put_back(self, pool: &Pool) {
        self.first.put_back(pool);
        if let Some(whole) = self.whole {
            whole.put_back(pool);
        }
    }
}
