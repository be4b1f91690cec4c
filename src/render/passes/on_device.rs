//! Pictures of several samples whose colours a device computes (gpu/resident/picture.rs): under a sky whose rays leave from the
//! centres of pixels, and lights without shadows. The host decides the pixels and the rays that f32 does not prove.

use super::light::{FrameContext, HitRays, on_hits};
use super::sampling::Sampling;
use super::sky::{CenterHits, PictureSky, centres};
use crate::answers::open_sky::{SkyAtHit, SkySums};
use crate::answers::samples::Means;
use crate::answers::settle::{self, Settled};
use crate::answers::silhouette::PixelSize;
use crate::certify::cut::SHARP;
use crate::double_double as dd;
use crate::gpu::resident::picture::{MAX_SOURCES, Patches, PictureRecord};
use crate::gpu::resident::sky::SkyRays;
use crate::gpu::resident::{Rendered, ResidentFrame};
use crate::kernel::Certificate;
use crate::render::plan::Plan;
use crate::render::rendering::Rendering;
use crate::render::setup::{self, FrameSetup};
use crate::scene::{Gradient, Scene, SkyLight};
use crate::search::tree::Tree;
use crate::settings::Accuracy;
use crate::view::View;
use crate::view::raster::Raster;
use crate::view::ray::NONE;
use crate::window::Window;
use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use halfline_ground::error::Result;
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::progress::Step;

mod trial;

#[cfg(test)]
mod tests;

/// The least size of a pixel over its depth: below, the f32 depths of two pixels say too little of the gap between them.
const LEAST_PIXEL: f64 = 1.0 / (1 << 19) as f64;

/// The start of the message for a picture that a device did not draw.
const LEFT: &str = "the host drew the samples of this picture";

impl Sampling<'_> {
    /// Whether shaders/picture computes the colours of the picture: no shadows, no materials, no lens with a size, lights infinitely
    /// far and few.
    fn fits_device(&self) -> bool {
        let Scene { lighting, spheres, .. } = self.scene;
        let far = lighting.lights.iter().all(|light| light.source.far().is_some());
        self.plan.accuracy == Accuracy::Certified
            && self.opaque.is_none()
            && self.settings.aperture.is_none()
            && far
            && lighting.lights.len() <= MAX_SOURCES
            && !lighting.shadows
            && spheres.materials.is_none()
            && spheres.cuts.is_none()
    }

    /// The parameters of the picture, with the sums of the sky in this window; `None` where f32 does not know depths well enough.
    fn record(&self, setup: &FrameSetup, tree: &Tree, sums: Window) -> Result<Option<PictureRecord>> {
        let (scene, view) = (self.scene, &setup.view);
        let in_frame = |length: f64| dd::ldexp(length, -view.unit) as f32;
        let vector = |v: DVec3| v.as_vec3().to_array();
        let gradient = Gradient::of(scene);
        let mut record = PictureRecord {
            sky_corner: [sums.x0, sums.y0],
            sky_size: [sums.width(), sums.height()],
            share: scene.lighting.sky.map_or(0.0, |sky| sky.share),
            gradient: gradient.map_or(0, |sky| 1 + u32::from(sky.is_shown)),
            lights: scene.lighting.lights.len() as u32,
            radius: dd::ldexp(1.0, tree.placement.k - view.unit) as f32,
            planes: SkySums::count(gradient.is_some()) as u32 / 2,
            parallel: view.parallel.into(),
            ..PictureRecord::zeroed()
        };
        if let Some(gradient) = gradient {
            (record.up, record.horizon, record.change) =
                (vector(gradient.up), vector(gradient.horizon), vector(gradient.change));
            let shares = SkyLight::new(gradient).shares;
            record.shares.as_flattened_mut().iter_mut().zip(shares).for_each(|(to, share)| *to = share);
        }
        for (to, light) in record.sources.chunks_exact_mut(2).zip(&scene.lighting.lights) {
            let color = Vec3::from_array(light.color) * light.intensity;
            to[0] = light.source.far().unwrap_or_default().as_vec3().extend(0.0).to_array();
            to[1] = color.extend(0.0).to_array();
        }
        let basis = scene.camera.basis()?;
        let finish = self.finish();
        if let Some(line) = finish.and_then(|finish| finish.line) {
            (record.ink, record.strength, record.stretch) = (line.color, line.strength() as f32, line.stretch() as f32);
            record.neighbours = [1, 2].map(|x| line.distance(x) as i32);
            record.between = finish.is_some_and(|finish| finish.between).into();
        }
        if let Some(cue) = finish.and_then(|finish| finish.cue(scene, &basis)) {
            let way = in_frame(cue.far - cue.near).max(f32::MIN_POSITIVE);
            (record.cue_near, record.cue_slope, record.cue_share) = (in_frame(cue.near), 1.0 / way, cue.most as f32);
        }
        let farthest = || {
            let away = |id: usize| (DVec3::from_array(scene.spheres.centers[id]) - basis.e).length();
            let each = parallel::blocks(0..scene.spheres.len(), CHEAP, &|ids, _| ids.map(away).fold(0.0, f64::max));
            each.into_iter().fold(0.0, f64::max)
        };
        let is_fine = match PixelSize::of(view) {
            PixelSize::Perspective(slope) => {
                record.pixel_slope = slope as f32;
                slope >= LEAST_PIXEL
            }
            PixelSize::Parallel(size) => {
                record.pixel_size = in_frame(size);
                size >= LEAST_PIXEL * farthest()
            }
        };
        Ok(Some(record).filter(|record| is_fine && record.radius.is_normal() && record.cue_slope.is_finite()))
    }
}

