//! One frame the whole way: plan, setup, kernel, exact decisions, buffers, report.

use super::budget::Need;
use super::lens;
use super::light::Pixels;
use super::light_state::LightOnDevice;
use super::missed::missed;
use super::order::Ordered;
use super::place::Executor;
use super::plan::Plan;
use super::plan::search::{Device, NOT_PLACED};
use super::renderer::Renderer;
use super::setup::FrameSetup;
use crate::answers::assemble::Answers;
use crate::answers::lit::Lit;
use crate::answers::raw::Raw;
use crate::answers::settle::{self, Settled};
use crate::certify::binned::{BinnedScene, Binning};
use crate::cpu::light::Wanted;
use crate::error::{Error, Result};
use crate::frame::report::{Report, Timings, milliseconds};
use crate::frame::{Aov, Buffer, Data, Frame};
use crate::gpu::Gpu;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::gpu::resident::held::Reach;
use crate::gpu::resident::{Rendered, ResidentFrame};
use crate::gpu::traffic::Traffic;
use crate::progress::Step;
use crate::quote::setting::{ACCURACY, BACKEND};
use crate::scene::Scene;
use crate::scene::camera::CameraRecord;
use crate::search::tile_candidates::CandidateList;
use crate::settings::{Accuracy, Backend, Search, Settings};
use crate::view::raster::Raster;
use crate::window::Window;
use crate::{cpu, memory};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// The rays of a frame.
#[derive(Clone, Copy)]
pub(super) struct FrameRays {
    pub(super) window: Window,
    /// The samples, where there are several per pixel.
    pub(super) samples: Option<Raster>,
}

/// The most spheres that a ray tests one after the other on a software adapter: llvmpipe ends all loops of a shader after 65,536
/// iterations, in each of which a ray tests eight.
const LONGEST: u32 = 500_000;

impl Renderer {
    /// Renders `scene`. The backend and adapter of `settings` take effect in [`Renderer::new`] only.
    ///
    /// # Errors
    /// [`Error::Scene`], [`Error::Settings`], [`Error::Limits`], [`Error::DeviceLost`], [`Error::Accuracy`],
    /// [`Error::Interrupted`].
    pub fn render(&mut self, scene: &Scene, settings: &Settings) -> Result<Frame> {
        let work = |this: &mut Self, plan: Plan, rays: FrameRays| this.frame(plan, rays, scene, settings);
        let (mut frame, blocker) = self.planned(scene, settings, work)?;
        frame.report.warnings.extend(blocker);
        Ok(frame)
    }

    /// The report of a frame before it is rendered: what would compute it and how. No ray is traced.
    ///
    /// # Errors
    /// Those of [`Renderer::render`] that do not depend on rays.
    pub fn dry_run(&mut self, scene: &Scene, settings: &Settings) -> Result<Report> {
        let known = |this: &mut Self, plan: Plan, rays: FrameRays| {
            let plan = this.as_set_up(plan, scene, settings, Raster::centres(rays.window))?;
            Ok(this.report(&plan, scene, settings, rays.samples))
        };
        self.planned(scene, settings, known).map(|(report, _)| report)
    }

    /// Runs `work` with the plan: on the CPU path with a warning if the adapter may not certify.
    pub(super) fn planned<T>(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        work: impl FnOnce(&mut Self, Plan, FrameRays) -> Result<T>,
    ) -> Result<(T, Option<String>)> {
        let by_host = Plan::new(scene, settings, &mut |method| self.check_method(method).is_ok())?;
        let plan = by_host.clone().on(self.device(), settings)?;
        let window = settings.window_of(scene)?;
        settings.check_lighting(scene)?;
        let samples = Raster::samples(window, settings.samples, settings.seed, &scene.image)?;
        let samples = lens::raster(samples, scene, settings)?;
        let samples = plan.sampled.map(|_| samples.unwrap_or(Raster::centres(window)));
        let rays = FrameRays { window, samples };
        Need::of(&plan, settings, scene, window, self.is_gpu()).check(memory::free(&self.pool))?;
        self.check_method(plan.kernel.method)?;
        let Some(blocker) = self.certification_blocker(plan.accuracy)? else {
            return work(self, plan, rays).map(|done| (done, None));
        };
        if settings.backend == Backend::Gpu {
            return Err(Error::Accuracy {
                problem: blocker,
                mend: format!("use {BACKEND} auto or cpu, or {ACCURACY} fast"),
            });
        }
        let adapter = std::mem::replace(&mut self.place, Executor::Cpu);
        let plan = by_host.on(self.device(), settings)?;
        let done = work(self, plan, rays);
        self.place = adapter;
        done.map(|done| (done, Some(format!("{blocker}: the CPU path is used instead"))))
    }

