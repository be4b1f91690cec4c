//! The measurement itself: methods take turns on the same scenes, and the judge tells how wrong each was.
//!
//! For each scene every method renders a first frame, then in rounds one more each, so that whatever disturbs a shared
//! machine disturbs all alike. A frame holds what users want: colour, ids, distance and normal. The errors are those
//! of the first frame. How far the bounds of certified answers hold is read from one more frame, which is not timed.

use super::contender::Contender;
use super::record::{PlaceRecord, Record, Run, SceneRecord, units};
use super::score::{Score, Truths, one_eye};
use super::suite::{extremes, ladder};
use crate::error::{Error, Result};
use crate::frame::{Aov, Frame};
use crate::gpu::device;
use crate::progress::Watch;
use crate::render::Renderer;
use crate::scene::Scene;
use crate::settings::{Backend, Search, Settings, Tolerance};
use glam::DVec3;
use std::path::Path;

/// What every timed frame holds, besides the ids.
const AOVS: [Aov; 3] = [Aov::Color, Aov::Distance, Aov::Normal];

/// A method is not repeated further on a scene once its repeated frames took so long together, milliseconds.
const ENOUGH_MS: f64 = 10_000.0;

/// Rounds on the CPU reference path, at most: it is there to be right, not to be fast.
const CPU_ROUNDS: u32 = 2;

/// Frames after the first, for one scene and for each of a suite's.
const ROUNDS: [u32; 2] = [5, 1];

/// The reference path's frame is estimated from a small one where this many ray-sphere tests are to be done.
const LARGE: f64 = 1e8;

/// The estimate's picture is so many times smaller each way.
const SMALLER: u32 = 8;

/// What is to be measured.
pub struct Subject {
    name: String,
    kind: Kind,
    cases: Vec<Case>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Scene,
    Extremes,
    Ladder,
}

/// Scenes under one name, measured together.
struct Case {
    name: String,
    scenes: Vec<Scene>,
}

impl Subject {
    /// One scene.
    #[must_use]
    pub fn scene(name: impl Into<String>, scene: Scene) -> Self {
        let name = name.into();
        Self { cases: vec![Case { name: name.clone(), scenes: vec![scene] }], name, kind: Kind::Scene }
    }

    /// The families of extremes; `folder` has the data of other people, if there is one.
    ///
    /// # Errors
    /// Those of [`extremes::Family::scenes`].
    pub fn extremes(folder: Option<&Path>) -> Result<Self> {
        let case = |family: &extremes::Family| {
            Ok(Case { name: family.name.into(), scenes: family.scenes(extremes::SEED, folder)? })
        };
        let cases: Vec<_> = extremes::FAMILIES.iter().map(case).collect::<Result<_>>()?;
        Ok(Self { name: "suite extremes".into(), kind: Kind::Extremes, cases })
    }

    /// The wall from near to far.
    ///
    /// # Errors
    /// Those of [`ladder::scene`].
    pub fn ladder() -> Result<Self> {
        let case = |rung: f64| Ok(Case { name: ladder::name(rung), scenes: vec![ladder::scene(rung)?] });
        let cases = ladder::RUNGS.into_iter().map(case).collect::<Result<_>>()?;
        Ok(Self { name: "suite ladder".into(), kind: Kind::Ladder, cases })
    }

    /// Other sizes for all its pictures.
    #[must_use]
    pub fn resized(mut self, [width, height]: [u32; 2]) -> Self {
        for scene in self.cases.iter_mut().flat_map(|case| &mut case.scenes) {
            (scene.image.width, scene.image.height) = (width, height);
        }
        self
    }
}

/// How it is to be measured.
#[derive(Debug, Clone)]
pub struct Options {
    /// Auto is both: the adapter, if there is one, and the CPU reference path.
    pub backend: Backend,
    /// Which adapter, by index or part of its name.
    pub adapter: Option<String>,
    /// Who takes part.
    pub contenders: Vec<Contender>,
    /// Frames after the first; `None` is 5 for a scene and 1 for each of a suite's.
    pub rounds: Option<u32>,
    /// Promised relative error of certified distances.
    pub tolerance: Tolerance,
    /// How candidates are found; where it is left open, forms alone ask all spheres.
    pub search: Search,
    /// A method that would take the reference path longer than this for one frame is left out there, seconds.
    pub patience: f64,
    /// The command line, for the record.
    pub command: String,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            backend: Backend::Auto,
            adapter: None,
            contenders: Contender::all(),
            rounds: None,
            tolerance: Tolerance::default(),
            search: Search::Auto,
            patience: 30.0,
            command: String::new(),
        }
    }
}

