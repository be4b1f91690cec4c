//! The report of `halfline plan`: what would be compiled, uploaded and computed, why, and what is left out. No ray is
//! traced.

use crate::budget::Need;
use crate::certify::binned::BinnedScene;
use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::frame::report::Timings;
use crate::gpu::Gpu;
use crate::gpu::compose::compose;
use crate::gpu::dispatch::Input;
use crate::gpu::submission_budget::SubmissionBudget;
use crate::gpu::transfers::{Bands, BindingLimits, Entries, uploads};
use crate::intersect::Method;
use crate::intersect::predict::Prediction;
use crate::kernel::{Kernel, KernelOutput, Sharing};
use crate::memory::{self, Pool};
use crate::plan::Plan;
use crate::render::{Executor, FrameRays, Renderer};
use crate::scene::Scene;
use crate::settings::{Accuracy, Backend, Settings};
use crate::setup::FrameSetup;
use crate::shade::Shade;
use crate::view::ViewRecord;
use crate::view::raster::Raster;
use serde::Serialize;

/// What a scene requires; the command line prints it.
#[derive(Debug, Clone, Serialize)]
pub struct Explanation {
    /// `halfline-plan`.
    pub schema: &'static str,
    /// Version of this object's shape.
    pub version: u32,
    /// The program that planned.
    pub halfline: &'static str,
    /// Spheres in the scene.
    pub spheres: u64,
    /// Objects of the scene file that are not spheres and are left out.
    pub skipped: u64,
    /// Columns and rows of the full frame.
    pub size: [u32; 2],
    /// The window that would be rendered: x0, y0, x1, y1, ends excluded.
    pub window: [u32; 4],
    /// Viewing rays: the pixels of the window.
    pub rays: u64,
    /// Samples per pixel whose mean is the colour and the alpha: one more pass per sample, by a kernel that writes only
    /// ids and colour. 1 for pixel centres.
    pub samples: u32,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// The adapter's name; `cpu` for the reference path.
    pub adapter: String,
    /// `fast`, `certified` or `exact`.
    pub accuracy: &'static str,
    /// The intersection method, `certified` or `exact`.
    pub method: &'static str,
    /// Why this accuracy and this method.
    pub reason: String,
    /// The allowed relative error; promised where answers are certified.
    pub tolerance: f64,
    /// The predicted worst-case rounding error; `None` where answers are certified.
    pub predicted: Option<Prediction>,
    /// The arithmetic of the kernel and the source of its input.
    pub precision: String,
    /// How candidates are found.
    pub search: &'static str,
    /// Why this search.
    pub search_reason: String,
    /// How the spheres are binned into tiles; `None` where every ray tests all of them.
    pub staged: Option<BinnedCounts>,
    /// The shader files of the kernel, in order; empty where no kernel runs.
    pub kernel: Vec<ShaderFile>,
    /// What is uploaded.
    pub uploaded: Vec<DeviceBuffer>,
    /// The buffers that the kernel writes and the host reads back, for all pixels together.
    pub written: Vec<DeviceBuffer>,
    /// The number of dispatches: bands of rows that fit the adapter's bindings and half a second of a software adapter;
    /// a faster adapter takes fewer. 0 where no kernel runs.
    pub dispatches: u64,
    /// How many spheres fit.
    pub room: Room,
    /// The buffers of the finished frame.
    pub frame: Vec<Shown>,
    /// What this scene does not need, and why.
    pub left_out: Vec<LeftOut>,
    /// The warnings of the frame's report, as far as they are known before a ray is traced.
    pub warnings: Vec<String>,
}

/// Spheres by their place in the candidate lists.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BinnedCounts {
    /// In the tiles' lists: wholly in front of the eye.
    pub front: u64,
    /// Tested by every ray: around the eye, across its plane, or large and close.
    pub near: u64,
    /// Not uploaded, because no ray can hit them: behind the eye or outside the image.
    pub unseen: u64,
}

