//! The samples of the pixels: one pass each, whose hits are certified and settled like the hits of the centres, and their means of colour
//! and coverage.

use super::layers::{self, Setups, lay_over};
use super::light::{FrameContext, LightRequest, LightSetup, light};
use super::sampling::Sampling;
use super::sky::PictureSky;
use super::{finish, on_device, sky};
use crate::answers::depth_cue::DepthCue;
use crate::answers::finish::Finish;
use crate::answers::hits::FirstHits;
use crate::answers::light::LightBuffers;
use crate::answers::open_sky::OpenSky;
use crate::answers::samples::{Means, Sums};
use crate::answers::settle;
use crate::cpu::light::LightOutputs;
use crate::frame::coverage::Coverage;
use crate::render::lens::LensPasses;
use crate::render::plan::Plan;
use crate::render::rendering::{Pass, Rendering};
use crate::render::setup::FrameSetup;
use crate::view::View;
use crate::view::picture_rays::PictureRays;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use halfline_ground::error::Result;
use halfline_ground::parallel;

pub(in crate::render) const PASS: Pass = Pass {
    name: "samples",
    output: "the means of colour and coverage over the samples of each pixel, and the spheres that they show",
    runs: |plan, _, settings| plan.sampled.is_some() || settings.coverage,
};

/// The means over the samples, where pictures have passes of their own, and the spheres that they show, where these are counted.
///
/// # Errors
/// Errors of the setups, of the engines and of light.
pub(in crate::render) fn run(
    at: &mut Rendering<'_>,
    FrameSetup { plan, .. }: &FrameSetup,
    trees: Option<&LightSetup>,
    centers: &FirstHits,
) -> Result<(Option<Means>, Option<Coverage>)> {
    let (window, scene, settings) = (at.rays.window, at.scene, at.settings);
    let mut coverage = settings.coverage.then(|| Coverage::new(window));
    let (Some(raster), Some(kernel)) = (at.rays.samples, plan.sampled) else {
        if let Some(coverage) = &mut coverage {
            coverage.add(&centers.raw.id, window.inside(window), window.width());
        }
        return Ok((None, coverage));
    };
    let opaque = match plan.see_through {
        true => Some(at.renderer.opaque.of(&scene.spheres, at.renderer.frames)?),
        false => None,
    };
    // Of a picture, not of the buffers, translucent spheres block neither lights nor sky.
    let through = opaque.as_deref().filter(|_| plan.light_outputs.color);
    let through = through.map(|opaque| layers::light_through(at, plan, opaque));
    let trees = through.as_ref().or(trees).filter(|_| plan.light_outputs.color);
    let sampling = Sampling { plan, kernel, scene, settings, trees, opaque: opaque.as_deref() };
    let means = means(at, sampling, raster, &centers.raw.id, coverage.as_mut())?;
    Ok((Some(means), coverage))
}

/// The means of all samples of `raster`, in their order, on the device where it draws pictures; they are counted in `coverage`. `centers`
/// are the spheres that the pixels' centres show.
fn means(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    mut raster: Raster,
    centers: &[u32],
    mut coverage: Option<&mut Coverage>,
) -> Result<Means> {
    let (scene, window) = (sampling.scene, raster.window);
    let mut lens = LensPasses::new(scene, at.settings, raster)?;
    let (finish, sky) = (sampling.finish(), PictureSky::of(&sampling, raster.count()));
    // Each pass draws its own lines, and has its own rays toward the sky, with samples around the window, so that their mean is
    // smooth and a lens blurs them.
    let margin = finish.map_or(0, Finish::margin).max(sky.map_or(0, |sky| sky.margin()));
    raster.window = window.grown(margin, scene.image.width, scene.image.height);
    let of_centers = sky.filter(|sky| sky.at_centers);
    // The spheres of samples that a device draws stay there.
    if let Some(sky) = of_centers.filter(|_| coverage.is_none())
        && let Some(means) = on_device::run(at, sampling, sky, (window, raster), centers)?
    {
        return Ok(means);
    }
    let open = match of_centers {
        Some(sky) => sky::run(at, sampling, window, sky, centers)?,
        None => Vec::new(),
    };
    let basis = scene.camera.basis()?;
    let over = Over { open: &open, cue: finish.and_then(|finish| finish.cue(scene, &basis)) };
    let pixels = raster.window.width() as usize * raster.window.height() as usize;
    let mut hits = FirstHits::new(&sampling.kernel, pixels, &at.pool)?;
    let mut passing = at.pool.values(if sampling.opaque.is_some() { pixels } else { 0 })?;
    let mut sums = Sums::new(pixels, sampling.kernel.shade.is_some() || sampling.trees.is_some(), &at.pool)?;
    let mut last: Option<Setups> = None;
    for sample in 0..raster.count() {
        let (scene, raster) = match &mut lens {
            Some(lens) => {
                // Each pass has another eye.
                last.take().into_iter().for_each(|setups| setups.put_back(&at.pool));
                lens.pass(sample, raster.window)?
            }
            None => (scene, raster),
        };
        let sampling = Sampling { scene, ..sampling };
        // The spheres are binned once for all passes of one eye, as only the positions within the pixels differ.
        let setups = match &mut last {
            Some(setups) => setups,
            none => {
                let plan = Plan { kernel: sampling.kernel, ..sampling.plan.clone() };
                none.insert(layers::setups(at, &sampling, plan, raster)?)
            }
        };
        setups.set_sample(sample);
        pass(at, sampling, setups, over, (&mut hits, &mut passing))?;
        at.log.time("samples", || sums.add(&hits.raw, &passing));
        if let Some(coverage) = &mut coverage {
            let inside = window.inside(raster.window);
            at.log.time("coverage", || coverage.add(&hits.raw.id, inside, raster.window.width()));
        }
    }
    let means = sums.means(raster.count(), &at.pool)?;
    let is_whole = raster.window == window;
    let means = if is_whole { means } else { means.part(window.inside(raster.window), raster.window.width()) };
    hits.raw.put_back(&at.pool);
    at.pool.put_back(passing);
    open.into_iter().for_each(|open| open.put_back(&at.pool));
    last.into_iter().for_each(|setups| setups.put_back(&at.pool));
    Ok(means)
}

