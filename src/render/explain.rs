//! The report of `halfline plan`: what would be compiled, uploaded and computed, why, and what is left out. No ray is
//! traced.

mod explanation;
mod work;

use super::budget::Need;
use super::engine::BLOCK;
use super::passes;
use super::plan::kind::EngineKind;
use super::plan::{Plan, lights};
use super::renderer::Renderer;
use super::rendering::{FrameRays, Rendering};
use super::report;
use super::setup::{self, FrameSetup};
use crate::frame::Aov;
use crate::gpu::compose::shaders;
use crate::intersect::Method;
use crate::kernel::{Kernel, RaySource, Task};
use crate::scene::camera::CameraRecord;
use crate::scene::{Light, Scene, Sky};
use crate::settings::{Accuracy, Backend, Settings};
use crate::shade::Shade;
use crate::view::raster::Raster;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory;
use halfline_ground::quote::setting::{ACCURACY, BOUNCES, OCCLUSION, SHADOWS};
use work::WorkOfPasses;

pub use explanation::{
    BinnedCounts, DeviceBuffer, Explanation, LeftOut, MaterialCounts, PassOfFrame, PixelRays, Room, ShaderFile, Shown,
};

/// Reports what `scene` requires on the adapter that `settings` select, or on the CPU path if there is none.
///
/// # Errors
/// As [`Renderer::explain`].
pub fn explain(scene: &Scene, settings: &Settings) -> Result<Explanation> {
    Renderer::new(settings)?.explain(scene, settings)
}

/// The WGSL that `scene` requires, as [`Renderer::wgsl`].
///
/// # Errors
/// As [`Renderer::wgsl`].
pub fn wgsl(scene: &Scene, settings: &Settings) -> Result<String> {
    Renderer::new(settings)?.wgsl(scene, settings)
}

impl Renderer {
    /// Reports what rendering `scene` would do here. It takes the same decisions as [`Renderer::render`], including the
    /// self-test of the adapter's arithmetic, and traces no ray.
    ///
    /// # Errors
    /// Errors of [`Renderer::render`] that occur before a ray is traced.
    pub fn explain(&mut self, scene: &Scene, settings: &Settings) -> Result<Explanation> {
        self.with_remaining(scene, |this, scene| {
            let explained = |this: &mut Self, plan: Plan, rays: FrameRays| {
                explanation(&mut Rendering::new(this, scene, settings, rays), plan)
            };
            let (mut explanation, blocker) = this.planned(scene, settings, explained)?;
            explanation.warnings.extend(blocker);
            Ok(explanation)
        })
    }

    /// The WGSL that would be compiled for `scene` on an adapter: every shader of a frame, one after the other, with its purpose
    /// above it and the name of its file above each part.
    ///
    /// # Errors
    /// Errors of [`Renderer::explain`]; [`Error::Settings`] where no kernel runs.
    pub fn wgsl(&mut self, scene: &Scene, settings: &Settings) -> Result<String> {
        let composed = |this: &mut Self, plan: Plan, rays: FrameRays| {
            let mut at = Rendering::new(this, scene, settings, rays);
            let setup = FrameSetup::new(&mut at, plan, (scene, None), Raster::centres(rays.window))?;
            if !has_kernel(&setup.plan) {
                let problem = "the CPU computes these answers without a kernel";
                return Err(Error::settings(problem, format!("use another {ACCURACY} or camera")));
            }
            let all = shaders(&kernel_of(&setup)).into_iter();
            Ok(all.map(|(purpose, source)| format!("// {purpose}\n\n{}", source.with_banners())).collect())
        };
        self.planned(scene, settings, composed).map(|(text, _)| text)
    }
}