/// The number of spheres that fit for this image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Room {
    /// The number that the adapter's bindings hold of spheres distributed like these; `None` where no kernel runs.
    pub adapter: Option<u64>,
    /// The number that this machine's free memory holds, including the scene's own; `None` where the system does not
    /// report it.
    pub host: Option<u64>,
    /// Estimate of the memory that the frame needs besides the scene, bytes.
    pub needed: u64,
    /// Free memory, bytes.
    pub free: Option<u64>,
}

/// A WGSL file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ShaderFile {
    /// Its name under shaders/.
    pub file: &'static str,
    /// Its number of lines.
    pub lines: usize,
}

/// A buffer on the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct DeviceBuffer {
    /// Its name in WGSL.
    pub name: &'static str,
    /// Its size in bytes.
    pub bytes: u64,
}

/// A buffer of the frame.
#[derive(Debug, Clone, Serialize)]
pub struct Shown {
    /// Its name.
    pub name: &'static str,
    /// Rows, columns, and components if more than one.
    pub shape: Vec<u64>,
    /// The type of its values, as NumPy names it.
    pub dtype: &'static str,
    /// Its size in bytes.
    pub bytes: u64,
    /// Whether it is requested; ids are always present.
    pub asked: bool,
}

/// A part of the renderer that this scene does not need.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The part.
    pub what: &'static str,
    /// Why.
    pub why: String,
}

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
    /// Those of [`Renderer::render`] that need no ray.
    pub fn explain(&mut self, scene: &Scene, settings: &Settings) -> Result<Explanation> {
        let explained = |this: &mut Self, plan: Plan, rays: FrameRays| this.explanation(plan, rays, scene, settings);
        let (mut explanation, blocker) = self.planned(scene, settings, explained)?;
        explanation.warnings.extend(blocker);
        Ok(explanation)
    }

    /// The WGSL that would be compiled here for `scene`, with the name of its file above each part. On the CPU path it
    /// is the kernel of an adapter that does not share loads.
    ///
    /// # Errors
    /// Those of [`Renderer::explain`]; [`Error::Settings`] where no kernel runs.
    pub fn wgsl(&mut self, scene: &Scene, settings: &Settings) -> Result<String> {
        let composed = |this: &mut Self, plan: Plan, rays: FrameRays| {
            let raster = Raster::centres(rays.window);
            let setup = FrameSetup::new(plan, scene, settings, raster, &Pool::default(), &mut Timings::default())?;
            if !setup.is_traced() {
                let problem = "exact answers are computed on the CPU without a kernel";
                return Err(Error::settings(problem, "use another --accuracy or camera"));
            }
            Ok(compose(&this.kernel_of(&setup)).with_banners())
        };
        self.planned(scene, settings, composed).map(|(text, _)| text)
    }

    /// The kernel of a frame on this device.
    fn kernel_of(&self, setup: &FrameSetup) -> Kernel {
        let sharing = match &self.place {
            Executor::Gpu(gpu) => gpu.summary.sharing(),
            Executor::Cpu => Sharing::None,
        };
        Kernel { sharing, ..setup.plan.kernel }.with_generals(setup.has_nears())
    }

    /// The report of a plan on this device.
    fn explanation(&self, plan: Plan, rays: FrameRays, scene: &Scene, settings: &Settings) -> Result<Explanation> {
        let FrameRays { window, samples } = rays;
        let gpu = match &self.place {
            Executor::Gpu(gpu) => Some(&**gpu),
            Executor::Cpu => None,
        };
        let need = Need::of(&plan, settings, scene, window, gpu.is_some());
        let free = memory::free(&self.pool);
        let setup =
            FrameSetup::new(plan, scene, settings, Raster::centres(window), &Pool::default(), &mut Timings::default())?;
        let FrameSetup { plan, view, binned } = &setup;
        let kernel = self.kernel_of(&setup);
        let predicted = setup.predicted(scene);
        let mut warnings = self.passed_over().to_vec();
        warnings.extend(setup.warnings(scene, settings, predicted));
        let on_device = gpu.filter(|_| setup.is_traced());
        let mut work = on_device.map(|gpu| Work::of(&kernel, &setup, scene, gpu)).unwrap_or_default();
        if let (Some(raster), Some(sampled), Some(gpu)) = (samples, plan.sampled, on_device) {
            let plan = Plan { kernel: sampled, ..plan.clone() };
            let passes = FrameSetup::new(plan, scene, settings, raster, &Pool::default(), &mut Timings::default())?;
            work.add(Work::of(&self.kernel_of(&passes), &passes, scene, gpu), raster.count());
        }
        Ok(Explanation {
            schema: "halfline-plan",
            version: 1,
            halfline: env!("CARGO_PKG_VERSION"),
            spheres: scene.spheres.len() as u64,
            skipped: scene.skipped.total(),
            size: [view.record.width, view.record.height],
            window: [window.x0, window.y0, window.x1, window.y1],
            rays: view.record.pixels() as u64,
            samples: samples.map_or(1, |raster| raster.count()),
            backend: if gpu.is_some() { "gpu" } else { "cpu" },
            adapter: self.adapter().to_owned(),
            accuracy: plan.accuracy.name(),
            method: plan.method,
            precision: precision(plan, setup.is_traced()),
            tolerance: settings.promise().relative(),
            predicted,
            search: plan.search.name(),
            search_reason: plan.search_reason.to_owned(),
            staged: binned.as_ref().map(|binned| BinnedCounts::of(binned, scene)),
            frame: frame(settings, [window.width(), window.height()]),
            left_out: left_out(plan, &kernel, scene, settings, on_device.is_some()),
            reason: plan.reason.clone(),
            warnings,
            kernel: work.kernel,
            uploaded: work.uploaded,
            written: work.written,
            dispatches: work.dispatches,
            room: Room { adapter: work.spheres, host: free.map(|free| need.fitting(free)), needed: need.bytes(), free },
        })
    }
}