/// The means of all samples of a picture whose colours the device computes; `None` where the host has to. `centers` are the
/// spheres that the centres of the pixels of `window` show, and the samples belong to a window around it.
pub(super) fn run(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    sky: PictureSky<'_>,
    (window, raster): (Window, Raster),
    centers: &[u32],
) -> Result<Option<Means>> {
    let Sampling { kernel, scene, plan, .. } = sampling;
    let Some(gpu) = at.renderer.device.gpu.as_ref().filter(|_| sampling.fits_device()) else { return Ok(None) };
    if gpu.draws == Some(false) && !gpu.summary.is_software() {
        let reason = format!("the samples of {} differ from the host's", gpu.summary.name);
        at.log.leave_to_host(LEFT, &reason);
    }
    let (Some(tree), Some(true)) = (&sky.trees.tree, gpu.draws) else { return Ok(None) };
    let kernel = kernel.certified_by(|of| Certificate { starts: true, ..of });
    let sums = sky.window(window, scene);
    let plan = Plan { kernel, ..plan.clone() };
    let mut setup = setup::make(at, plan, scene, raster)?;
    let Some(record) = sampling.record(&setup, tree, sums)?.filter(|_| setup.engine.placer().is_some()) else {
        setup.put_back(&at.pool);
        return Ok(None);
    };
    if !sum_sky(at, sampling, sky, tree, (window, sums), (centers, &record))? {
        return Ok(None);
    }
    for sample in 0..raster.count() {
        setup.view.set_sample(sample);
        if let Some(reason) = add_sample(at, &setup, scene)? {
            at.log.leave_to_host(LEFT, &reason);
            return Ok(None);
        }
    }
    let Rendering { renderer, log, .. } = at;
    let Some(gpu) = &mut renderer.device.gpu else { return Ok(None) };
    let (inside, width, count) = (window.inside(raster.window), raster.window.width(), raster.count());
    let pixels = setup.view.record.pixels();
    let means = || gpu.read_picture(pixels, |sums| Means::of_part(sums, inside, width, count));
    log.time("samples", means).map(Some)
}

