//! The record of a measurement, with units and raw samples. Tables, plots and reports are made from it alone.

use halfline::error::{Error, Place, Result};
use halfline::intersect::predict::Prediction;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole measurement; `records.json` contains it.
///
/// Numbers that may be infinite (such as an unbounded prediction) are `None` then, since JSON has no infinity.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// `halfline-measure`.
    pub schema: String,
    /// Version of this object's shape.
    pub version: u32,
    /// The program that measured.
    pub halfline: String,
    /// The subject: the scene's file name, or `suite extremes`, `suite ladder`.
    pub subject: String,
    /// The command line that repeats it.
    pub command: String,
    /// The promised relative error of certified distances.
    pub tolerance: f64,
    /// The unit of each number, by field name.
    pub units: BTreeMap<String, String>,
    /// The places of the measurement: the adapter and the CPU reference path.
    pub places: Vec<PlaceRecord>,
    /// The scenes.
    pub scenes: Vec<SceneRecord>,
    /// The runs: each method on each scene in each place.
    pub runs: Vec<Run>,
    /// Warnings, in whole sentences.
    pub warnings: Vec<String>,
}

/// An adapter or the CPU reference path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PlaceRecord {
    /// `gpu` or `cpu`.
    pub backend: String,
    /// The adapter's name; `cpu` for the reference path.
    pub adapter: String,
    /// Driver and its version; threads for the reference path.
    pub driver: String,
    /// The results of the self-test, one per line; empty for the reference path.
    pub self_test: Vec<String>,
    /// Whether the device's own clock timed the kernels too.
    pub timestamps: bool,
}

/// A scene, or a family of scenes that were measured together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// File name, family of the extremes, or rung of the ladder.
    pub name: String,
    /// BLAKE3 of the scene's content.
    pub fingerprint: String,
    /// The number of pictures: 1, except for a family of the extremes. Times are sums over all.
    pub pictures: u64,
    /// Spheres, in all pictures.
    pub spheres: u64,
    /// Columns and rows of pixels; zeros where the pictures of a family differ.
    pub size: [u32; 2],
    /// Largest distance from the eye to a sphere's centre, in its radii; `None` without spheres.
    pub farthest: Option<f64>,
    /// The number of rays that hit in exact arithmetic.
    pub hits: u64,
}

/// One method on one scene in one place.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Index into `scenes`.
    pub scene: usize,
    /// Index into `places`.
    pub place: usize,
    /// The intersection method, `certified` or `exact`.
    pub method: String,
    /// Why it was refused; all fields below are then empty.
    pub refused: Option<String>,
    /// Whole-frame wall time of the first frame, with compiling, milliseconds.
    pub first_ms: Option<f64>,
    /// Whole-frame wall times of the later frames, milliseconds; methods alternate.
    pub steady_ms: Vec<f64>,
    /// Kernel times of the same frames by the device's clock, milliseconds; empty where it has none.
    pub kernel_ms: Vec<f64>,
    /// Errors relative to exact arithmetic.
    pub errors: Errors,
    /// Share of the pixels proved in f32; `None` for methods without proofs.
    pub certified: Option<f64>,
    /// Pixels settled in exact arithmetic; `None` for methods without proofs.
    pub settled: Option<u64>,
    /// Largest ratio of a distance error to its stated bound; `None` without bounds.
    pub of_bound: Option<f64>,
    /// The errors predicted before rendering.
    pub predicted: Predicted,
    /// A map of the errors; for single scenes only.
    pub map: Option<Map>,
    /// The middle of the picture; for the ladder only.
    pub crop: Option<Crop>,
}

/// A-priori bounds of a method on a scene; `None` is unbounded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Predicted {
    /// Bound of outline errors, in radii.
    pub outline: Option<f64>,
    /// Bound of the relative error of distances.
    pub distance: Option<f64>,
}

impl Predicted {
    /// The worse of both; `other` if `first`.
    pub(crate) fn worse(self, other: &Prediction, first: bool) -> Self {
        let worse = |a: Option<f64>, b: f64| match (first, a) {
            (true, _) => finite(b),
            (false, a) => a.and_then(|a| finite(a.max(b))),
        };
        Self { outline: worse(self.outline, other.outline), distance: worse(self.distance, other.distance) }
    }
}

/// Errors of one frame relative to exact arithmetic.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Pixels compared.
    pub pixels: u64,
    /// A sphere is shown where the ray hits none.
    pub false_hit: u64,
    /// None is shown where the ray hits one.
    pub false_miss: u64,
    /// Another sphere than the nearest is shown.
    pub wrong_sphere: u64,
    /// The right sphere, but its other root or no root.
    pub wrong_root: u64,
    /// Largest outline error: the relative change of radius that would make every wrong pixel right. `None` is
    /// unbounded.
    pub outline: Option<f64>,
    /// |t - t*| / t* where the right sphere is shown, and where a wrong one is equally near.
    pub relative: Spread,
    /// |t - t*| in ulps of f32 at t*, right sphere and root.
    pub ulp: Spread,
    /// |t - t*| |d| in radii of the sphere, right sphere and root.
    pub radii: Spread,
    /// Angle between the normals in degrees, right sphere and root.
    pub normal: Spread,
}

impl Errors {
    /// The number of wrong pixels.
    #[must_use]
    pub fn wrong(&self) -> u64 {
        self.false_hit + self.false_miss + self.wrong_sphere + self.wrong_root
    }

    /// Wrong pixels as a share of all.
    #[must_use]
    pub fn wrong_share(&self) -> f64 {
        self.wrong() as f64 / self.pixels.max(1) as f64
    }
}

/// A distribution in three numbers; zeros without samples, `None` for infinity.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The median.
    pub median: Option<f64>,
    /// The 99th percentile.
    pub p99: Option<f64>,
    /// The maximum.
    pub max: Option<f64>,
}

/// Errors over the image, in square cells of pixels, row by row.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// Pixels along the side of a cell.
    pub cell: u32,
    /// Columns and rows of cells; the last ones may extend beyond the image.
    pub size: [u32; 2],
    /// Largest relative error of the distance in each cell, right sphere and root, to three digits; 0 without a hit.
    pub error: Vec<f32>,
    /// Wrong pixels in each cell.
    pub wrong: Vec<u32>,
}

/// A part of the rendered picture.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Crop {
    /// Columns and rows.
    pub size: [u32; 2],
    /// One letter per pixel, row by row: `0` to `9` and `a` to `f` for brightness from dark to light; `.` for
    /// background.
    pub shade: String,
    /// One letter per pixel: `-` right, `h` false hit, `m` false miss, `s` wrong sphere, `r` wrong root.
    pub verdict: String,
}

impl Record {
    /// The value of `schema`.
    pub const SCHEMA: &'static str = "halfline-measure";
    /// The value of `version`.
    pub const VERSION: u32 = 1;

    /// Parses a `records.json`.
    ///
    /// # Errors
    /// [`Error::Scene`] at the file `name` for anything else.
    pub fn from_json(text: &str, name: &str) -> Result<Self> {
        let foreign =
            |problem: String| Error::scene(Place::file(name), problem, "use a records.json of halfline measure");
        let record: Self = serde_json::from_str(text).map_err(|e| foreign(e.to_string()))?;
        match (record.schema.as_str(), record.version) {
            (Self::SCHEMA, Self::VERSION) => Ok(record),
            (schema, version) => Err(foreign(format!("the file is a {schema:?} of version {version}"))),
        }
    }
}

/// The units of a record's numbers, by field name.
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

/// A number as JSON can hold it: `None` for infinity and NaN.
#[must_use]
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}