    /// What computes frames.
    pub(super) fn device(&self) -> Device {
        match &self.place {
            Executor::Cpu => Device::Cpu,
            Executor::Gpu(gpu) if gpu.summary.is_software() => Device::Software,
            Executor::Gpu(_) => Device::Hardware,
        }
    }

    /// Why this adapter may not certify; `None` if it may.
    pub(super) fn certification_blocker(&mut self, accuracy: Accuracy) -> Result<Option<String>> {
        match &mut self.place {
            Executor::Gpu(gpu) if accuracy == Accuracy::Certified => {
                let passed = gpu.verdict()?.f32;
                let name = &gpu.summary.name;
                let blocker = || {
                    format!(
                        "{name} failed the self-test of its f32 arithmetic (see halfline adapters) and cannot certify"
                    )
                };
                Ok((!passed).then(blocker))
            }
            _ => Ok(None),
        }
    }

    /// Renders a window of one frame with the plan.
    fn frame(&mut self, plan: Plan, rays: FrameRays, scene: &Scene, settings: &Settings) -> Result<Frame> {
        let FrameRays { window, samples } = rays;
        let start = Instant::now();
        let pool = Arc::clone(&self.pool);
        pool.next_frame();
        let mut timings = Timings::default();
        let watch = self.watch.clone();
        watch.check()?;
        let staging = watch.begin(Step::Stage, scene.spheres.len() as u64);
        // Discards what was done before, for example by a self-test.
        self.kernel_ms();
        self.traffic();
        self.frames += 1;
        // Of a frame that was interrupted.
        (self.left_to_host, self.light_on_device) = (None, LightOnDevice::default());
        let mut setup = self.setup(plan, scene, settings, Raster::centres(window), &mut timings)?;
        staging.end()?;
        let pixels = setup.view.record.pixels();
        let tolerance = settings.promise().relative();
        let mut raw = Raw::new(&setup.plan.kernel, pixels, &pool)?;
        let settled = self.answer(&mut setup, scene, &mut raw, &mut timings)?;
        let FrameSetup { plan, view, .. } = &setup;
        watch.check()?;
        raw.settle(&settled);
        let lights = plan.wanted.is_any().then(|| timings.time("tree", || self.light_setup(scene, plan.accuracy)));
        let wanted = Wanted { color: plan.wanted.color && samples.is_none(), ..plan.wanted };
        let lit = match &lights {
            Some(lights) if wanted.is_any() => {
                let sky = if wanted.occlusion { Some(settings.buffer_sky(scene)) } else { scene.lighting.sky };
                let of = (scene, settings, view);
                timings.time("light", || self.light(lights, of, (wanted, sky), (Pixels::all(&raw.id), None), &pool))?
            }
            _ => Lit::default(),
        };
        let sampled = samples
            .zip(plan.sampled)
            .map(|(raster, kernel)| {
                self.sample(plan, kernel, (scene, settings, lights.as_ref()), (raster, &raw.id), &mut timings)
            })
            .transpose()?;
        let kernel_ms = self.kernel_ms();
        if let Some(shade) = plan.kernel.shade {
            timings.time("shade", || settle::shade(shade, scene, view, &settled, &mut raw.color));
        }
        let certify = plan.kernel.certify;
        let answers = Answers { pool: &pool, view, raw, certify, settled: &settled, sampled, lit };
        let buffers = timings.time("assemble", || answers.assemble(&settings.aovs))?;
        let predicted = match plan.accuracy {
            Accuracy::Fast => timings.time("predict", || setup.predicted(scene)),
            _ => None,
        };
        let (width, height, full) = (window.width(), window.height(), [scene.image.width, scene.image.height]);
        let report = self.report(plan, scene, settings, samples);
        let mut frame = Frame { width, height, window, full, buffers, report };
        let report = &mut frame.report;
        report.rays = pixels as u64;
        report.hits = frame.buffers.iter().map(hits).sum();
        report.settled = settled.len() as u64;
        let proved = (pixels - settled.len()) as f64 / pixels as f64;
        report.certified = setup.certified().map_or(0.0, |_| proved);
        report.bound = certify.then(|| bound(&frame.buffers, tolerance));
        report.predicted = predicted;
        report.warnings.extend(setup.warnings(scene, settings, predicted));
        report.warnings.extend(self.left_to_host.take());
        report.light_on_device = self.light_on_device.take().share();
        report.warnings.extend((report.hits == 0).then(|| missed(scene, settings.window)).flatten());
        report.stages_ms = timings.into_map();
        report.frame_ms = vec![milliseconds(start)];
        let Traffic { busy, up, down } = self.traffic().unwrap_or_default();
        report.host_ms = report.frame_ms.iter().map(|whole| (whole - busy.as_secs_f64() * 1e3).max(0.0)).collect();
        (report.bytes_up, report.bytes_down) = (up, down);
        report.kernel_ms = kernel_ms.into_iter().collect();
        if let Some(binned) = setup.binned {
            binned.put_back(&pool);
        }
        Ok(frame)
    }

