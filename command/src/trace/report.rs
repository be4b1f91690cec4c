//! The report of `halfline trace`.

use halfline::error::Error;
use halfline::quote::{count, number};
use halfline::render::trace::echoes::Echoes;
use halfline::render::trace::{Hits, Occlusion, Tracer};
use halfline::scene::lidar::{Beam, Lidar};
use halfline::scene::{CUT, CutPlane, Cuts, REMOVED, Spheres};
use halfline::settings::Accuracy;
use halfline_files::read::rays::RayBlock;
use halfline_files::write::hits::CloudSummary;
use serde::Serialize;
use std::path::Path;

/// The counts of rays, hits and certainties while rays are traced, the time of each block, and the first fault.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Rows so far, the invalid ones included.
    pub(super) rays: u64,
    hits: u64,
    invalid: u64,
    certified: u64,
    settled: u64,
    /// The echoes; `None` where they are not measured.
    echoes: Option<u64>,
    trace_ms: Vec<f64>,
    /// The error of the first invalid row; `None` if all rows are valid.
    pub(super) fault: Option<Error>,
}

impl Tally {
    /// Counts the answers to a block whose tracing took so many milliseconds.
    pub(super) fn hits(&mut self, block: &RayBlock, hits: &Hits, trace_ms: f64) {
        let count = hits.id.iter().filter(|id| **id >= 0).count();
        self.add(block, count, &hits.certainty, trace_ms);
    }

    /// As [`Tally::hits`].
    pub(super) fn occlusion(&mut self, block: &RayBlock, occlusion: &Occlusion, trace_ms: f64) {
        let count = occlusion.hit.iter().filter(|hit| **hit != 0).count();
        self.add(block, count, &occlusion.certainty, trace_ms);
    }

    /// Counts the echoes of a block.
    pub(super) fn echoes(&mut self, echoes: &Echoes) {
        *self.echoes.get_or_insert(0) += echoes.all.len() as u64;
    }

    fn add(&mut self, block: &RayBlock, hits: usize, certainty: &[u8], trace_ms: f64) {
        self.trace_ms.push(trace_ms);
        let with = |value: u8| certainty.iter().filter(|certainty| **certainty == value).count() as u64;
        self.rays += block.rows() as u64;
        self.hits += hits as u64;
        self.invalid += block.invalid.len() as u64;
        self.certified += with(0);
        self.settled += with(1);
    }

    /// Warnings about the rays, in whole sentences.
    pub(super) fn warnings(&self, spheres: &Spheres) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Some(fault) = &self.fault {
            let first = match fault {
                Error::Scene { place, problem, .. } => format!("{place}: {problem}"),
                other => other.to_string(),
            };
            let (invalid, rays) = (self.invalid, count(self.rays, "ray"));
            warnings.push(format!(
                "{invalid} of {rays} are invalid and counted as misses, with certainty 255; the first: {first}"
            ));
        }
        let all_removed = spheres.cuts.as_ref().and_then(Cuts::warning);
        if self.rays == 0 {
            warnings.push("there are no rays".into());
        } else if all_removed.is_some() {
            warnings.extend(all_removed);
        } else if spheres.is_empty() {
            warnings.push("the scene has no spheres, so no ray hits anything".into());
        } else if self.hits == 0 {
            let which = match spheres.len() {
                1 => "the 1 sphere".to_owned(),
                n => format!("any of the {n} spheres"),
            };
            warnings.push(format!("no ray hits {which}; {}", spheres.extent()));
        }
        warnings
    }
}

/// The report; `--json` prints it as one object.
#[derive(Debug, Serialize)]
pub(super) struct TraceReport {
    /// `halfline-trace`.
    pub(super) schema: &'static str,
    /// Version of this object's shape.
    pub(super) version: u32,
    /// The program that wrote it.
    pub(super) halfline: &'static str,
    /// Spheres in the scene.
    pub(super) spheres: u64,
    /// Objects of the scene file that are not spheres and were left out.
    pub(super) skipped: u64,
    /// The planes that cut spheres.
    pub(super) cuts: Vec<CutPlane>,
    /// Spheres that a plane cuts.
    pub(super) spheres_cut: u64,
    /// Spheres that lie wholly beyond a plane.
    pub(super) spheres_removed: u64,
    /// Whether any hit was asked for instead of the nearest one.
    pub(super) any: bool,
    /// Rays, the invalid ones included.
    pub(super) rays: u64,
    /// Rays that hit something.
    pub(super) hits: u64,
    /// Invalid rays, which count as misses.
    pub(super) invalid: u64,
    /// Echoes; `None` where they are not measured.
    pub(super) echoes: Option<u64>,
    /// The scanner whose beams the rays are.
    pub(super) pattern: Option<Pattern>,
    /// The point cloud that was written.
    pub(super) cloud: Option<Cloud>,
    /// The adapter's name; `cpu` for the reference path.
    pub(super) adapter: String,
    /// Driver and its version; threads for the reference path.
    pub(super) driver: String,
    /// `gpu` or `cpu`.
    pub(super) backend: &'static str,
    /// The intersection method.
    pub(super) method: &'static str,
    /// `fast`, `certified` or `exact`.
    pub(super) accuracy: Accuracy,
    /// The search for candidate spheres: `all` tests every sphere, `tree` descends a tree of boxes.
    pub(super) search: &'static str,
    /// Share of all rays whose answer is proved without exact arithmetic.
    pub(super) certified: f64,
    /// Rays that were settled in exact arithmetic.
    pub(super) settled: u64,
    /// Time to set up the spheres, the tree included, milliseconds.
    pub(super) build_ms: f64,
    /// Time to trace each block of rays, milliseconds; reading and writing excluded.
    pub(super) trace_ms: Vec<f64>,
    /// Time from the first block to the complete file, milliseconds; reading and writing included.
    pub(super) elapsed_ms: f64,
    /// Valid rays per second of `trace_ms`.
    pub(super) rays_per_second: f64,
    /// Warnings, in whole sentences.
    pub(super) warnings: Vec<String>,
}

