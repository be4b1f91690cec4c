//! What a measurement leaves: one record with units and raw samples. Tables, plots and reports read nothing else.

use crate::error::{Error, Place, Result};
use crate::predict::Prediction;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole measurement; `records.json` is this.
///
/// Numbers that may be infinite (an unbounded prediction, say) are `None` where they are, since JSON has no infinity.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// `halfline-measure`.
    pub schema: String,
    /// Version of this object's shape.
    pub version: u32,
    /// The program that measured.
    pub halfline: String,
    /// What was measured: the scene's file name, or `suite extremes`, `suite ladder`.
    pub subject: String,
    /// The command line that repeats it.
    pub command: String,
    /// Relative error of the distance that certified answers promised.
    pub tolerance: f64,
    /// The unit of each number, by the name of its field.
    pub units: BTreeMap<String, String>,
    /// Where it ran: the adapter, and the CPU reference path.
    pub places: Vec<PlaceRecord>,
    /// What was rendered.
    pub scenes: Vec<SceneRecord>,
    /// Each method on each scene in each place.
    pub runs: Vec<Run>,
    /// What to be careful about, in whole sentences.
    pub warnings: Vec<String>,
}

/// Something that computes frames.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PlaceRecord {
    /// `gpu` or `cpu`.
    pub backend: String,
    /// The adapter's name; `cpu` for the reference path.
    pub adapter: String,
    /// Driver and its version; threads for the reference path.
    pub driver: String,
    /// What the self-test found, a line each; empty for the reference path.
    pub self_test: Vec<String>,
    /// Whether kernels were timed by the device's own clock beside the wall clock.
    pub timestamps: bool,
}

/// A scene that was measured, or a family of scenes that were measured together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// File name, family of the extremes, or rung of the ladder.
    pub name: String,
    /// BLAKE3 of the scene's content.
    pub fingerprint: String,
    /// How many pictures go by this name: 1, but for a family of the extremes. Times are then sums over all.
    pub pictures: u64,
    /// Spheres, in all pictures.
    pub spheres: u64,
    /// Columns and rows of pixels; zeros where the pictures of a family differ.
    pub size: [u32; 2],
    /// Largest distance from the eye to a sphere's centre, in its radii; `None` without spheres.
    pub farthest: Option<f64>,
    /// Rays that hit something, exactly.
    pub hits: u64,
}

/// One method on one scene in one place.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Index into `scenes`.
    pub scene: usize,
    /// Index into `places`.
    pub place: usize,
    /// The form of the quadratic, `certified` or `exact`.
    pub method: String,
    /// Why it did not run, if it did not; everything below is then empty.
    pub refused: Option<String>,
    /// Whole-frame wall time of the first frame, milliseconds: with compiling.
    pub first_ms: Option<f64>,
    /// Whole-frame wall times after that, milliseconds; methods take turns.
    pub steady_ms: Vec<f64>,
    /// Kernel times of the same frames by the device's clock, milliseconds; empty where it offers none.
    pub kernel_ms: Vec<f64>,
    /// How wrong it was, against exact arithmetic.
    pub errors: Errors,
    /// Share of the pixels that f32 proved; `None` where nothing is proved.
    pub certified: Option<f64>,
    /// Pixels settled in better arithmetic; `None` likewise.
    pub settled: Option<u64>,
    /// Largest share that a true error of the distance took of its stated bound; `None` without bounds.
    pub of_bound: Option<f64>,
    /// What was predicted before rendering.
    pub predicted: Predicted,
    /// Where it was wrong; scenes of their own only.
    pub map: Option<Map>,
    /// The middle of the picture; rungs of the ladder only.
    pub crop: Option<Crop>,
}

/// A-priori bounds of a method on a scene; `None` is unbounded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// How far outlines may be off, in radii.
    pub outline: Option<f64>,
    /// How far the distance may be off, relative to itself.
    pub distance: Option<f64>,
}

impl Predicted {
    /// The worse of both; `first` if nothing was predicted yet.
    pub(crate) fn worse(self, other: &Prediction, first: bool) -> Self {
        let worse = |a: Option<f64>, b: f64| match (first, a) {
            (true, _) => finite(b),
            (false, a) => a.and_then(|a| finite(a.max(b))),
        };
        Self { outline: worse(self.outline, other.outline), distance: worse(self.distance, other.distance) }
    }
}