    /// The report of a frame before it is computed: what the plan decides; counts and times are 0 or empty.
    fn report(&self, plan: &Plan, scene: &Scene, settings: &Settings, samples: Option<Raster>) -> Report {
        Report {
            schema: "halfline-render",
            version: 1,
            halfline: env!("CARGO_PKG_VERSION"),
            spheres: scene.spheres.len() as u64,
            adapter: self.adapter().to_owned(),
            driver: self.driver(),
            backend: if self.is_gpu() { "gpu" } else { "cpu" },
            backend_reason: self.backend_reason().to_owned(),
            method: plan.method,
            accuracy: plan.accuracy.name(),
            reason: plan.reason.clone(),
            shade: plan.shade_name(),
            search: plan.search.name(),
            samples: samples.map_or(1, |raster| raster.count()),
            camera: CameraRecord::new(&scene.camera, [scene.image.width, scene.image.height], settings.aperture).ok(),
            lights: scene.lighting.lights.len() as u64,
            occlusion: settings.sky(scene),
            silhouette: settings.silhouette,
            depth_cue: settings.depth_cue,
            tone: settings.asks(&[Aov::Color]).then(|| settings.toning(scene).tone),
            exposure: settings.exposure,
            setup_ms: self.setup_ms,
            warnings: self.passed_over.clone(),
            ..Report::default()
        }
    }

    /// The setup of a frame: a device that certifies holds the spheres, else the host bins them.
    pub(super) fn setup(
        &mut self,
        plan: Plan,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        timings: &mut Timings,
    ) -> Result<FrameSetup> {
        let frame = self.frames;
        let hold = |gpu: &mut Gpu, timings: &mut Timings| timings.time("hold", || gpu.hold(scene, frame));
        let plan = match self.resident_setup(plan, scene, settings, raster, timings, hold)? {
            Ok(setup) => return Ok(setup),
            Err(plan) => plan,
        };
        let pool = Arc::clone(&self.pool);
        let pixels = u64::from(raster.window.width()) * u64::from(raster.window.height());
        let ordered = || self.order.groups(&scene.spheres, self.frames, pixels);
        let order = (plan.accuracy == Accuracy::Certified).then(ordered).flatten();
        let groups = order.as_ref().map(Ordered::groups);
        FrameSetup::new(plan, (scene, groups), settings, raster, &pool, timings)
    }

    /// The setup where the device holds the spheres, whose reach `reach` returns. Else the plan, which is by tiles if the device
    /// cannot place them.
    fn resident_setup(
        &mut self,
        plan: Plan,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        timings: &mut Timings,
        reach: impl FnOnce(&mut Gpu, &mut Timings) -> Result<Option<Reach>>,
    ) -> Result<std::result::Result<FrameSetup, Plan>> {
        let Executor::Gpu(gpu) = &mut self.place else { return Ok(Err(plan)) };
        if plan.search != Search::Splat {
            return Ok(Err(plan));
        }
        scene.check()?;
        let eye = scene.camera.basis()?.e;
        let reach = if gpu.verdict()?.places { reach(gpu, timings)? } else { None };
        let Some(sizes) = reach.and_then(|reach| reach.sizes(eye)) else { return Ok(Err(plan.by_tiles(NOT_PLACED))) };
        let setup = timings.time("view", || FrameSetup::resident(plan, scene, settings, raster, sizes))?;
        Ok(setup.map_err(|plan| plan.by_tiles(NOT_PLACED)))
    }

