//! One frame the whole way: plan, setup, kernel, exact decisions, buffers, report.

use super::light::{FrameContext, LightRequest};
use super::light_state::LightOnDevice;
use super::missed::missed;
use super::order::Ordered;
use super::plan::Plan;
use super::plan::engine::Engine;
use super::renderer::Renderer;
use super::sample::Sampling;
use super::setup::{FrameSetup, ResidentSetup, Stage};
use crate::answers::assemble::Answers;
use crate::answers::light::LightBuffers;
use crate::answers::raw::Raw;
use crate::answers::settle::{self, Settled};
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::placing::Placer;
use crate::cpu;
use crate::cpu::light::LightOutputs;
use crate::error::Result;
use crate::frame::coverage::Coverage;
use crate::frame::report::{Report, Timings, milliseconds};
use crate::frame::{Aov, Buffer, Data, Frame};
use crate::gpu::Gpu;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::gpu::resident::scene::Reach;
use crate::gpu::resident::{Rendered, ResidentFrame};
use crate::gpu::traffic::Traffic;
use crate::parallel;
use crate::progress::Step;
use crate::scene::Scene;
use crate::scene::camera::CameraRecord;
use crate::settings::{Accuracy, Settings};
use crate::view::raster::Raster;
use crate::view::{Records, View};
use crate::window::Window;
use std::sync::Arc;
use web_time::Instant;

/// The rays of a frame.
#[derive(Clone, Copy)]
pub(super) struct FrameRays {
    pub(super) window: Window,
    /// The samples, where there are several per pixel.
    pub(super) samples: Option<Raster>,
}

/// Reasons for the CPU path that are known before the device renders.
const NOT_PLACED: &str = "the device cannot place these spheres for this camera";
const NOTHING: &str = "it has no spheres";

impl Renderer {
    /// Renders `scene`. The backend and adapter of `settings` take effect in [`Renderer::new`] only.
    ///
    /// # Errors
    /// [`Error::Scene`](crate::Error::Scene), [`Error::Settings`](crate::Error::Settings), [`Error::Limits`](crate::Error::Limits),
    /// [`Error::DeviceLost`](crate::Error::DeviceLost), [`Error::Accuracy`](crate::Error::Accuracy),
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn render(&mut self, scene: &Scene, settings: &Settings) -> Result<Frame> {
        if scene.camera.lens.is_curved() {
            return self.render_curved(scene, settings);
        }
        if scene.lighting.sky.is_some_and(|sky| sky.at_centers) && settings.asks(&[Aov::Color]) {
            self.try_drawing();
        }
        let work = |this: &mut Self, plan: Plan, rays: FrameRays| this.frame(plan, rays, scene, settings);
        let (mut frame, blocker) = self.planned(scene, settings, work)?;
        frame.report.warnings.extend(blocker);
        Ok(frame)
    }