/// The report of a plan on this device. The setup is that which the host makes, also of a frame that a device would place.
fn explanation(at: &mut Rendering<'_>, plan: Plan) -> Result<Explanation> {
    let (scene, settings, window) = (at.scene, at.settings, at.rays.window);
    let plan = setup::decided(at, plan, Raster::centres(window))?;
    let report = report::known(at, &plan);
    let setup = FrameSetup::new(at, plan, (scene, None), Raster::centres(window))?;
    let (plan, view, binned) = (&setup.plan, &setup.view, setup.engine.binned());
    let has_kernel = report.backend == "gpu" && has_kernel(plan);
    let work = if has_kernel { work(at, &setup)? } else { WorkOfPasses::default() };
    let gpu = at.renderer.device.gpu.as_deref().filter(|_| report.backend == "gpu");
    let need = Need::of(plan, settings, scene, window, gpu.map(|gpu| &gpu.summary)).with_generals(binned, view);
    // A device that holds the spheres has no lists of the others.
    let need = if gpu.is_some() { need } else { need.with_lists(binned, report.samples) };
    let free = memory::free(&at.pool);
    let predicted = setup.predicted(scene);
    let warnings = report.warnings.into_iter().chain(setup.warnings(scene, predicted)).chain(at.log.warnings());
    let (size, sides) = ([scene.image.width, scene.image.height], [window.width(), window.height()]);
    Ok(Explanation {
        schema: "halfline-plan",
        version: 1,
        halfline: report.halfline,
        spheres: report.spheres,
        skipped: 0,
        size,
        camera: CameraRecord::new(&scene.camera, size, settings.aperture)?,
        window: [window.x0, window.y0, window.x1, window.y1],
        rays: u64::from(sides[0]) * u64::from(sides[1]),
        samples: report.samples,
        lights: report.lights,
        lit_by: scene.lighting.lights.iter().map(ToString::to_string).collect(),
        shadows: has_shadows(plan, scene, settings),
        occlusion: report.occlusion,
        materials: MaterialCounts::of(scene),
        bounces: bounces(plan, scene),
        rays_per_pixel: rays_per_pixel(plan, scene, settings, report.samples),
        silhouette: settings.silhouette && shading(plan).is_some(),
        depth_cue: settings.depth_cue && shading(plan).is_some(),
        layers: report.layers,
        tone: report.tone,
        exposure: report.exposure,
        backend: report.backend,
        backend_reason: report.backend_reason,
        adapter: report.adapter,
        accuracy: report.accuracy,
        method: report.method,
        reason: report.reason,
        tolerance: settings.promise().relative(),
        predicted,
        precision: precision(&setup),
        search: report.search,
        search_reason: plan.engine.reason().to_owned(),
        staged: binned.map(|binned| BinnedCounts::of(binned, scene)),
        passes: passes::of(plan, scene, settings).map(PassOfFrame::from).collect(),
        frame: frame(settings, scene.lighting.lights.len(), sides),
        left_out: left_out(plan, &kernel_of(&setup), scene, settings, has_kernel),
        warnings: warnings.collect(),
        kernel: work.kernel,
        uploaded: work.uploaded,
        written: work.written,
        dispatches: work.dispatches,
        room: Room { adapter: work.spheres, host: free.map(|free| need.fitting(free)), needed: need.bytes(), free },
    })
}

/// The work of a device for all passes of a frame.
fn work(at: &mut Rendering<'_>, setup: &FrameSetup) -> Result<WorkOfPasses> {
    let (scene, FrameSetup { plan, view, engine }) = (at.scene, setup);
    let (samples, mut work) = (at.rays.samples, WorkOfPasses::default());
    if plan.given.is_some() {
        let passes = samples.map_or(1, |raster| 1 + raster.count());
        work.add_given(&shaders(&kernel_of(setup)), (view.record.pixels() as u64).div_ceil(BLOCK as u64), passes);
        return Ok(work);
    }
    let sampled = samples.zip(plan.sampled);
    let of_sample = |at: &mut Rendering<'_>, (raster, kernel): (Raster, Kernel)| -> Result<_> {
        let plan = Plan { kernel, ..plan.clone() };
        Ok((FrameSetup::new(at, plan, (scene, None), raster)?, raster.count()))
    };
    let sampled = sampled.map(|sampled| of_sample(at, sampled)).transpose()?;
    let Some(gpu) = at.renderer.device.gpu.as_deref() else { return Ok(work) };
    work.add(gpu.work(&kernel_of(setup), view, scene, engine.binned()), 1);
    if let Some((passes, count)) = sampled {
        work.add(gpu.work(&kernel_of(&passes), &passes.view, scene, passes.engine.binned()), count);
    }
    Ok(work)
}

/// Whether a kernel or its twin runs.
fn has_kernel(plan: &Plan) -> bool {
    plan.engine != EngineKind::Judge && !plan.certifies_given()
}