/// The size of a scan, and the properties of its beams.
#[derive(Debug, Serialize)]
pub(super) struct Pattern {
    rings: u32,
    azimuths: u32,
    /// The full angle of a beam in degrees; 0 for one ray.
    divergence: f64,
    /// The most echoes of a beam.
    returns: u8,
    /// The standard deviation of the range noise.
    noise: f64,
    /// The seed of the noise.
    seed: u32,
}

impl From<&Lidar> for Pattern {
    fn from(lidar: &Lidar) -> Self {
        let Beam { divergence, returns, noise, seed } = lidar.echoes().copied().unwrap_or_default();
        Self { rings: lidar.rings(), azimuths: lidar.azimuths(), divergence, returns, noise, seed }
    }
}

/// The counts of a point cloud that was written, and the rounding of its coordinates.
#[derive(Debug, Serialize)]
pub(super) struct Cloud {
    /// Points, one for each ray that hits, or for each echo.
    points: u64,
    /// Rays without a hit, or beams without an echo.
    left_out: u64,
    /// The largest difference between a coordinate in the file and the coordinate of the hit in f64.
    rounding: f64,
    #[serde(skip)]
    farthest: f64,
    #[serde(skip)]
    file: String,
    #[serde(skip)]
    has_echoes: bool,
}

/// The share of the farthest distance that coordinates may be rounded by without a warning: f32 does with coordinates as
/// large as that distance.
const ROUNDING: f64 = 1e-6;

impl Cloud {
    /// The cloud that was written to `path`.
    pub(super) fn new(path: &Path, summary: CloudSummary, has_echoes: bool) -> Self {
        let CloudSummary { points, left_out, rounding, farthest } = summary;
        Self { points, left_out, rounding, farthest, file: path.display().to_string(), has_echoes }
    }

    /// The number of points in the file and, if there are any, of rays without a hit, in words.
    pub(super) fn words(&self) -> String {
        let Self { points, left_out, file, .. } = self;
        let (ray, hit) = if self.has_echoes { ("beam", "an echo") } else { ("ray", "a hit") };
        match left_out {
            0 => format!("{file} has {}", count(*points, "point")),
            n => format!("{file} has {}; {} without {hit} left out", count(*points, "point"), count(*n, ray)),
        }
    }

    /// A warning if the file rounds coordinates by more than [`ROUNDING`] of the farthest distance; else `None`.
    pub(super) fn warning(&self) -> Option<String> {
        let Self { rounding, file, .. } = self;
        (*rounding > ROUNDING * self.farthest).then(|| {
            let rounding = number(*rounding, 2);
            format!("the coordinates in {file} are rounded by up to {rounding}; use .ply, whose coordinates are f64")
        })
    }
}

impl TraceReport {
    /// The report of what was counted.
    pub(super) fn new(spheres: &Spheres, tracer: &Tracer<'_>, tally: Tally, any: bool) -> Self {
        let cuts = spheres.cuts.as_ref();
        let counted = |flag: u8| cuts.map_or(0, |cuts| cuts.count(flag));
        let seconds = tally.trace_ms.iter().sum::<f64>() / 1e3;
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        Self {
            schema: "halfline-trace",
            version: 1,
            halfline: env!("CARGO_PKG_VERSION"),
            spheres: spheres.len() as u64,
            skipped: 0,
            cuts: cuts.map(|cuts| cuts.planes.clone()).unwrap_or_default(),
            spheres_cut: counted(CUT),
            spheres_removed: counted(REMOVED),
            any,
            rays: tally.rays,
            hits: tally.hits,
            invalid: tally.invalid,
            echoes: tally.echoes,
            pattern: None,
            cloud: None,
            adapter: tracer.adapter().to_owned(),
            driver: tracer.driver(),
            backend: if tracer.is_gpu() { "gpu" } else { "cpu" },
            method: tracer.method(),
            accuracy: tracer.accuracy(),
            search: tracer.search().name(),
            certified: share(tally.certified as f64, tally.rays as f64),
            settled: tally.settled,
            build_ms: tracer.build_ms(),
            trace_ms: tally.trace_ms,
            elapsed_ms: 0.0,
            rays_per_second: share((tally.rays - tally.invalid) as f64, seconds),
            warnings: Vec::new(),
        }
    }
}