    /// The report of a frame before it is rendered: the plan, the device and the settings. No ray is traced.
    ///
    /// # Errors
    /// Errors of [`Renderer::render`] that do not depend on rays.
    pub fn dry_run(&mut self, scene: &Scene, settings: &Settings) -> Result<Report> {
        if scene.camera.lens.is_curved() {
            return self.curved_plan(scene, settings).map(|plan| plan.report);
        }
        let known = |this: &mut Self, plan: Plan, rays: FrameRays| {
            let plan = this.as_set_up(plan, scene, settings, Raster::centres(rays.window))?;
            let mut report = this.report(&plan, scene, settings, rays.samples);
            report.warnings.extend(this.refused.take());
            Ok(report)
        };
        self.planned(scene, settings, known).map(|(report, _)| report)
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
        self.traffic();
        self.frames += 1;
        // Of a frame that was interrupted.
        (self.left_to_host, self.light_on_device) = (None, LightOnDevice::default());
        let mut setup = self.setup(plan, scene, settings, Raster::centres(window), &mut timings)?;
        staging.end()?;
        let pixels = setup.view.record.pixels();
        let tolerance = settings.promise().relative();
        let mut raw = Raw::new(&setup.plan.kernel, pixels, &pool)?;
        let settled = self.answer(&mut setup, scene, settings, &mut raw, &mut timings)?;
        let FrameSetup { plan, view, .. } = &setup;
        watch.check()?;
        raw.settle(&settled);
        let lights =
            plan.light_outputs.is_any().then(|| timings.time("tree", || self.light_setup(scene, plan.accuracy)));
        let outputs = LightOutputs { color: plan.light_outputs.color && samples.is_none(), ..plan.light_outputs };
        let light = match &lights {
            Some(lights) if outputs.is_any() => {
                let sky = if outputs.occlusion { Some(settings.buffer_sky(scene)) } else { scene.lighting.sky };
                let of = FrameContext { scene, settings, view };
                timings.time("light", || self.light(lights, of, &LightRequest::of(outputs, sky, &raw.id), &pool))?
            }
            _ => LightBuffers::default(),
        };
        let mut coverage = settings.coverage.then(|| Coverage::new(window));
        let sampled = match (samples, plan.sampled) {
            (Some(raster), Some(kernel)) => {
                let opaque = self.opaque(plan, scene)?;
                // Of a picture, not of the buffers, translucent spheres block neither lights nor sky.
                let through = opaque.as_deref().filter(|_| plan.light_outputs.color);
                let through =
                    through.map(|opaque| timings.time("tree", || self.light_through(plan, scene, settings, opaque)));
                let lights = through.as_ref().or(lights.as_ref()).filter(|_| plan.light_outputs.color);
                let sampling = Sampling { plan, kernel, scene, settings, lights, opaque: opaque.as_deref() };
                Some(self.sample(sampling, raster, &raw.id, coverage.as_mut(), &mut timings)?)
            }
            _ => {
                if let Some(coverage) = &mut coverage {
                    coverage.add(&raw.id, window.inside(window), window.width());
                }
                None
            }
        };
        if let Some(shade) = plan.kernel.shade {
            timings.time("shade", || settle::shade(shade, scene, view, &settled, &mut raw.color));
        }
        let certify = plan.kernel.is_certified();
        let promised = plan.accuracy != Accuracy::Fast;
        let answers = Answers { pool: &pool, view, raw, certify, promised, settled: &settled, sampled, light };
        let buffers = timings.time("assemble", || answers.assemble(&settings.aovs))?;
        let predicted = match plan.accuracy {
            Accuracy::Fast => timings.time("predict", || setup.predicted(scene)),
            _ => None,
        };
        let (width, height, full) = (window.width(), window.height(), [scene.image.width, scene.image.height]);
        let report = self.report(plan, scene, settings, samples);
        let mut frame = Frame { width, height, window, full, buffers, coverage, report };
        let report = &mut frame.report;
        report.rays = pixels as u64;
        report.hits = frame.buffers.iter().map(hits).sum();
        report.settled = settled.len() as u64;
        let proved = (pixels - settled.len()) as f64 / pixels as f64;
        report.certified = if setup.is_certified() { proved } else { 0.0 };
        report.bound = promised.then(|| bound(&frame.buffers, tolerance));
        report.predicted = predicted;
        report.warnings.extend(setup.warnings(scene, predicted));
        report.warnings.extend(self.refused.take());
        report.warnings.extend(self.left_to_host.take());
        report.light_on_device = self.light_on_device.share();
        report.warnings.extend((report.hits == 0).then(|| missed(scene, settings.window)).flatten());
        report.stages_ms = timings.into_map();
        report.frame_ms = vec![milliseconds(start)];
        let Traffic { busy, kernel_ms, up, down } = self.traffic().unwrap_or_default();
        report.host_ms = report.frame_ms.iter().map(|whole| (whole - busy.as_secs_f64() * 1e3).max(0.0)).collect();
        (report.bytes_up, report.bytes_down) = (up, down);
        report.kernel_ms = kernel_ms.into_iter().collect();
        setup.put_back(&pool);
        Ok(frame)
    }

