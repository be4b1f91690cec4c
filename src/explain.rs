//! The report of `halfline plan`: what would be compiled, uploaded and computed, why, and what is left out. Nothing is rendered.

use crate::budget::Need;
use crate::certify::binned::BinnedScene;
use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::gpu::Gpu;
use crate::gpu::compose::compose;
use crate::gpu::dispatch::Input;
use crate::gpu::submission_budget::SubmissionBudget;
use crate::gpu::transfers::{Bands, BindingLimits, Entries, uploads};
use crate::intersect::Method;
use crate::kernel::{Kernel, KernelOutput, Sharing};
use crate::memory::{self, Pool};
use crate::plan::Plan;
use crate::predict::Prediction;
use crate::raster::Raster;
use crate::render::{Place, Rays, Renderer};
use crate::report::Timings;
use crate::scene::Scene;
use crate::settings::{Accuracy, Backend, Settings};
use crate::setup::FrameSetup;
use crate::shade::Shade;
use crate::view::ViewRecord;
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
    /// Things in the scene file that are no spheres and are left out.
    pub skipped: u64,
    /// Columns and rows of the full frame.
    pub size: [u32; 2],
    /// Which part of it would be rendered: x0, y0, x1, y1, the ends excluded.
    pub window: [u32; 4],
    /// Viewing rays: pixels of that part.
    pub rays: u64,
    /// Samples of each pixel that colour and alpha would be the means of: as many passes more, by the kernel's twin that asks
    /// samples and writes nothing but ids and colour. 1 where they are the answers of pixel centres.
    pub samples: u32,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// The adapter's name; `cpu` for the reference path.
    pub adapter: String,
    /// `fast`, `certified` or `exact`.
    pub accuracy: &'static str,
    /// The form of the quadratic, `certified` or `exact`.
    pub method: &'static str,
    /// Why these two.
    pub reason: String,
    /// What is allowed, or promised where answers are certified.
    pub tolerance: f64,
    /// What rounding can do at worst; `None` where answers are certified.
    pub predicted: Option<Prediction>,
    /// The arithmetic of the kernel, and where it comes from.
    pub precision: String,
    /// How candidates are found.
    pub search: &'static str,
    /// Why so.
    pub search_reason: String,
    /// How the spheres are binned into tiles; `None` where every ray tests all of them.
    pub staged: Option<Staged>,
    /// The files that make up the kernel, in their order; empty where no kernel runs.
    pub kernel: Vec<Part>,
    /// What is uploaded.
    pub uploaded: Vec<Binding>,
    /// What the kernel writes and the host reads back, for all pixels together.
    pub written: Vec<Binding>,
    /// In how many dispatches: bands of rows that fit the adapter's bindings and half a second of software; a faster adapter
    /// takes fewer. 0 where no kernel runs.
    pub dispatches: u64,
    /// How much there is room for.
    pub room: Room,
    /// What the frame holds when it is done.
    pub frame: Vec<Shown>,
    /// What is not needed, and why.
    pub left_out: Vec<LeftOut>,
    /// The warnings of the frame's report, as far as they are known before a ray is traced.
    pub warnings: Vec<String>,
}

/// Spheres by what becomes of them.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Staged {
    /// Wholly in front of the eye, in the lists of tiles.
    pub front: u64,
    /// Around the eye, across its plane, or large and close: asked by every ray.
    pub near: u64,
    /// Behind the eye or beside the image: no ray meets them, none is uploaded.
    pub unseen: u64,
}

/// How many spheres there is room for, for this image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Room {
    /// What the adapter's bindings can hold of spheres that lie like these; `None` where no kernel runs.
    pub adapter: Option<u64>,
    /// What this machine's memory can hold now, the scene's own included; `None` where the system does not tell.
    pub host: Option<u64>,
    /// What the frame needs of that memory besides the scene, bytes: an estimate.
    pub needed: u64,
    /// What is free of it, bytes.
    pub free: Option<u64>,
}

/// A file of WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Part {
    /// Its name under shaders/.
    pub file: &'static str,
    /// Its lines.
    pub lines: usize,
}

/// A buffer on the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Binding {
    /// Its name in WGSL.
    pub name: &'static str,
    /// Its size.
    pub bytes: u64,
}

