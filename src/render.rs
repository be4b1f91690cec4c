//! One frame, the whole way: scene, view, nearest hits, colour, frame.

use crate::cpu;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::frame::raw::Raw;
use crate::gpu::Gpu;
use crate::gpu::device::{self, AdapterSummary, Open};
use crate::gpu::dispatch::Input;
use crate::intersect::Method;
use crate::plan::{Backend, Plan, Settings, Sharing};
use crate::report::{Report, Stages, milliseconds};
use crate::scene::Scene;
use crate::view::View;
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Renders `scene` once. For many frames keep a [`Renderer`].
///
/// # Errors
/// Every kind of [`Error`]; nothing is half done.
pub fn render(scene: &Scene, settings: &Settings) -> Result<Frame> {
    Renderer::new(settings)?.render(scene, settings)
}

/// A device with its pipelines and buffers, or the CPU reference path, kept for many frames.
pub struct Renderer {
    pub(crate) place: Place,
    setup_ms: f64,
    go_on: Arc<dyn Fn() -> bool + Send + Sync>,
}

/// Where frames are computed.
pub(crate) enum Place {
    Gpu(Box<Gpu>),
    Cpu,
}

impl Renderer {
    /// Opens what `settings.backend` and `settings.adapter` ask for. `WGPU_ADAPTER_NAME` and `WGPU_BACKEND` are
    /// honoured where the settings leave a choice.
    ///
    /// # Errors
    /// [`Error::Adapter`] when nothing fits, [`Error::Settings`] for an adapter on the CPU path.
    pub fn new(settings: &Settings) -> Result<Self> {
        let start = Instant::now();
        if settings.backend == Backend::Cpu && settings.adapter.is_some() {
            return Err(Error::settings("the cpu backend has no adapters", "leave out --adapter or use --backend gpu"));
        }
        let place = match settings.backend {
            Backend::Cpu => Place::Cpu,
            Backend::Gpu | Backend::Auto => {
                let named = settings.adapter.clone().or_else(|| std::env::var("WGPU_ADAPTER_NAME").ok());
                match device::choose(device::find()?, named.as_deref())? {
                    Some(found) => Place::Gpu(Box::new(Gpu::new(device::open(&found)?, found.summary))),
                    None if settings.backend == Backend::Auto => Place::Cpu,
                    None => return Err(device::none_found()),
                }
            }
        };
        Ok(Self { place, setup_ms: milliseconds(start), go_on: Arc::new(|| true) })
    }

    /// Renders on the caller's own device. Subgroup features that the device was opened with are used.
    #[must_use]
    pub fn with_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let summary = AdapterSummary::of_device(&device);
        let open = Open { device, queue, lost: Arc::new(Mutex::new(None)) };
        Self { place: Place::Gpu(Box::new(Gpu::new(open, summary))), setup_ms: 0.0, go_on: Arc::new(|| true) }
    }

    /// Asks `go_on` now and then; when it says no, the work ends with [`Error::Interrupted`].
    #[must_use]
    pub fn cancelled_by(mut self, go_on: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        self.go_on = Arc::new(go_on);
        self
    }

    /// The adapter's name, `cpu` for the reference path.
    #[must_use]
    pub fn adapter(&self) -> &str {
        match &self.place {
            Place::Gpu(gpu) => &gpu.summary.name,
            Place::Cpu => cpu::NAME,
        }
    }

    /// Driver and its version, threads for the reference path.
    #[must_use]
    pub fn driver(&self) -> String {
        match &self.place {
            Place::Gpu(gpu) => gpu.summary.driver.clone(),
            Place::Cpu => cpu::driver(),
        }
    }

    /// Whether `method` can run here. On the CPU path all can.
    ///
    /// # Errors
    /// [`Error::Accuracy`] with the reason why the adapter's arithmetic does not allow it; what measuring it runs into.
    pub fn admit(&mut self, method: Method) -> Result<()> {
        match &mut self.place {
            Place::Gpu(gpu) => gpu.admit(method),
            Place::Cpu => Ok(()),
        }
    }

    /// Renders `scene`. The backend and adapter of `settings` were chosen when the renderer was made and are not
    /// looked at again.
    ///
    /// # Errors
    /// [`Error::Scene`], [`Error::Settings`], [`Error::Limits`], [`Error::DeviceLost`], [`Error::Accuracy`],
    /// [`Error::Interrupted`].
    pub fn render(&mut self, scene: &Scene, settings: &Settings) -> Result<Frame> {
        let start = Instant::now();
        let mut stages = Stages::default();
        let plan = Plan::new(scene, settings)?;
        self.admit(plan.kernel.method)?;
        let view = stages.time("view", || View::for_method(scene, plan.kernel.method))?;
        let pixels = view.record.width as usize * view.record.height as usize;
        let mut raw = Raw::new(&plan.kernel, pixels)?;
        let colors = scene.spheres.colors.as_deref();
        match &mut self.place {
            Place::Gpu(gpu) => {
                let kernel = crate::plan::Kernel { sharing: Sharing::on(&gpu.summary), ..plan.kernel };
                let input = Input { view: &view, colors, rays: &[] };
                gpu.run(&kernel, &input, &mut raw, &mut stages, &*self.go_on)?;
            }
            Place::Cpu => stages.time("trace", || cpu::render(&plan.kernel, &view, colors, &mut raw, &*self.go_on)),
        }
        if !(self.go_on)() {
            return Err(Error::Interrupted);
        }
        let hits = raw.hits();
        let buffers = stages.time("assemble", || raw.assemble(&view, &settings.aovs))?;
        let backend = if matches!(self.place, Place::Gpu(_)) { "gpu" } else { "cpu" };
        let report = Report {
            schema: "halfline-render",
            version: 1,
            halfline: env!("CARGO_PKG_VERSION"),
            spheres: scene.spheres.len() as u64,
            skipped: scene.skipped.total(),
            rays: pixels as u64,
            hits,
            adapter: self.adapter().to_owned(),
            driver: self.driver(),
            backend,
            method: plan.method,
            accuracy: plan.accuracy,
            shade: plan.kernel.shade.map(|shade| shade.name()),
            search: plan.search,
            certified: 0.0,
            settled: 0,
            bound: None,
            setup_ms: self.setup_ms,
            frame_ms: vec![milliseconds(start)],
            stages_ms: stages.into_map(),
            warnings: warnings(scene, hits),
        };
        Ok(Frame { width: view.record.width, height: view.record.height, buffers, report })
    }
}

/// What the picture does not show by itself.
fn warnings(scene: &Scene, hits: u64) -> Vec<String> {
    let mut warnings = scene.skipped.warnings();
    if scene.spheres.is_empty() {
        warnings.push("the scene has no spheres: the picture is background".into());
    } else if hits == 0 {
        let (n, e) = (scene.spheres.len(), scene.camera.eye);
        warnings.push(format!(
            "no ray hits any of the {n} spheres: the picture is background; the eye is at ({}, {}, {}), {}",
            e.x,
            e.y,
            e.z,
            scene.spheres.extent()
        ));
    }
    warnings
}