    /// The report of a frame before it is computed: the decisions of the plan; counts and times are 0 or empty.
    pub(super) fn report(&self, plan: &Plan, scene: &Scene, settings: &Settings, samples: Option<Raster>) -> Report {
        let on_device = self.is_gpu() && self.refused.is_none();
        let idle = settings.idle_layers().filter(|_| !plan.see_through).chain(settings.idle_plastic(scene));
        Report {
            schema: "halfline-render",
            version: 1,
            halfline: env!("CARGO_PKG_VERSION"),
            spheres: scene.spheres.len() as u64,
            adapter: if on_device { self.adapter() } else { cpu::NAME }.to_owned(),
            driver: if on_device { self.driver() } else { cpu::driver() },
            backend: if on_device { "gpu" } else { "cpu" },
            backend_reason: self.backend_reason().to_owned(),
            method: plan.method,
            accuracy: plan.accuracy.name(),
            reason: plan.reason.clone(),
            shade: plan.shade_name(),
            search: plan.engine.name(),
            samples: samples.map_or(1, |raster| raster.count()),
            camera: CameraRecord::new(&scene.camera, [scene.image.width, scene.image.height], settings.aperture).ok(),
            lights: scene.lighting.lights.len() as u64,
            occlusion: settings.sky(scene),
            silhouette: settings.silhouette,
            outline: settings.silhouette.then_some(settings.outline),
            depth_cue: settings.depth_cue,
            layers: plan.see_through.then(|| settings.layers.max(1)),
            opacity_shadows: plan.see_through && settings.opacity_shadows,
            tone: settings.asks(&[Aov::Color]).then(|| settings.toning(scene).tone),
            exposure: settings.exposure,
            setup_ms: self.setup_ms,
            warnings: self.device.passed_over.iter().cloned().chain(idle).collect(),
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
            ResidentSetup::Ready(setup) => return Ok(*setup),
            ResidentSetup::Refused(plan) => plan,
        };
        let pool = Arc::clone(&self.pool);
        let pixels = u64::from(raster.window.width()) * u64::from(raster.window.height());
        let last = if self.opaque.is_of(&scene.spheres) { &mut self.opaque.order } else { &mut self.order };
        let ordered = || last.groups(&scene.spheres, self.frames, pixels);
        let order = (plan.accuracy == Accuracy::Certified).then(ordered).flatten();
        let groups = order.as_ref().map(Ordered::groups);
        FrameSetup::new(plan, (scene, groups), settings, raster, &pool, timings)
    }

    /// The setup where the device holds the spheres, whose reach `reach` returns. Where the device cannot place them, the plan for
    /// the CPU path.
    fn resident_setup(
        &mut self,
        plan: Plan,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        timings: &mut Timings,
        reach: impl FnOnce(&mut Gpu, &mut Timings) -> Result<Option<Reach>>,
    ) -> Result<ResidentSetup> {
        let Some(gpu) = &mut self.device.gpu else { return Ok(ResidentSetup::Refused(plan)) };
        if plan.engine != Engine::Resident {
            return Ok(ResidentSetup::Refused(plan));
        }
        scene.check()?;
        let eye = scene.camera.basis()?.e;
        let reach = if gpu.verdict()?.places { reach(gpu, timings)? } else { None };
        let setup = match reach.and_then(|reach| reach.sizes(eye)) {
            Some(sizes) => timings.time("view", || FrameSetup::resident(plan, scene, settings, raster, sizes))?,
            None => ResidentSetup::Refused(plan),
        };
        Ok(match setup {
            ResidentSetup::Refused(plan) => {
                self.refuse(if scene.spheres.is_empty() { NOTHING } else { NOT_PLACED });
                ResidentSetup::Refused(Plan { engine: Engine::Strips, ..plan })
            }
            ready => ready,
        })
    }

    /// Keeps the reason why the device left the current frame to the CPU path.
    fn refuse(&mut self, reason: &str) {
        self.refused.get_or_insert_with(|| format!("the CPU path rendered this frame: {reason}"));
    }

    /// The plan by which [`Renderer::setup`] sets a frame up, without holding the spheres.
    pub(super) fn as_set_up(&mut self, plan: Plan, scene: &Scene, settings: &Settings, raster: Raster) -> Result<Plan> {
        let reach = |gpu: &mut Gpu, _: &mut Timings| gpu.reach(&scene.spheres);
        match self.resident_setup(plan, scene, settings, raster, &mut Timings::default(), reach)? {
            ResidentSetup::Ready(setup) => Ok(setup.plan),
            ResidentSetup::Refused(plan) if plan.engine == Engine::Strips => {
                let view = View::for_rays(scene, raster, Records::None)?;
                let binning = Binning::of(scene, &view, settings.promise().relative(), &self.pool);
                let engine = if binning.is_bounded()? { plan.engine } else { Engine::Judge };
                Ok(Plan { engine, ..plan })
            }
            ResidentSetup::Refused(plan) => Ok(plan),
        }
    }