/// Rays toward the sky from the pixels' centres, of the opaque hits and of each layer, and the depth cue: known before the first sample.
#[derive(Clone, Copy)]
struct Over<'a> {
    open: &'a [OpenSky],
    cue: Option<DepthCue>,
}

/// One sample of every pixel, with its colour, and the share of it that layers let pass. The scene is as the pass's eye sees it.
fn pass(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    setups: &mut Setups,
    Over { open, cue }: Over<'_>,
    (hits, passing): (&mut FirstHits, &mut [f32]),
) -> Result<()> {
    let Sampling { kernel, scene, trees, settings, .. } = sampling;
    setups.find(at, &sampling, hits)?;
    let (of, view) = (setups.alone.as_ref().unwrap_or(scene), &setups.first.view);
    let FirstHits { raw, settled } = hits;
    if let Some(shade) = kernel.shade {
        at.log.time("shade", || settle::shade(shade, of, view, settled, &mut raw.color));
    }
    let mut depths = None;
    if let Some(trees) = trees {
        let outputs = LightOutputs { depth: sampling.finish().is_some(), ..COLOR };
        let found = light_of(at, sampling, (trees, outputs), view, &raw.id, open.first())?;
        at.pool.put_back(std::mem::replace(&mut raw.color, found.color));
        depths = Some(found.depth);
    }
    finish::run(at, sampling, view, (&raw.id, depths.as_deref()), cue, &mut raw.color);
    at.pool.put_back(depths.unwrap_or_default());
    let Some(shown) = &mut setups.shown else { return Ok(()) };
    parallel::each(passing, |_, passing| *passing = 1.0);
    let layers = layers::find(at, shown, scene, &raw.id)?;
    let view = shown.view();
    // Back to front.
    for (n, layer) in layers.iter().enumerate().rev() {
        let mut over = match (trees, kernel.shade) {
            (Some(trees), _) => light_of(at, sampling, (trees, COLOR), view, layer, open.get(1 + n))?.color,
            (None, Some(shade)) => at.log.time("shade", || settle::shade_all(shade, scene, view, layer, &at.pool))?,
            (None, None) => Vec::new(),
        };
        // Where the layer shows nothing, what is behind it is no farther surface to draw a line before.
        if sampling.finish().is_some() {
            let front = |n: usize| if layer[n] == NONE { raw.id[n] } else { layer[n] };
            finish::run(at, sampling, view, (&parallel::from_fn(layer.len(), front), None), cue, &mut over);
        }
        let rays = settings.ghost_rim.then(|| PictureRays::new(view, scene.spheres.cuts.as_ref()));
        let opacities = layers::opacities(&scene.spheres, layer, rays.as_ref());
        lay_over(&opacities, &over, &mut raw.color, passing);
        at.pool.put_back(over);
    }
    layers.into_iter().for_each(|layer| at.pool.put_back(layer));
    Ok(())
}

/// The colours alone.
const COLOR: LightOutputs = LightOutputs { color: true, shadow: false, occlusion: false, sky: false, depth: false };

/// Light of the pixels of a view, which show the spheres `ids`: colours, and depths if `outputs` has them. `known` holds the rays toward the
/// sky from the pixels' centres, if these were traced.
fn light_of(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    (trees, outputs): (&LightSetup, LightOutputs),
    view: &View,
    ids: &[u32],
    known: Option<&OpenSky>,
) -> Result<LightBuffers> {
    let Sampling { scene, settings, .. } = sampling;
    let sky = PictureSky::of(&sampling, view.record.strata * view.record.strata);
    let own = match sky.filter(|sky| !sky.at_centers && !sky.smoothing.is_none()) {
        Some(sky) => Some(sky::of_view(at, scene, view, ids, sky)?),
        None => None,
    };
    let of = LightRequest::of(outputs, scene.lighting.sky, ids);
    let request = LightRequest { open_sky: known.or(own.as_ref()), ..of };
    let found = light(at, trees, FrameContext { scene, settings, view }, &request)?;
    own.into_iter().for_each(|own| own.put_back(&at.pool));
    Ok(found)
}