/// Errors of one frame against exact arithmetic.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Pixels judged.
    pub pixels: u64,
    /// A sphere is shown where the ray hits none.
    pub false_hit: u64,
    /// None is shown where the ray hits one.
    pub false_miss: u64,
    /// Another sphere than the nearest is shown.
    pub wrong_sphere: u64,
    /// The right sphere, but its other root, or no root at all.
    pub wrong_root: u64,
    /// How far outlines were off: the change of radius, relative to it, that would make every wrong pixel right.
    /// `None` is unbounded.
    pub outline: Option<f64>,
    /// |t - t*| / t* where the right sphere is shown, and where a wrong one is as near.
    pub relative: Spread,
    /// |t - t*| in ulps of f32 at t*, right sphere and root.
    pub ulp: Spread,
    /// |t - t*| |d| in radii of the sphere, right sphere and root.
    pub radii: Spread,
    /// Angle between the normals in degrees, right sphere and root.
    pub normal: Spread,
}

impl Errors {
    /// Pixels that show what is not there.
    #[must_use]
    pub fn wrong(&self) -> u64 {
        self.false_hit + self.false_miss + self.wrong_sphere + self.wrong_root
    }

    /// The same as a share of all.
    #[must_use]
    pub fn wrong_share(&self) -> f64 {
        self.wrong() as f64 / self.pixels.max(1) as f64
    }
}

/// A distribution in three numbers; zeros where there was nothing to measure, `None` for what is infinite.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Half of them are no larger.
    pub median: Option<f64>,
    /// 99 of 100 are no larger.
    pub p99: Option<f64>,
    /// None is larger.
    pub max: Option<f64>,
}

/// Errors over the image, in square cells of pixels, row by row.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// Pixels along the side of a cell.
    pub cell: u32,
    /// Columns and rows of cells; the last ones may stand over.
    pub size: [u32; 2],
    /// Largest relative error of the distance in each cell, right sphere and root, to three digits; 0 where nothing is
    /// hit.
    pub error: Vec<f32>,
    /// Wrong pixels in each cell.
    pub wrong: Vec<u32>,
}

/// A piece of the rendered picture.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Crop {
    /// Columns and rows.
    pub size: [u32; 2],
    /// One letter a pixel, row by row: `0` to `9` and `a` to `f` for a brightness, dark to light; `.` for background.
    pub shade: String,
    /// One letter a pixel: `-` right, `h` false hit, `m` false miss, `s` wrong sphere, `r` wrong root.
    pub verdict: String,
}

impl Record {
    /// What `schema` says.
    pub const SCHEMA: &'static str = "halfline-measure";
    /// What `version` says.
    pub const VERSION: u32 = 1;

    /// The record in the text of a `records.json`.
    ///
    /// # Errors
    /// [`Error::Scene`] at the file `name` for what is no such record.
    pub fn from_json(text: &str, name: &str) -> Result<Self> {
        let foreign =
            |problem: String| Error::scene(Place::file(name), problem, "give a records.json of halfline measure");
        let record: Self = serde_json::from_str(text).map_err(|e| foreign(e.to_string()))?;
        match (record.schema.as_str(), record.version) {
            (Self::SCHEMA, Self::VERSION) => Ok(record),
            (schema, version) => Err(foreign(format!("it is a {schema:?} of version {version}"))),
        }
    }
}

/// The units of a record's numbers, by the names of the fields.
pub(crate) fn units() -> BTreeMap<String, String> {
    let unit = |(name, unit): (&str, &str)| (name.to_owned(), unit.to_owned());
    [
        ("tolerance", "relative to the distance"),
        ("farthest", "radii"),
        ("hits", "pixels"),
        ("first_ms", "milliseconds, wall clock"),
        ("steady_ms", "milliseconds, wall clock"),
        ("kernel_ms", "milliseconds, clock of the device"),
        ("errors.false_hit", "pixels"),
        ("errors.false_miss", "pixels"),
        ("errors.wrong_sphere", "pixels"),
        ("errors.wrong_root", "pixels"),
        ("errors.outline", "radii of the sphere"),
        ("errors.relative", "relative to the distance"),
        ("errors.ulp", "units of the last place of f32 at t"),
        ("errors.radii", "radii of the sphere"),
        ("errors.normal", "degrees"),
        ("certified", "share of the pixels"),
        ("settled", "pixels"),
        ("of_bound", "share of the stated bound"),
        ("predicted.outline", "radii of the sphere"),
        ("predicted.distance", "relative to the distance"),
        ("map.error", "relative to the distance"),
        ("map.wrong", "pixels"),
    ]
    .map(unit)
    .into()
}

/// What JSON can hold of a number: `None` for what is not finite.
#[must_use]
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
