//! The measurement: methods alternate on the same scenes, and their errors are computed with exact arithmetic.
//!
//! For each scene every method renders a first frame, then one more per round, so that other load on a shared machine
//! affects all methods alike. A frame contains typical buffers: colour, ids, distance and normal. The errors are found
//! in the first frame. The bounds of certified answers are checked with one more frame, which is not timed.

use super::record::{PlaceRecord, Record, Run, SceneRecord, units};
use super::score::{Score, Truths, one_eye};
use super::subject::{SceneGroup, SubjectKind};
use super::variant::Variant;
use glam::DVec3;
use halfline::error::{Error, Result};
use halfline::frame::{Aov, Frame};
use halfline::progress::Watch;
use halfline::quote::setting::{ADAPTER, BACKEND, METHODS, PATIENCE, SIZE};
use halfline::render::Renderer;
use halfline::scene::Scene;
use halfline::settings::{Backend, Settings, Tolerance};

pub use super::subject::Subject;

/// The buffers of every timed frame, besides the ids.
const AOVS: [Aov; 3] = [Aov::Color, Aov::Distance, Aov::Normal];

/// A method is not repeated further on a scene once its repeated frames took this long in total, milliseconds.
const ENOUGH_MS: f64 = 10_000.0;

/// The most rounds on the CPU reference path, which is slow.
const CPU_ROUNDS: u32 = 2;

/// Frames after the first, for a single scene and for each scene of a suite.
const ROUNDS: [u32; 2] = [5, 1];

/// The reference path's time is estimated from a small frame above this number of ray-sphere tests.
const LARGE: f64 = 1e8;

/// The factor by which the estimate's picture is smaller each way.
const SMALLER: u32 = 8;

/// The options of a measurement.
#[derive(Debug, Clone)]
pub struct Options {
    /// Auto measures both: the adapter, if there is one, and the CPU reference path.
    pub backend: Backend,
    /// The adapter, by index or part of its name.
    pub adapter: Option<String>,
    /// The methods.
    pub variants: Vec<Variant>,
    /// Frames after the first; `None` is 5 for a scene and 1 for each scene of a suite.
    pub rounds: Option<u32>,
    /// Promised relative error of certified distances.
    pub tolerance: Tolerance,
    /// A method that would take longer than this for one frame on the reference path is skipped there, seconds.
    pub patience: f64,
    /// The command line, for the record.
    pub command: String,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            backend: Backend::Auto,
            adapter: None,
            variants: Variant::all(),
            rounds: None,
            tolerance: Tolerance::default(),
            patience: 30.0,
            command: String::new(),
        }
    }
}

/// Measures `subject`; `say` receives progress messages; `watch` can cancel frames and exact answers.
///
/// # Errors
/// [`Error::Interrupted`] after a cancellation, [`Error::Settings`] for an orthographic camera, which the methods do
/// not support, and errors of [`Renderer::render`]. A method that the adapter refuses is part of the record, unless all
/// are refused.
pub fn measure(subject: &Subject, options: &Options, watch: &Watch, say: &mut dyn FnMut(&str)) -> Result<Record> {
    for scene in subject.cases.iter().flat_map(|case| &case.scenes) {
        scene.check()?;
        one_eye(scene)?;
    }
    let mut record = Record {
        schema: Record::SCHEMA.into(),
        version: Record::VERSION,
        halfline: env!("CARGO_PKG_VERSION").into(),
        subject: subject.name.clone(),
        command: options.command.clone(),
        tolerance: options.tolerance.relative(),
        units: units(),
        ..Record::default()
    };
    let mut stations = stations(options, watch, &mut record.warnings)?;
    for station in &mut stations {
        record.places.push(station.record()?);
    }
    let mut refusal = None;
    for case in &subject.cases {
        let Some(first) = case.scenes.first() else {
            record.warnings.push(format!("{}: its data file is missing, so it is skipped", case.name));
            continue;
        };
        say(&case.name);
        let index = record.scenes.len();
        let mut entries = entries(&stations, options);
        let mut hits = 0;
        for scene in &case.scenes {
            let turns = Turns { scene, kind: subject.kind, options, watch };
            hits += turns.run(&mut stations, &mut entries, say)?;
        }
        record.scenes.push(SceneRecord { hits, ..describe(case, first) });
        for entry in entries {
            refusal = entry.refusal.as_ref().map(ToString::to_string).or(refusal);
            record.runs.push(entry.finish(index));
        }
        record.warnings.extend_from_slice(&case.warnings);
    }
    match refusal {
        Some(problem) if record.runs.iter().all(|run| run.refused.is_some()) => {
            Err(Error::Accuracy { problem, mend: format!("use other {METHODS} or another {BACKEND}") })
        }
        _ => Ok(record),
    }
}