/// Leaves the sums over the rays toward the sky on the device, from the centres of the pixels of a window and of those around it;
/// whether it could.
fn sum_sky(
    at: &mut Rendering<'_>,
    sampling: Sampling<'_>,
    sky: PictureSky<'_>,
    tree: &Tree,
    (window, sums): (Window, Window),
    (centers, picture): (&[u32], &PictureRecord),
) -> Result<bool> {
    let Sampling { scene, settings, .. } = sampling;
    let center_hits = centres(at, sampling, (window, sums), centers)?;
    let CenterHits { view, ids, .. } = &center_hits;
    let frame = FrameContext { scene, settings, view };
    let request = sky.request(ids);
    let directions = request.directions(frame);
    let hits = HitRays { directions: &directions, lights: &[], reach: sky.sky.reach, seed: settings.seed };
    let (records, record) = hits.records(tree);
    let rays = SkyRays { tree, view, directions: &records, record };
    let left = at.time("light", |at| on_hits(at, &rays, |gpu, rays, go_on| gpu.sum_sky(rays, picture, go_on)))?;
    let Some(left) = left else { return Ok(false) };
    at.log.add_light(ids, left.len());
    // Pixels that the host decided may be misses.
    let left = left.into_iter().map(|pixel| (pixel, ids[pixel as usize]));
    let (hits, misses): (Vec<_>, Vec<_>) = left.partition(|(_, id)| *id != NONE);
    let decided = at.log.time("light", || {
        sky.trees.with_context(tree, frame, &request, &directions, |context| context.sky_at(&hits))
    })?;
    let mut patches = sky_patches(&hits, &decided, ids.len(), picture.planes as usize);
    misses.into_iter().for_each(|(pixel, id)| patches[0].set(pixel as usize, id));
    let Some(gpu) = &mut at.renderer.device.gpu else { return Ok(false) };
    gpu.smooth_sky(&view.record, picture, [&patches[0], &patches[1]], sky.smoothing.0)?;
    center_hits.put_back(&at.pool);
    Ok(true)
}

/// Adds a sample to the picture on the device; the reason where it cannot.
fn add_sample(at: &mut Rendering<'_>, setup: &FrameSetup, scene: &Scene) -> Result<Option<String>> {
    let Rendering { renderer, log, pool, .. } = at;
    let (Some(placer), Some(gpu)) = (setup.engine.placer(), &mut renderer.device.gpu) else {
        return Ok(Some("the device cannot place the spheres".into()));
    };
    let view = &setup.view;
    let doing = renderer.watch.begin(Step::Trace, view.record.pixels() as u64);
    let frame = ResidentFrame { scene, view, placer, pool };
    let mut unsure = Vec::new();
    let binned = match gpu.hit_sample(&setup.plan.kernel, frame, &mut unsure, &mut log.timings)? {
        Rendered::Frame(binned) => binned,
        Rendered::Left(reason) => return Ok(Some(reason)),
    };
    let settled = log.time("settle", || settle::settle(scene, view, &binned, (&unsure, SHARP), &|| doing.next(0)))?;
    let [ids, starts] = hit_patches(view, &settled);
    log.time("samples", || gpu.add_sample(scene, &view.record, [&ids, &starts]))?;
    doing.next(view.record.pixels() as u64);
    doing.end()?;
    Ok(None)
}

/// The words of the hits and of the sums, as shaders/picture/record.wgsl reads them, of hits of a window with so many pixels.
fn sky_patches(hits: &[(u32, u32)], decided: &[SkyAtHit], pixels: usize, planes: usize) -> [Patches; 2] {
    let two = |numbers: &[i16]| u32::from(numbers[0] as u16) | u32::from(numbers[1] as u16) << 16;
    let [mut of_hits, mut of_sums] = [Patches::default(), Patches::default()];
    for ((pixel, id), sky) in hits.iter().zip(decided) {
        let (mut normal, mut sums) = ([0; 4], [0; 12]);
        sky.write(&mut normal[..3], &mut sums[..2 * planes]);
        let place = *pixel as usize;
        let words = [*id].into_iter().chain(normal.chunks_exact(2).map(two));
        words.enumerate().for_each(|(plane, word)| of_hits.set(place + plane * pixels, word));
        let words = sums.chunks_exact(2).take(planes).map(two);
        words.enumerate().for_each(|(plane, word)| of_sums.set(place + plane * pixels, word));
    }
    [of_hits, of_sums]
}

/// The ids and the starts of decided pixels, as the certified kernel writes them. Of the way from the eye only the depth counts.
fn hit_patches(view: &View, settled: &[Settled]) -> [Patches; 2] {
    let [mut ids, mut starts] = [Patches::default(), Patches::default()];
    for Settled { pixel, truth } in settled {
        let pixel = *pixel as usize;
        ids.set(pixel, truth.map_or(NONE, |truth| truth.id));
        let Some(truth) = truth else { continue };
        let way = -view.basis.w * dd::ldexp(truth.depth, -view.unit);
        let words = truth.normal.into_iter().chain([0.0]).chain(way.to_array());
        words.enumerate().for_each(|(n, number)| starts.set(8 * pixel + n, (number as f32).to_bits()));
    }
    [ids, starts]
}