/// Measures `subject`; `say` hears a line now and then, `watch` every frame and the judge's.
///
/// # Errors
/// [`Error::Interrupted`] when `watch` says no, [`Error::Settings`] for an orthographic camera, which the methods do not
/// have, and those of [`Renderer::render`]; an adapter's refusal of a method is
/// part of the record, unless nothing else is.
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
            record.warnings.push(format!("{}: its data is not there and it is left out", case.name));
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
        record.warnings.extend(first.skipped.warnings());
    }
    match refusal {
        Some(problem) if record.runs.iter().all(|run| run.refused.is_some()) => {
            Err(Error::Accuracy { problem, mend: "choose other --methods or another --backend".into() })
        }
        _ => Ok(record),
    }
}

/// What is known of a case before it is rendered.
fn describe(case: &Case, first: &Scene) -> SceneRecord {
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

/// A place that computes.
struct Station {
    renderer: Renderer,
    backend: Backend,
}

/// Where the options want it measured.
fn stations(options: &Options, watch: &Watch, warnings: &mut Vec<String>) -> Result<Vec<Station>> {
    let open = |backend: Backend, adapter: Option<String>| {
        let settings = Settings { backend, adapter, ..Settings::default() };
        Ok(Station { renderer: Renderer::new(&settings)?.watched_by(watch.clone()), backend })
    };
    let gpu = || open(Backend::Gpu, options.adapter.clone());
    let cpu = || open(Backend::Cpu, None);
    match options.backend {
        Backend::Gpu => Ok(vec![gpu()?]),
        Backend::Cpu if options.adapter.is_some() => {
            Err(Error::settings("the cpu backend has no adapters", "leave out --adapter or use --backend gpu"))
        }
        Backend::Cpu => Ok(vec![cpu()?]),
        Backend::Auto if options.adapter.is_none() && device::find()?.is_empty() => {
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

/// One contender in one place, over the scenes of a case.
struct Entry {
    place: usize,
    contender: Contender,
    run: Run,
    refusal: Option<Error>,
    score: Option<Score>,
    rays: u64,
    proved: f64,
}

/// Everyone who takes part, in the order of their turns. The exact way is the same everywhere and runs on the CPU.
fn entries(stations: &[Station], options: &Options) -> Vec<Entry> {
    let entry = |place, contender| Entry {
        place,
        contender,
        run: Run::default(),
        refusal: None,
        score: None,
        rays: 0,
        proved: 0.0,
    };
    let last = stations.len().saturating_sub(1);
    let runs_at = |place: usize, contender: &Contender| *contender != Contender::Exact || place == last;
    (0..stations.len())
        .flat_map(|place| options.contenders.iter().filter(move |c| runs_at(place, c)).map(move |c| entry(place, *c)))
        .collect()
}

impl Entry {
    /// The record of it all.
    fn finish(self, scene: usize) -> Run {
        let Self { place, contender, run, refusal, score, rays, proved } = self;
        let refused = refusal.map(|error| error.to_string());
        let run = Run { scene, place, method: contender.name().into(), ..run };
        let Some(score) = score.filter(|_| refused.is_none()) else {
            // What some of its scenes gave is no result.
            return Run { scene, place, method: run.method, refused, ..Run::default() };
        };
        let certified = (contender == Contender::Certified).then(|| proved / rays.max(1) as f64);
        Run { errors: score.errors(), of_bound: score.of_bound(), certified, ..run }
    }
}

/// One scene and its turns.
struct Turns<'a> {
    scene: &'a Scene,
    kind: Kind,
    options: &'a Options,
    watch: &'a Watch,
}

impl Turns<'_> {
    /// Lets everyone render: first frames, then rounds. How many rays hit.
    fn run(&self, stations: &mut [Station], entries: &mut [Entry], say: &mut dyn FnMut(&str)) -> Result<u64> {
        let truths = Truths::watched(self.scene, self.watch)?;
        for entry in entries.iter_mut().filter(|entry| entry.refusal.is_none()) {
            let station = &mut stations[entry.place];
            match self.first(station, entry, &truths) {
                Ok(ms) if self.kind == Kind::Scene => {
                    say(&format!("  {} on the {}: {ms:.1} ms", entry.contender.name(), station.backend.name()));
                }
                Ok(_) => {}
                Err(error @ (Error::Accuracy { .. } | Error::Limits { .. })) => {
                    if self.kind == Kind::Scene {
                        say(&format!("  {} on the {}: {error}", entry.contender.name(), station.backend.name()));
                    }
                    entry.refusal = Some(error);
                }
                Err(error) => return Err(error),
            }
        }
        let rounds = self.options.rounds.unwrap_or(ROUNDS[usize::from(self.kind != Kind::Scene)]);
        let mut spent = vec![0.0; entries.len()];
        for round in 0..rounds {
            for (entry, spent) in entries.iter_mut().zip(&mut spent) {
                let station = &mut stations[entry.place];
                let slow = station.backend == Backend::Cpu && round >= CPU_ROUNDS;
                if entry.refusal.is_none() && entry.contender != Contender::Exact && !slow && *spent < ENOUGH_MS {
                    *spent += self.again(station, entry, round as usize)?;
                }
            }
        }
        Ok(truths.hits())
    }

    fn settings(&self, backend: Backend, contender: Contender, aovs: &[Aov]) -> Settings {
        contender.settings(backend, self.options.tolerance, self.options.search, aovs)
    }

    fn render(&self, station: &mut Station, contender: Contender, aovs: &[Aov]) -> Result<Frame> {
        station.renderer.render(self.scene, &self.settings(station.backend, contender, aovs))
    }

    /// The first frame: it is judged. How long it took.
    fn first(&self, station: &mut Station, entry: &mut Entry, truths: &Truths) -> Result<f64> {
        self.expect_patience(station, entry.contender)?;
        let frame = self.render(station, entry.contender, &AOVS)?;
        let ms: f64 = frame.report.frame_ms.iter().sum();
        let run = &mut entry.run;
        run.first_ms = Some(run.first_ms.unwrap_or(0.0) + ms);
        entry.rays += frame.report.rays;
        let mut score = truths.score(&frame)?;
        match self.kind {
            Kind::Scene => run.map = Some(score.map()),
            Kind::Ladder => run.crop = Some(score.crop(self.scene, &frame)?),
            Kind::Extremes => {}
        }
        if entry.contender == Contender::Certified {
            entry.proved += frame.report.certified * frame.report.rays as f64;
            run.settled = Some(run.settled.unwrap_or(0) + frame.report.settled);
            // The same answers with their bounds.
            let frame = self.render(station, entry.contender, &[Aov::Distance, Aov::Normal, Aov::Bound])?;
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

    /// One more frame, timed and forgotten. How long it took.
    fn again(&self, station: &mut Station, entry: &mut Entry, round: usize) -> Result<f64> {
        let mut frame = self.render(station, entry.contender, &AOVS)?;
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

    /// Refuses what would keep the reference path busy for too long: a small picture tells.
    fn expect_patience(&self, station: &mut Station, contender: Contender) -> Result<()> {
        let Scene { image, spheres, .. } = self.scene;
        let tests = f64::from(image.width) * f64::from(image.height) * spheres.len() as f64;
        let alone = matches!(contender, Contender::Alone(_)) && self.options.search != Search::Tiles;
        if station.backend != Backend::Cpu || !alone || tests < LARGE {
            return Ok(());
        }
        let mut small = self.scene.clone();
        small.image.width = image.width.div_ceil(SMALLER);
        small.image.height = image.height.div_ceil(SMALLER);
        let share = f64::from(small.image.width) * f64::from(small.image.height) * spheres.len() as f64 / tests;
        let settings = self.settings(station.backend, contender, &AOVS);
        let ms: f64 = station.renderer.render(&small, &settings)?.report.frame_ms.iter().sum();
        let seconds = ms * 1e-3 / share;
        let patience = self.options.patience;
        if seconds <= patience {
            return Ok(());
        }
        let problem = format!("{} would take the CPU path about {seconds:.0} s a frame", contender.name());
        Err(Error::Limits { problem, mend: format!("give a smaller --size, or a --patience above {patience} s") })
    }
}