/// The description of a case before it is rendered.
fn describe(case: &SceneGroup, first: &Scene) -> SceneRecord {
    let size = |scene: &Scene| [scene.image.width, scene.image.height];
    let farness = |scene: &Scene| {
        let away = |(c, r): (&[f64; 3], &f64)| (DVec3::from_array(*c) - scene.camera.eye).length() / r;
        scene.spheres.centers.iter().zip(&scene.spheres.radii).map(away).reduce(f64::max)
    };
    let fingerprints: Vec<_> = case.scenes.iter().map(Scene::fingerprint).collect();
    SceneRecord {
        name: case.name.clone(),
        fingerprint: match &fingerprints[..] {
            [one] => one.clone(),
            many => blake3::hash(many.concat().as_bytes()).to_hex()[..32].to_owned(),
        },
        pictures: case.scenes.len() as u64,
        spheres: case.scenes.iter().map(|scene| scene.spheres.len() as u64).sum(),
        size: if case.scenes.iter().all(|scene| size(scene) == size(first)) { size(first) } else { [0, 0] },
        farthest: case.scenes.iter().filter_map(farness).reduce(f64::max).and_then(super::record::finite),
        hits: 0,
    }
}

/// A device with its renderer.
struct Station {
    renderer: Renderer,
    backend: Backend,
}

/// The devices that the options select.
fn stations(options: &Options, watch: &Watch, warnings: &mut Vec<String>) -> Result<Vec<Station>> {
    let open = |backend: Backend, adapter: Option<String>| {
        let settings = Settings { backend, adapter, ..Settings::default() };
        Ok(Station { renderer: Renderer::new(&settings)?.watched_by(watch.clone()), backend })
    };
    let gpu = || open(Backend::Gpu, options.adapter.clone());
    let cpu = || open(Backend::Cpu, None);
    match options.backend {
        Backend::Gpu => Ok(vec![gpu()?]),
        Backend::Cpu if options.adapter.is_some() => Err(Error::settings(
            format!("{BACKEND} cpu does not use an adapter"),
            format!("remove {ADAPTER} or use {BACKEND} gpu"),
        )),
        Backend::Cpu => Ok(vec![cpu()?]),
        Backend::Auto if options.adapter.is_none() && halfline::adapters()?.is_empty() => {
            warnings.push("no Vulkan, Metal or DX12 adapter was found: only the CPU path was measured".into());
            Ok(vec![cpu()?])
        }
        Backend::Auto => match gpu() {
            Err(Error::Adapter { problem, .. }) if options.adapter.is_none() => {
                warnings.push(format!("{problem}: only the CPU path was measured"));
                Ok(vec![cpu()?])
            }
            gpu => Ok(vec![gpu?, cpu()?]),
        },
    }
}

impl Station {
    fn record(&mut self) -> Result<PlaceRecord> {
        Ok(PlaceRecord {
            backend: self.backend.name().into(),
            adapter: self.renderer.adapter().into(),
            driver: self.renderer.driver(),
            self_test: self.renderer.verdict()?.map(|verdict| verdict.lines()).unwrap_or_default(),
            timestamps: self.renderer.has_clock(),
        })
    }
}

/// A method in a place, over the scenes of a case.
struct VariantRun {
    place: usize,
    variant: Variant,
    run: Run,
    refusal: Option<Error>,
    score: Option<Score>,
    rays: u64,
    proved: f64,
}

/// All methods in all places, in the order of their turns. Exact arithmetic is the same everywhere and runs on the CPU
/// only.
fn entries(stations: &[Station], options: &Options) -> Vec<VariantRun> {
    let entry = |place, variant| VariantRun {
        place,
        variant,
        run: Run::default(),
        refusal: None,
        score: None,
        rays: 0,
        proved: 0.0,
    };
    let last = stations.len().saturating_sub(1);
    let runs_at = |place: usize, variant: &Variant| *variant != Variant::Exact || place == last;
    (0..stations.len())
        .flat_map(|place| options.variants.iter().filter(move |c| runs_at(place, c)).map(move |c| entry(place, *c)))
        .collect()
}

impl VariantRun {
    /// The finished run.
    fn finish(self, scene: usize) -> Run {
        let Self { place, variant, run, refusal, score, rays, proved } = self;
        let refused = refusal.map(|error| error.to_string());
        let run = Run { scene, place, method: variant.name().into(), ..run };
        let Some(score) = score.filter(|_| refused.is_none()) else {
            // Results of some of its scenes are discarded.
            return Run { scene, place, method: run.method, refused, ..Run::default() };
        };
        let certified = (variant == Variant::Certified).then(|| proved / rays.max(1) as f64);
        Run { errors: score.errors(), of_bound: score.of_bound(), certified, ..run }
    }
}

/// One scene and its rounds.
struct Turns<'a> {
    scene: &'a Scene,
    kind: SubjectKind,
    options: &'a Options,
    watch: &'a Watch,
}