    /// The plan by which [`Renderer::setup`] sets a frame up, without holding the spheres.
    pub(super) fn as_set_up(&mut self, plan: Plan, scene: &Scene, settings: &Settings, raster: Raster) -> Result<Plan> {
        let reach = |gpu: &mut Gpu, _: &mut Timings| gpu.reach(&scene.spheres);
        let setup = self.resident_setup(plan, scene, settings, raster, &mut Timings::default(), reach)?;
        Ok(setup.map_or_else(|plan| plan, |setup| setup.plan))
    }

    /// Traces and settles: the kernel's answers in `raw`, and the settled pixels.
    pub(super) fn answer(
        &mut self,
        setup: &mut FrameSetup,
        scene: &Scene,
        raw: &mut Raw,
        timings: &mut Timings,
    ) -> Result<Vec<Settled>> {
        let watch = self.watch.clone();
        if let Executor::Gpu(gpu) = &mut self.place {
            gpu.forget_hits();
        }
        let is_resident = self.trace_resident(setup, scene, raw, timings)?;
        let setup = &*setup;
        let (view, binned) = (&setup.view, setup.certified());
        let settle = |pixels: usize| watch.begin(Step::Settle, pixels as u64);
        let (settled, doing) = if setup.is_traced() {
            if !is_resident {
                self.trace_frame(setup, scene, raw, timings)?;
            }
            let Some(binned) = binned else { return Ok(Vec::new()) };
            let unsure = timings.time("settle", || settle::unsure(&raw.id));
            if unsure.is_empty() {
                return Ok(Vec::new());
            }
            let doing = settle(unsure.len());
            let go_on = || doing.next(1);
            (timings.time("settle", || settle::settle(scene, view, binned, &unsure, &go_on)), doing)
        } else {
            let doing = settle(raw.id.len());
            let go_on = || doing.next(u64::from(view.record.columns));
            (timings.time("settle", || settle::exact(scene, view, &go_on)), doing)
        };
        doing.end()?;
        settled
    }

    /// Has the device render the spheres that it holds, if it does. Where it leaves the frame to the host, the host bins
    /// the spheres.
    fn trace_resident(
        &mut self,
        setup: &mut FrameSetup,
        scene: &Scene,
        raw: &mut Raw,
        timings: &mut Timings,
    ) -> Result<bool> {
        let FrameSetup { plan, view, placer, .. } = &*setup;
        let (Executor::Gpu(gpu), Some(placer)) = (&mut self.place, placer) else { return Ok(false) };
        let pool = Arc::clone(&self.pool);
        let doing = self.watch.begin(Step::Trace, raw.id.len() as u64);
        let frame = ResidentFrame { scene, view, placer, pool: &pool };
        let mut output = Output { raw, timings };
        match gpu.render_resident(&plan.kernel, frame, &mut output, &|done| doing.reached(done))? {
            Rendered::Frame(binned) => {
                setup.binned = Some(*binned);
                doing.end()?;
                Ok(true)
            }
            Rendered::Left(reason) => {
                let tolerance = placer.tolerance();
                let level = plan.search.level();
                setup.binned = timings.time("stage", || {
                    BinnedScene::new(&Binning { level, ..Binning::of(scene, view, tolerance, &pool) })
                })?;
                setup.placer = None;
                setup.plan = setup.plan.clone().by_tiles(NOT_PLACED);
                self.left_to_host = Some(format!("the host searched the spheres of this frame: {reason}"));
                doing.end()?;
                Ok(false)
            }
        }
    }

