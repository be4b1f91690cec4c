//! The sky of a picture: rays toward it from the centres of pixels or from their samples, put together with the rays of neighbours.

use super::layers::{self, Shown};
use super::light::{FrameContext, LightRequest, LightSetup, light};
use super::sampling::Sampling;
use crate::answers::hits::FirstHits;
use crate::answers::open_sky::{OpenSky, Smoothing};
use crate::cpu::light::LightOutputs;
use crate::render::plan::Plan;
use crate::render::rendering::{Pass, Rendering};
use crate::scene::{Scene, Sky};
use crate::view::raster::Raster;
use crate::view::{Records, View};
use crate::window::Window;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use std::borrow::Cow;

pub(in crate::render) const PASS: Pass = Pass {
    name: "sky",
    output: "the rays toward the sky from the pixels' centres, or from each sample, with the rays of neighbours",
    runs: |plan, scene, _| plan.light_outputs.color && scene.lighting.sky.is_some(),
};

/// The sky of a picture.
#[derive(Clone, Copy)]
pub(super) struct PictureSky<'a> {
    pub(super) trees: &'a LightSetup,
    pub(super) sky: Sky,
    /// Rays leave from the centres of pixels, for all samples.
    pub(super) at_centers: bool,
    pub(super) smoothing: Smoothing,
}

impl<'a> PictureSky<'a> {
    /// The sky that lights the picture, with the rays of a pixel's centre or of a sample, and the smoothing for pixels of so many
    /// samples.
    pub(super) fn of(sampling: &Sampling<'a>, samples: u32) -> Option<Self> {
        let (trees, sky) = (sampling.trees?, sampling.scene.lighting.sky?);
        let at_centers = sampling.settings.sky_at_centers(sky);
        let rays = if at_centers { sky.rays_at_center(samples) } else { sky.rays };
        let of_pixel = if at_centers { rays } else { rays.saturating_mul(samples) };
        Some(Self { trees, sky: Sky { rays, ..sky }, at_centers, smoothing: Smoothing::of(of_pixel) })
    }

    /// A request for the rays toward the sky from the hits of pixels that show these spheres.
    pub(super) fn request<'b>(&self, ids: &'b [u32]) -> LightRequest<'b> {
        let outputs = LightOutputs { sky: true, ..LightOutputs::default() };
        LightRequest { interleaved: !self.smoothing.is_none(), ..LightRequest::of(outputs, Some(self.sky), ids) }
    }

    /// The window of the pixels from whose centres rays leave, for the samples of a window: with those around it as far as smoothing,
    /// and the neighbours of a sample, reach.
    pub(super) fn window(&self, window: Window, scene: &Scene) -> Window {
        window.grown(self.smoothing.margin() + 1, scene.image.width, scene.image.height)
    }

    /// Pixels on each side of a window from which each pass of samples traces rays toward the sky.
    pub(super) fn margin(&self) -> u32 {
        if self.at_centers { 0 } else { self.smoothing.margin() }
    }
}

/// The rays toward the sky from the hits of a view, which shows the spheres `ids`, with the rays of neighbours.
pub(super) fn of_view(
    at: &mut Rendering<'_>,
    scene: &Scene,
    view: &View,
    ids: &[u32],
    sky: PictureSky<'_>,
) -> Result<OpenSky> {
    let frame = FrameContext { scene, settings: at.settings, view };
    let hits = light(at, sky.trees, frame, &sky.request(ids))?.sky;
    let mut own = at.pool.values(ids.len())?;
    own.copy_from_slice(ids);
    let Rendering { log, pool, .. } = at;
    log.time("smooth", || OpenSky::new(view.record.window(), own, hits, sky.smoothing, pool))
}

/// The rays toward the sky from the centres of a window's pixels, and from those around it as far as smoothing, the neighbours
/// of a sample, and the frame reach. The opaque hits come first, then the hits of each layer. `centers` are the spheres that the
/// centres show.
pub(super) fn run(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    window: Window,
    sky: PictureSky<'_>,
    centers: &[u32],
) -> Result<Vec<OpenSky>> {
    let scene = sampling.scene;
    let mut hits = centres(at, sampling, (window, sky.window(window, scene)), centers)?;
    let mut all = vec![of_view(at, scene, &hits.view, &hits.ids, sky)?];
    if let Some(shown) = &mut hits.shown {
        for layer in layers::find(at, shown, scene, &hits.ids)? {
            all.push(of_view(at, scene, shown.view(), &layer, sky)?);
        }
    }
    hits.put_back(&at.pool);
    Ok(all)
}

/// The hits from which rays toward the sky leave: of the centres of the pixels of `wide`, around a window whose centres show the spheres
/// `centers`. On a device they are the last ones.
pub(super) fn centres<'a>(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    (window, wide): (Window, Window),
    centers: &'a [u32],
) -> Result<CenterHits<'a>> {
    let Sampling { plan, scene, .. } = sampling;
    let raster = Raster::centres(wide);
    if wide == window && !plan.see_through {
        let view = View::for_rays(scene, raster, Records::None)?;
        return Ok(CenterHits { view, ids: centers.into(), shown: None });
    }
    let plan = Plan { kernel: plan.kernel.ids_only(), ..plan.clone() };
    let mut setups = layers::setups(at, &sampling, plan, raster)?;
    let mut hits = FirstHits::new(&setups.first.plan.kernel, setups.first.view.record.pixels(), &at.pool)?;
    setups.find(at, &sampling, &mut hits)?;
    let ids = hits.into_ids(&at.pool).into();
    Ok(CenterHits { view: setups.first.into_view(&at.pool), ids, shown: setups.shown })
}

/// The spheres that the centres of pixels show.
pub(super) struct CenterHits<'a> {
    pub(super) view: View,
    /// The opaque sphere of each pixel.
    pub(super) ids: Cow<'a, [u32]>,
    /// The translucent ones before them, where there are some.
    shown: Option<Shown>,
}

impl CenterHits<'_> {
    /// Returns the memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) {
        if let Cow::Owned(ids) = self.ids {
            pool.put_back(ids);
        }
        if let Some(shown) = self.shown {
            shown.put_back(pool);
        }
    }
}