    /// Traces and settles: the kernel's answers in `raw`, and the settled pixels.
    pub(super) fn answer(
        &mut self,
        setup: &mut FrameSetup,
        scene: &Scene,
        settings: &Settings,
        raw: &mut Raw,
        timings: &mut Timings,
    ) -> Result<Vec<Settled>> {
        if let Some(gpu) = &mut self.device.gpu {
            gpu.forget_hits();
        }
        if let Stage::Placed(placer) = &setup.stage {
            match self.trace_resident(placer, setup, scene, raw, timings)? {
                Rendered::Frame(binned) => return self.settle(&setup.view, &binned, scene, raw, timings),
                Rendered::Left(reason) => {
                    self.refuse(&reason);
                    setup.move_to_host(scene, settings, &self.pool, timings)?;
                }
            }
        }
        let (view, watch) = (&setup.view, self.watch.clone());
        match &setup.stage {
            Stage::Method => self.trace_method(setup, scene, raw, timings).map(|()| Vec::new()),
            Stage::Binned(binned) => {
                self.trace_strips(setup, binned, scene, raw, timings)?;
                self.settle(view, binned, scene, raw, timings)
            }
            // What was placed is rendered or moved to the host by now.
            Stage::Judge | Stage::Placed(_) => {
                let doing = watch.begin(Step::Settle, raw.id.len() as u64);
                let go_on = || doing.next(u64::from(view.record.columns));
                let settled = timings.time("settle", || settle::exact(scene, view, &go_on));
                doing.end()?;
                settled
            }
        }
    }

    /// Decides the unsure pixels of `raw`.
    fn settle(
        &self,
        view: &View,
        binned: &BinnedScene,
        scene: &Scene,
        raw: &Raw,
        timings: &mut Timings,
    ) -> Result<Vec<Settled>> {
        let unsure = timings.time("settle", || settle::unsure(&raw.id));
        if unsure.is_empty() {
            return Ok(Vec::new());
        }
        let doing = self.watch.begin(Step::Settle, unsure.len() as u64);
        let settled = timings.time("settle", || settle::settle(scene, view, binned, &unsure, &|| doing.next(1)));
        doing.end()?;
        settled
    }

    /// Has the device render the spheres that it holds.
    fn trace_resident(
        &mut self,
        placer: &Placer,
        setup: &FrameSetup,
        scene: &Scene,
        raw: &mut Raw,
        timings: &mut Timings,
    ) -> Result<Rendered> {
        let Some(gpu) = &mut self.device.gpu else { return Ok(Rendered::Left("there is no device".into())) };
        if gpu.hold(scene, self.frames)?.is_none() {
            return Ok(Rendered::Left(NOTHING.into()));
        }
        let pool = Arc::clone(&self.pool);
        let doing = self.watch.begin(Step::Trace, raw.id.len() as u64);
        let frame = ResidentFrame { scene, view: &setup.view, placer, pool: &pool };
        let mut output = Output { raw, timings };
        let rendered = gpu.render_resident(&setup.plan.kernel, frame, &mut output, &|done| doing.reached(done))?;
        doing.end()?;
        Ok(rendered)
    }

    /// Runs a method's kernel or its twin, with the answers in `raw`.
    fn trace_method(&mut self, setup: &FrameSetup, scene: &Scene, raw: &mut Raw, timings: &mut Timings) -> Result<()> {
        let FrameSetup { plan, view, .. } = setup;
        let colors = scene.spheres.colors.as_deref();
        let doing = self.watch.begin(Step::Trace, raw.id.len() as u64);
        match &mut self.device.gpu {
            Some(gpu) => {
                let input = Input { view, colors, rays: KernelRays::Viewing };
                let mut output = Output { raw, timings };
                gpu.run(&plan.kernel, &input, &mut output, &|done| doing.reached(done))?;
            }
            None => {
                let row = || doing.next(u64::from(view.record.columns));
                timings.time("trace", || cpu::render(&plan.kernel, view, None, colors, raw, &row));
            }
        }
        doing.end()
    }

    /// Certifies in strips on the CPU path, with the answers in `raw`.
    fn trace_strips(
        &self,
        setup: &FrameSetup,
        binned: &BinnedScene,
        scene: &Scene,
        raw: &mut Raw,
        timings: &mut Timings,
    ) -> Result<()> {
        let FrameSetup { plan, view, .. } = setup;
        let doing = self.watch.begin(Step::Trace, raw.id.len() as u64);
        let row = || doing.next(u64::from(view.record.columns));
        let colors = scene.spheres.colors.as_deref();
        timings.time("trace", || cpu::certified(&plan.kernel, view, binned, colors, raw, &row));
        doing.end()
    }
}

/// The number of hits in the buffer of ids; 0 in any other.
fn hits(buffer: &Buffer) -> u64 {
    match &buffer.data {
        Data::I32(ids) => parallel::count(ids.len(), |n| ids[n] >= 0) as u64,
        Data::I64(ids) => parallel::count(ids.len(), |n| ids[n] >= 0) as u64,
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