/// The kernel of a setup by the host, for its general spheres.
fn kernel_of(setup: &FrameSetup) -> Kernel {
    let Plan { kernel, given, .. } = &setup.plan;
    match given.as_ref().map(|given| (given.certifies(), given.kernel.method())) {
        Some((false, Some(method))) => {
            Kernel { task: Task::Method { method, rays: RaySource::SharedOrigin }, samples: false, ..*kernel }
        }
        Some(_) => Kernel::bare(kernel.task),
        None => kernel.with_generals(setup.engine.binned().map_or(0, |binned| binned.generals.len())),
    }
}

/// The rays of a curved lens.
const LENS_RAYS: &str = "the lens gives the rays in f64, and they are exact from there on";

fn precision(setup: &FrameSetup) -> String {
    let plan = &setup.plan;
    let host = match plan.engine {
        EngineKind::Resident => "spheres are placed with the bits of f64 by integers on the device",
        _ => "spheres are moved relative to the eye in f64 on the host",
    };
    match (plan.engine, plan.accuracy, plan.kernel.method()) {
        (EngineKind::Judge, Accuracy::Exact, _) => "double-double and exact integers on the CPU, every pixel".into(),
        (EngineKind::Given { .. }, Accuracy::Exact, _) => {
            format!("double-double and exact integers on the CPU, every ray; {LENS_RAYS}")
        }
        (EngineKind::Given { .. }, Accuracy::Certified, _) => {
            format!("f64 with an error bound; unsure rays are settled in exact arithmetic; {LENS_RAYS}")
        }
        (EngineKind::Given { .. }, ..) => format!("the method's own, without a bound; {LENS_RAYS}"),
        (EngineKind::Judge, ..) => {
            "double-double and exact integers on the CPU, every pixel: f32 cannot bound this field of view".into()
        }
        (_, Accuracy::Certified, _) => {
            format!("f32 with an error bound; {host}; unsure pixels are settled in exact arithmetic")
        }
        (_, _, None) => format!("f32 with an error bound; {host}; unsure pixels take their nearest candidate"),
        (.., Some(Method::Native64)) => format!("f64; {host} and passed as sums of two f32"),
        (.., Some(Method::DoubleFloat)) => {
            format!("sums of two f32 (48 bits), if the adapter passes the self-test; {host}")
        }
        _ => format!("f32; {host} and rounded once"),
    }
}

/// The buffers of the finished frame; ids are always among them.
fn frame(settings: &Settings, lights: usize, [width, height]: [u32; 2]) -> Vec<Shown> {
    let shown = |aov: &Aov| {
        let is_requested = settings.aovs.contains(aov);
        let mut shape = vec![u64::from(height), u64::from(width)];
        shape.extend(aov.is_vector().then_some(aov.channels(lights) as u64));
        let one = match aov.dtype() {
            "float64" => 8,
            "uint8" => 1,
            _ => 4,
        };
        let bytes = one * shape.iter().product::<u64>();
        (is_requested || *aov == Aov::Id).then(|| Shown {
            name: aov.name(),
            shape,
            dtype: aov.dtype(),
            bytes,
            asked: is_requested,
        })
    };
    Aov::ALL.iter().filter_map(shown).collect()
}

/// Whether shadows are computed.
fn has_shadows(plan: &Plan, scene: &Scene, settings: &Settings) -> bool {
    let lighting = &scene.lighting;
    let in_picture = lighting.shadows && shading(plan) == Some(Shade::Headlight);
    !lighting.lights.is_empty() && (in_picture || settings.aovs.contains(&Aov::Shadow))
}

/// The shading of the picture: by the kernel, or after it by lights, the sky and what mirrors show.
fn shading(plan: &Plan) -> Option<Shade> {
    if plan.light_outputs.color { Some(Shade::Headlight) } else { plan.shade() }
}

/// The most bounces of a ray of the picture; 0 where the stage of lights does not compute the colour.
fn bounces(plan: &Plan, scene: &Scene) -> u32 {
    if plan.light_outputs.color { lights::bounces(scene) } else { 0 }
}