    /// Runs the kernel or its twin, with the answers in `raw`.
    fn trace_frame(&mut self, setup: &FrameSetup, scene: &Scene, raw: &mut Raw, timings: &mut Timings) -> Result<()> {
        let FrameSetup { plan, view, .. } = setup;
        let pool = Arc::clone(&self.pool);
        let (colors, candidates) = (scene.spheres.colors.as_deref(), setup.candidates(scene, &pool));
        let doing = self.watch.begin(Step::Trace, raw.id.len() as u64);
        let row = || doing.next(u64::from(view.record.columns));
        let kernel = self.kernel_of(setup);
        let tested = || match &candidates {
            None => view.record.spheres,
            Some(lists) => lists.binned().lists.longest().saturating_add(lists.binned().generals.len() as u32),
        };
        let is_too_long = self.device() == Device::Software && tested() > LONGEST;
        if is_too_long {
            let (adapter, tested) = (self.adapter(), tested());
            self.left_to_host =
                Some(format!("the CPU path traced this frame: {adapter} ends loops over {tested} spheres"));
        }
        match &mut self.place {
            Executor::Gpu(gpu) if !is_too_long => {
                let input = Input { view, colors, rays: KernelRays::Viewing, candidates };
                let (go_on, mut output) = (|done| doing.reached(done), Output { raw, timings });
                match kernel.winners {
                    true => gpu.find_winners(&kernel, &plan.kernel, &input, &mut output, &pool, &go_on)?,
                    false => gpu.run(&kernel, &input, &mut output, &go_on)?,
                }
            }
            _ => timings.time("trace", || match candidates {
                None => cpu::render(&plan.kernel, view, colors, raw, &row),
                Some(CandidateList::Uncertified(tile_candidates)) => {
                    cpu::by_tiles(&plan.kernel, &tile_candidates, colors, raw, &row)
                }
                Some(CandidateList::Certified(binned)) => cpu::certified(&plan.kernel, view, binned, colors, raw, &row),
            }),
        }
        doing.end()
    }
}

/// The number of hits in the buffer of ids; 0 in any other.
fn hits(buffer: &Buffer) -> u64 {
    match &buffer.data {
        Data::I32(ids) => ids.par_iter().filter(|id| **id >= 0).count() as u64,
        Data::I64(ids) => ids.par_iter().filter(|id| **id >= 0).count() as u64,
        _ => 0,
    }
}

/// The largest proven relative error of the distance, where it is requested; else the promised tolerance.
fn bound(buffers: &[Buffer], promised: f64) -> f64 {
    let values = |aov: Aov| buffers.iter().find(|b| b.aov == aov).map(|b| &b.data);
    match (values(Aov::Bound), values(Aov::Distance)) {
        (Some(Data::F64(bounds)), Some(Data::F64(distances))) => {
            bounds.iter().zip(distances).map(|(b, d)| b / d).fold(0.0, f64::max)
        }
        _ => promised,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aov, Camera, ImagePlane, Spheres};

    /// An adapter that failed the self-test does not certify: the CPU path is used with a warning, or it is an error.
    #[test]
    fn an_adapter_that_failed_the_self_test_does_not_certify() {
        let Some(_) = crate::testing::adapter_or_skip() else { return };
        let mut spheres = Spheres::default();
        spheres.push([0.0, 0.0, -3.0], 1.0, None);
        let image = ImagePlane { width: 16, height: 16, background: [0.0; 3] };
        let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
        let gpu = Settings { backend: Backend::Gpu, aovs: vec![Aov::Id], ..Settings::default() };
        let mut renderer = Renderer::new(&gpu).expect("an adapter; tests/run installs and pins one");
        assert_eq!(renderer.render(&scene, &gpu).expect("a frame").report.backend, "gpu");
        let Executor::Gpu(adapter) = &mut renderer.place else { panic!("a GPU was requested") };
        adapter.distrust();
        let error = renderer.render(&scene, &gpu).expect_err("the CPU path is not allowed");
        assert!(matches!(error, Error::Accuracy { .. }), "{error}");
        let auto = Settings { backend: Backend::Auto, ..gpu.clone() };
        let report = renderer.render(&scene, &auto).expect("a frame").report;
        assert_eq!((report.backend, report.accuracy), ("cpu", "certified"));
        assert!(report.warnings.iter().any(|w| w.contains("self-test")), "{:?}", report.warnings);
        let plan = renderer.explain(&scene, &auto).expect("a plan");
        assert_eq!((plan.backend, plan.accuracy, &plan.warnings), ("cpu", "certified", &report.warnings));
        assert!(matches!(renderer.explain(&scene, &gpu), Err(Error::Accuracy { .. })), "as rendering does");
        let fast = Settings { accuracy: Accuracy::Fast, ..gpu };
        assert_eq!(renderer.render(&scene, &fast).expect("a frame").report.backend, "gpu", "fast promises nothing");
    }
}