/// A buffer of the frame.
#[derive(Debug, Clone, Serialize)]
pub struct Shown {
    /// Its name.
    pub name: &'static str,
    /// Rows, columns, and components if more than one.
    pub shape: Vec<u64>,
    /// The type of its values, by NumPy's name.
    pub dtype: &'static str,
    /// Its size.
    pub bytes: u64,
    /// Whether it was asked for; ids are always there.
    pub asked: bool,
}

/// Something that this scene does not need.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// What.
    pub what: &'static str,
    /// Why.
    pub why: String,
}

/// Explains what `scene` requires on the adapter that `settings` choose, or on the CPU path if there is none.
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
    /// Explains what rendering `scene` would do here. It takes the decisions of [`Renderer::render`], the self-test of the
    /// adapter's arithmetic among them, and traces no ray.
    ///
    /// # Errors
    /// Those of [`Renderer::render`] that need no ray.
    pub fn explain(&mut self, scene: &Scene, settings: &Settings) -> Result<Explanation> {
        let explained = |this: &mut Self, plan: Plan, rays: Rays| this.explanation(plan, rays, scene, settings);
        let (mut explanation, blocker) = self.planned(scene, settings, explained)?;
        explanation.warnings.extend(blocker);
        Ok(explanation)
    }

    /// The WGSL that would be compiled here for the pixels of `scene`, the name of its file above each part. On the CPU path it
    /// is what an adapter would get that does not share loads.
    ///
    /// # Errors
    /// Those of [`Renderer::explain`]; [`Error::Settings`] where no kernel runs.
    pub fn wgsl(&mut self, scene: &Scene, settings: &Settings) -> Result<String> {
        let composed = |this: &mut Self, plan: Plan, rays: Rays| {
            let raster = Raster::centres(rays.window);
            let setup = FrameSetup::new(plan, scene, settings, raster, &Pool::default(), &mut Timings::default())?;
            if !setup.is_traced() {
                let problem = "these answers are made in exact arithmetic on the CPU: there is no kernel";
                return Err(Error::settings(problem, "use another --accuracy or camera"));
            }
            Ok(compose(&this.kernel_of(&setup)).with_banners())
        };
        self.planned(scene, settings, composed).map(|(text, _)| text)
    }

    /// The kernel of a frame, where it is computed.
    fn kernel_of(&self, setup: &FrameSetup) -> Kernel {
        let sharing = match &self.place {
            Place::Gpu(gpu) => gpu.summary.sharing(),
            Place::Cpu => Sharing::None,
        };
        Kernel { sharing, ..setup.plan.kernel }.with_generals(setup.has_nears())
    }

    /// What is done of this plan, where it was decided to do it.
    fn explanation(&self, plan: Plan, rays: Rays, scene: &Scene, settings: &Settings) -> Result<Explanation> {
        let Rays { window, samples } = rays;
        let gpu = match &self.place {
            Place::Gpu(gpu) => Some(&**gpu),
            Place::Cpu => None,
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
            staged: binned.as_ref().map(|binned| Staged::of(binned, scene)),
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

/// What the device would be given to do.
#[derive(Default)]
struct Work {
    kernel: Vec<Part>,
    uploaded: Vec<Binding>,
    written: Vec<Binding>,
    dispatches: u64,
    spheres: Option<u64>,
}

impl Work {
    fn of(kernel: &Kernel, setup: &FrameSetup, scene: &Scene, gpu: &Gpu) -> Self {
        let pool = Pool::default();
        let (view, candidates) = (&setup.view, setup.candidates(scene, &pool));
        let parts = compose(kernel).files().into_iter().map(|(file, lines)| Part { file, lines }).collect();
        let pixels = view.record.pixels() as u64;
        let input = Input { view, colors: scene.spheres.colors.as_deref(), rays: &[], candidates, tree: None };
        let mut uploaded = vec![Binding { name: "view", bytes: size_of::<ViewRecord>() as u64 }];
        let bytes = |(name, bytes): (&'static str, &[u8])| Binding { name, bytes: bytes.len() as u64 };
        uploaded.extend(uploads(kernel, &input).into_iter().map(bytes));
        let written =
            KernelOutput::of(kernel).map(|out| Binding { name: out.name, bytes: pixels * out.bytes() }).collect();
        let limits = BindingLimits::from(&gpu.limits);
        let mut cut = Bands::new(kernel, &input, limits);
        let bands: Vec<_> = std::iter::from_fn(|| cut.next(&SubmissionBudget::default())).collect();
        if let Some(candidates) = candidates {
            // Band by band into the same buffers: all of it passes through.
            let mut of_lists: Vec<Binding> = Vec::new();
            for (name, more) in bands.iter().flat_map(|band| Entries::of(&candidates, band).sizes(&candidates)) {
                match of_lists.iter_mut().find(|b| b.name == name) {
                    Some(b) => b.bytes += more,
                    None => of_lists.push(Binding { name, bytes: more }),
                }
            }
            uploaded.extend(of_lists);
        }
        let spheres = Some(limits.spheres(kernel, &input));
        Self { kernel: parts, uploaded, written, dispatches: bands.len() as u64, spheres }
    }
}

impl Work {
    /// So many passes of another kernel come on top.
    fn add(&mut self, pass: Self, passes: u32) {
        let passes = u64::from(passes);
        let new = pass.kernel.into_iter().filter(|part| !self.kernel.contains(part)).collect::<Vec<_>>();
        self.kernel.extend(new);
        for (all, more) in [(&mut self.uploaded, pass.uploaded), (&mut self.written, pass.written)] {
            for Binding { name, bytes } in more {
                match all.iter_mut().find(|b| b.name == name) {
                    Some(b) => b.bytes += passes * bytes,
                    None => all.push(Binding { name, bytes: passes * bytes }),
                }
            }
        }
        self.dispatches += passes * pass.dispatches;
        self.spheres = self.spheres.min(pass.spheres);
    }
}

impl Staged {
    fn of(binned: &BinnedScene, scene: &Scene) -> Self {
        let (front, near) = (binned.seen, binned.generals.len() as u64);
        Self { front, near, unseen: scene.spheres.len() as u64 - front - near }
    }
}

fn precision(plan: &Plan, traced: bool) -> String {
    let host = "the world is moved to the eye in f64 on the host";
    match (plan.accuracy, plan.kernel.method) {
        (Accuracy::Exact, _) => "double-double and exact integers on the CPU, every pixel".into(),
        _ if !traced => "double-double and exact integers on the CPU, every pixel: f32 cannot bound this lens".into(),
        (Accuracy::Certified, _) => {
            format!("f32 with a bound of its error; {host}; what stays open is settled in exact arithmetic")
        }
        (_, Method::Native64) => format!("f64; {host} and handed over as sums of two f32"),
        (_, Method::DoubleFloat) => format!("sums of two f32, 48 bits, where the self-test allows it; {host}"),
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

/// What is not requested or not in the scene, and what is therefore left out.
fn left_out(plan: &Plan, kernel: &Kernel, scene: &Scene, settings: &Settings, device: bool) -> Vec<LeftOut> {
    let mut out = Vec::new();
    let mut leave = |what, why: &str| out.push(LeftOut { what, why: why.to_owned() });
    if !device {
        let why = match plan.accuracy {
            Accuracy::Exact => "exact answers are made on the CPU",
            Accuracy::Certified if settings.backend != Backend::Cpu => "the CPU does this frame",
            _ => "the CPU path runs the kernels' twins",
        };
        leave("device", why);
    }
    match plan.shade() {
        None => leave("shading", "no picture is asked for"),
        Some(shade) if !shade.needs_colors() => leave("sphere colours", "this shading does not show them"),
        Some(_) if scene.spheres.colors.is_none() => {
            leave("sphere colours", "the scene has none: one constant for all");
        }
        Some(_) => {}
    }
    if !kernel.t {
        leave("t", "no distance, depth or position is asked for");
    }
    if !kernel.normal {
        match plan.shade() {
            None | Some(Shade::Flat) => leave("normals", "nobody asked, and nothing is shaded by them"),
            Some(_) => leave("normal buffer", "nobody asked: normals are made for shading and not kept"),
        }
    }
    match plan.accuracy {
        Accuracy::Fast => leave("certificate", "the accuracy is fast"),
        _ if !kernel.depth_interval => leave("width of the depth's interval", "no bound is asked for"),
        _ => {}
    }
    if !kernel.is_wide() {
        leave("low parts of the spheres", "only arithmetic beyond f32 reads them");
    }
    if device && kernel.sharing == Sharing::None {
        leave("sharing of loads", "this adapter loads a shared address once by itself, or has no fitting subgroups");
    }
    out
}