/// The rays of a pixel whose viewing rays all hit.
fn rays_per_pixel(plan: &Plan, scene: &Scene, settings: &Settings, samples: u32) -> PixelRays {
    let viewing = u64::from(samples);
    // Buffers are of the centre; without a picture there are no samples.
    let points = if plan.light_outputs.color { viewing } else { u64::from(plan.light_outputs.is_any()) };
    let spread = u64::from(lights::light_rays(if plan.light_outputs.color { samples } else { 1 }));
    let of_light = |light: &Light| if light.source.has_size() { spread } else { points };
    let lights: u64 = scene.lighting.lights.iter().map(of_light).sum();
    let lights = if has_shadows(plan, scene, settings) { lights } else { 0 };
    let of_sky = |sky: Sky| match settings.sky_at_centers(sky) {
        true => u64::from(sky.rays_at_center(samples)) * points.min(1),
        false => u64::from(sky.rays) * points,
    };
    let sky = scene.lighting.sky.filter(|_| plan.light_outputs.color).or(settings.sky(scene)).map_or(0, of_sky);
    // Glass divides a ray: 2 + 4 + .. + 2^n.
    let counts = MaterialCounts::of(scene);
    let bounces = bounces(plan, scene);
    let each = match counts.clear {
        0 => u64::from(bounces),
        _ => 1u64.checked_shl(bounces + 1).map_or(u64::MAX, |n| n - 2),
    };
    PixelRays { viewing, lights, sky, onward: viewing.saturating_mul(each) }
}

/// Calls `leave` with each part of the light and of the lines that the picture does without, and the reason.
fn leave_light(plan: &Plan, scene: &Scene, settings: &Settings, leave: &mut impl FnMut(&'static str, &str)) {
    let (lighting, shade) = (&scene.lighting, shading(plan));
    if !has_shadows(plan, scene, settings) {
        let unrequested = format!("the lights cast none without {SHADOWS}, and no buffer of them is requested");
        leave(
            "shadows",
            match shade {
                None => "no picture and no buffer of shadows is requested",
                _ if lighting.lights.is_empty() => "the light is at the eye, which sees none of its shadows",
                Some(Shade::Headlight) => &unrequested,
                Some(_) => "this shading uses no lights",
            },
        );
    }
    if settings.sky(scene).is_none() {
        leave("occlusion", &format!("neither {OCCLUSION}, [occlusion] or [sky] nor a buffer of it is requested"));
    }
    if bounces(plan, scene) == 0 {
        let off = format!("{BOUNCES} 0 switches them off");
        leave(
            "mirrors and glass",
            match shade {
                _ if MaterialCounts::of(scene).is_none() => "no sphere asks for them",
                None => "no picture is requested",
                Some(Shade::Headlight) => &off,
                Some(_) => "this shading shows none",
            },
        );
    }
    let why = if shade.is_some() { "not requested" } else { "no picture is requested" };
    for (drawn, what) in [(settings.silhouette, "silhouette"), (settings.depth_cue, "depth cue")] {
        if !(drawn && shade.is_some()) {
            leave(what, why);
        }
    }
}

/// The parts of the renderer that this frame does without, each with the reason.
fn left_out(plan: &Plan, kernel: &Kernel, scene: &Scene, settings: &Settings, device: bool) -> Vec<LeftOut> {
    let mut out = Vec::new();
    let mut leave = |what, why: &str| out.push(LeftOut { what, why: why.to_owned() });
    if !device {
        let why = match plan.accuracy {
            Accuracy::Exact => "exact answers are computed on the CPU",
            Accuracy::Certified if settings.backend != Backend::Cpu => "this frame is computed on the CPU",
            _ => "the CPU path runs the kernels' CPU twins",
        };
        leave("device", why);
    }
    match shading(plan) {
        None => leave("shading", "no picture is requested"),
        Some(shade) if !shade.needs_colors() => leave("sphere colours", "this shading does not use them"),
        Some(_) if scene.spheres.colors.is_none() => {
            leave("sphere colours", "the scene has none; all spheres have the default colour");
        }
        Some(_) => {}
    }
    leave_light(plan, scene, settings, &mut leave);
    if !kernel.t {
        leave("t", "no distance, depth or position is requested");
    }
    if !kernel.normal {
        match plan.shade() {
            None | Some(Shade::Flat) => leave("normals", "not requested, and the shading does not use them"),
            Some(_) => leave("normal buffer", "not requested: normals are computed for shading and not stored"),
        }
    }
    match plan.accuracy {
        Accuracy::Fast => leave("certificate", "the accuracy is fast"),
        _ if !kernel.has_depth_interval() => leave("width of the depth's interval", "no bound is requested"),
        _ => {}
    }
    if !kernel.is_wide() {
        leave("low parts of the spheres", "only methods beyond f32 read them");
    }
    out
}