impl Turns<'_> {
    /// Renders first frames, then rounds. Returns the number of rays that hit.
    fn run(&self, stations: &mut [Station], entries: &mut [VariantRun], say: &mut dyn FnMut(&str)) -> Result<u64> {
        let truths = Truths::watched(self.scene, self.watch)?;
        for entry in entries.iter_mut().filter(|entry| entry.refusal.is_none()) {
            let station = &mut stations[entry.place];
            match self.first(station, entry, &truths) {
                Ok(ms) if self.kind == SubjectKind::Scene => {
                    say(&format!("  {} on the {}: {ms:.1} ms", entry.variant.name(), station.backend.name()));
                }
                Ok(_) => {}
                Err(error @ (Error::Accuracy { .. } | Error::Limits { .. })) => {
                    if self.kind == SubjectKind::Scene {
                        say(&format!("  {} on the {}: {error}", entry.variant.name(), station.backend.name()));
                    }
                    entry.refusal = Some(error);
                }
                Err(error) => return Err(error),
            }
        }
        let rounds = self.options.rounds.unwrap_or(ROUNDS[usize::from(self.kind != SubjectKind::Scene)]);
        let mut spent = vec![0.0; entries.len()];
        for round in 0..rounds {
            for (entry, spent) in entries.iter_mut().zip(&mut spent) {
                let station = &mut stations[entry.place];
                let slow = station.backend == Backend::Cpu && round >= CPU_ROUNDS;
                if entry.refusal.is_none() && entry.variant != Variant::Exact && !slow && *spent < ENOUGH_MS {
                    *spent += self.again(station, entry, round as usize)?;
                }
            }
        }
        Ok(truths.hits())
    }

    fn settings(&self, backend: Backend, variant: Variant, aovs: &[Aov]) -> Settings {
        variant.settings(backend, self.options.tolerance, aovs)
    }

    fn render(&self, station: &mut Station, variant: Variant, aovs: &[Aov]) -> Result<Frame> {
        station.renderer.render(self.scene, &self.settings(station.backend, variant, aovs))
    }

    /// Renders the first frame and computes its errors. Returns its time.
    fn first(&self, station: &mut Station, entry: &mut VariantRun, truths: &Truths) -> Result<f64> {
        self.expect_patience(station, entry.variant)?;
        let frame = self.render(station, entry.variant, &AOVS)?;
        let ms: f64 = frame.report.frame_ms.iter().sum();
        let run = &mut entry.run;
        run.first_ms = Some(run.first_ms.unwrap_or(0.0) + ms);
        entry.rays += frame.report.rays;
        let mut score = truths.score(&frame)?;
        match self.kind {
            SubjectKind::Scene => run.map = Some(score.map()),
            SubjectKind::Ladder => run.crop = Some(score.crop(self.scene, &frame)?),
            SubjectKind::Extremes => {}
        }
        if entry.variant == Variant::Certified {
            entry.proved += frame.report.certified * frame.report.rays as f64;
            run.settled = Some(run.settled.unwrap_or(0) + frame.report.settled);
            // The same answers with their bounds.
            let frame = self.render(station, entry.variant, &[Aov::Distance, Aov::Normal, Aov::Bound])?;
            score = truths.score(&frame)?;
        }
        if let Some(predicted) = &frame.report.predicted {
            score = score.given(predicted);
            entry.run.predicted = entry.run.predicted.worse(predicted, entry.score.is_none());
        }
        match &mut entry.score {
            Some(all) => all.add(score),
            none => *none = Some(score),
        }
        Ok(ms)
    }

    /// Renders one more frame for its time. Returns its time.
    fn again(&self, station: &mut Station, entry: &mut VariantRun, round: usize) -> Result<f64> {
        let mut frame = self.render(station, entry.variant, &AOVS)?;
        let report = std::mem::take(&mut frame.report);
        station.renderer.recycle(frame);
        let add = |samples: &mut Vec<f64>, ms: f64| match samples.get_mut(round) {
            Some(sample) => *sample += ms,
            None => samples.push(ms),
        };
        let ms = report.frame_ms.iter().sum();
        add(&mut entry.run.steady_ms, ms);
        if !report.kernel_ms.is_empty() {
            add(&mut entry.run.kernel_ms, report.kernel_ms.iter().sum());
        }
        Ok(ms)
    }

    /// Returns an error for a method that would take the reference path too long, estimated from a small picture.
    fn expect_patience(&self, station: &mut Station, variant: Variant) -> Result<()> {
        let Scene { image, spheres, .. } = self.scene;
        let tests = f64::from(image.width) * f64::from(image.height) * spheres.len() as f64;
        let alone = matches!(variant, Variant::Alone(_));
        if station.backend != Backend::Cpu || !alone || tests < LARGE {
            return Ok(());
        }
        let mut small = self.scene.clone();
        small.image.width = image.width.div_ceil(SMALLER);
        small.image.height = image.height.div_ceil(SMALLER);
        let share = f64::from(small.image.width) * f64::from(small.image.height) * spheres.len() as f64 / tests;
        let settings = self.settings(station.backend, variant, &AOVS);
        let ms: f64 = station.renderer.render(&small, &settings)?.report.frame_ms.iter().sum();
        let seconds = ms * 1e-3 / share;
        let patience = self.options.patience;
        if seconds <= patience {
            return Ok(());
        }
        let problem = format!("{} would take about {seconds:.0} s per frame on the CPU path", variant.name());
        Err(Error::Limits { problem, mend: format!("use a smaller {SIZE}, or a {PATIENCE} above {patience} s") })
    }
}