/// The work of a device.
#[derive(Default)]
struct Work {
    kernel: Vec<ShaderFile>,
    uploaded: Vec<DeviceBuffer>,
    written: Vec<DeviceBuffer>,
    dispatches: u64,
    spheres: Option<u64>,
}

impl Work {
    fn of(kernel: &Kernel, setup: &FrameSetup, scene: &Scene, gpu: &Gpu) -> Self {
        let pool = Pool::default();
        let (view, candidates) = (&setup.view, setup.candidates(scene, &pool));
        let parts = compose(kernel).files().into_iter().map(|(file, lines)| ShaderFile { file, lines }).collect();
        let pixels = view.record.pixels() as u64;
        let input = Input { view, colors: scene.spheres.colors.as_deref(), rays: &[], candidates, tree: None };
        let mut uploaded = vec![DeviceBuffer { name: "view", bytes: size_of::<ViewRecord>() as u64 }];
        let bytes = |(name, bytes): (&'static str, &[u8])| DeviceBuffer { name, bytes: bytes.len() as u64 };
        uploaded.extend(uploads(kernel, &input).into_iter().map(bytes));
        let written =
            KernelOutput::of(kernel).map(|out| DeviceBuffer { name: out.name, bytes: pixels * out.bytes() }).collect();
        let limits = BindingLimits::from(&gpu.limits);
        let mut cut = Bands::new(kernel, &input, limits);
        let bands: Vec<_> = std::iter::from_fn(|| cut.next(&SubmissionBudget::default())).collect();
        if let Some(candidates) = candidates {
            // The bands pass through the same buffers one after another.
            let mut of_lists: Vec<DeviceBuffer> = Vec::new();
            for (name, more) in bands.iter().flat_map(|band| Entries::of(&candidates, band).sizes(&candidates)) {
                match of_lists.iter_mut().find(|b| b.name == name) {
                    Some(b) => b.bytes += more,
                    None => of_lists.push(DeviceBuffer { name, bytes: more }),
                }
            }
            uploaded.extend(of_lists);
        }
        let spheres = Some(limits.spheres(kernel, &input));
        Self { kernel: parts, uploaded, written, dispatches: bands.len() as u64, spheres }
    }
}

impl Work {
    /// Adds `passes` passes of another kernel.
    fn add(&mut self, pass: Self, passes: u32) {
        let passes = u64::from(passes);
        let new = pass.kernel.into_iter().filter(|part| !self.kernel.contains(part)).collect::<Vec<_>>();
        self.kernel.extend(new);
        for (all, more) in [(&mut self.uploaded, pass.uploaded), (&mut self.written, pass.written)] {
            for DeviceBuffer { name, bytes } in more {
                match all.iter_mut().find(|b| b.name == name) {
                    Some(b) => b.bytes += passes * bytes,
                    None => all.push(DeviceBuffer { name, bytes: passes * bytes }),
                }
            }
        }
        self.dispatches += passes * pass.dispatches;
        self.spheres = self.spheres.min(pass.spheres);
    }
}

impl BinnedCounts {
    fn of(binned: &BinnedScene, scene: &Scene) -> Self {
        let (front, near) = (binned.seen, binned.generals.len() as u64);
        Self { front, near, unseen: scene.spheres.len() as u64 - front - near }
    }
}

fn precision(plan: &Plan, traced: bool) -> String {
    let host = "spheres are moved relative to the eye in f64 on the host";
    match (plan.accuracy, plan.kernel.method) {
        (Accuracy::Exact, _) => "double-double and exact integers on the CPU, every pixel".into(),
        _ if !traced => {
            "double-double and exact integers on the CPU, every pixel: f32 cannot bound this field of view".into()
        }
        (Accuracy::Certified, _) => {
            format!("f32 with an error bound; {host}; unsure pixels are settled in exact arithmetic")
        }
        (_, Method::Native64) => format!("f64; {host} and passed as sums of two f32"),
        (_, Method::DoubleFloat) => format!("sums of two f32 (48 bits), if the adapter passes the self-test; {host}"),
        _ => format!("f32; {host} and rounded once"),
    }
}

/// The buffers of the finished frame; ids are always among them.
fn frame(settings: &Settings, [width, height]: [u32; 2]) -> Vec<Shown> {
    let shown = |aov: &Aov| {
        let asked = settings.aovs.contains(aov);
        let mut shape = vec![u64::from(height), u64::from(width)];
        shape.extend((aov.channels() > 1).then_some(aov.channels() as u64));
        let one = match aov.dtype() {
            "float64" => 8,
            "uint8" => 1,
            _ => 4,
        };
        let bytes = one * shape.iter().product::<u64>();
        (asked || *aov == Aov::Id).then(|| Shown { name: aov.name(), shape, dtype: aov.dtype(), bytes, asked })
    };
    Aov::ALL.iter().filter_map(shown).collect()
}

/// What is left out because it is not requested or not in the scene.
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
    match plan.shade() {
        None => leave("shading", "no picture is requested"),
        Some(shade) if !shade.needs_colors() => leave("sphere colours", "this shading does not use them"),
        Some(_) if scene.spheres.colors.is_none() => {
            leave("sphere colours", "the scene has none; all spheres have the default colour");
        }
        Some(_) => {}
    }
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
        _ if !kernel.depth_interval => leave("width of the depth's interval", "no bound is requested"),
        _ => {}
    }
    if !kernel.is_wide() {
        leave("low parts of the spheres", "only methods beyond f32 read them");
    }
    if device && kernel.sharing == Sharing::None {
        leave("sharing of loads", "this adapter's hardware shares loads, or it has no suitable subgroups");
    }
    out
}
