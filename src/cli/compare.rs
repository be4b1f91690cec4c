//! `halfline compare A B`.

use halfline::error::{Error, Result};
use halfline::frame::file::is_standard;
use halfline::measure::compare::{Difference, compare, sides};
use halfline::measure::{Array, Number, picture};
use serde::{Serialize, Serializer};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// Tells where and by how much two frames (.png or .npy) differ; exits with 1 beyond the tolerance.
///
/// NaN equals NaN and an infinity equals itself. Against anything else they differ infinitely, beyond any tolerance.
/// Frames of different shapes, and PNGs of 8 and of 16 bits, are different.
///
/// Examples:
///   halfline compare expected.png actual.png -o difference.png
///   halfline compare expected.npy actual.npy --tolerance 1e-6 --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Compare {
    /// The expected frame; `-` is standard input.
    a: PathBuf,
    /// The actual frame; `-` is standard input.
    b: PathBuf,
    /// The greatest difference allowed, in the files' own units (PNG: levels).
    #[arg(long, value_name = "X", default_value = "0", value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: f64,
    /// Writes expected | difference | actual as one PNG, equal or not; `-` is standard output.
    #[arg(short, long, value_name = "PNG")]
    output: Option<PathBuf>,
    /// Prints one JSON object; numbers that are not finite are the strings "inf", "-inf" and "nan".
    #[arg(long)]
    json: bool,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x >= 0.0 => Ok(x),
        _ => Err("a tolerance is a number, 0 or more".into()),
    }
}

impl Compare {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let to_stdout = self.output.as_deref().is_some_and(is_standard);
        if is_standard(&self.a) && is_standard(&self.b) {
            return Err(Error::settings("standard input holds one frame, not two", "name a file for A or for B"));
        }
        if to_stdout && self.json {
            let problem = "the picture and the JSON cannot both go to standard output";
            return Err(Error::settings(problem, "name a file after -o"));
        }
        self.output.as_deref().map_or(Ok(()), picture::check)?;
        let (a, b) = (Array::read(&self.a)?, Array::read(&self.b)?);
        let found = compare(&a, &b, self.tolerance);
        match &self.output {
            // Shapes that differ are the answer, not a failure of the command.
            Some(path) if found.unlike.is_some() => {
                eprintln!("halfline: {} is not written: no common pixels", path.display())
            }
            Some(path) => picture::write(&a, &b, &found, path)?,
            None => {}
        }
        let text = if self.json { json(&a, &b, &found)? } else { summary(&a, &b, &found) };
        // With the picture on standard output, the summary is talk.
        let said = if to_stdout { writeln!(io::stderr(), "{text}") } else { writeln!(io::stdout(), "{text}") };
        said.map_err(|error| Error::write("-", error))?;
        Ok(if found.is_within() { ExitCode::SUCCESS } else { ExitCode::from(1) })
    }
}

fn summary(a: &Array, b: &Array, found: &Difference) -> String {
    if let Some(why) = &found.unlike {
        return format!("different: {why}");
    }
    let (this, that) = (a.values().dtype(), b.values().dtype());
    let types = if this == that { this.to_owned() } else { format!("{this} against {that}") };
    let form = format!("{} of {types}", sides(a.shape()));
    let Some(at) = found.at else { return format!("equal: {form}, every value the same") };
    let (verdict, count) = if found.is_within() { ("equal", found.differing) } else { ("different", found.beyond) };
    let how = if found.is_within() { "differ, none" } else { "differ" };
    format!(
        "{verdict}: {count} of {} pixels {how} beyond {:?} ({form})\n\
         greatest {:?} at row {}, column {}, channel {}: {} against {}\n\
         mean {:?}; {} pixels differ at all",
        found.pixels,
        found.tolerance,
        found.max,
        at.row,
        at.column,
        at.channel,
        at.a,
        at.b,
        found.mean,
        found.differing
    )
}

fn json(a: &Array, b: &Array, found: &Difference) -> Result<String> {
    let like = found.unlike.is_none();
    let report = Report {
        schema: "halfline-compare",
        version: 1,
        equal: found.is_within(),
        tolerance: Json(Number::Float(found.tolerance)),
        unlike: found.unlike.as_deref(),
        files: [a.name(), b.name()],
        shapes: [a.shape(), b.shape()],
        types: [a.values().dtype(), b.values().dtype()],
        shape: like.then(|| a.shape()),
        pixels: like.then_some(found.pixels),
        differing: like.then_some(found.differing),
        beyond: like.then_some(found.beyond),
        max: like.then_some(Json(Number::Float(found.max))),
        mean: like.then_some(Json(Number::Float(found.mean))),
        at: found.at.map(|at| Place {
            row: at.row,
            column: at.column,
            channel: at.channel,
            a: Json(at.a),
            b: Json(at.b),
        }),
    };
    serde_json::to_string_pretty(&report).map_err(|error| Error::write("-", error.into()))
}

/// What `--json` prints. From `shape` on, everything is null for frames that are unlike.
#[derive(Serialize)]
struct Report<'a> {
    schema: &'static str,
    version: u32,
    equal: bool,
    tolerance: Json,
    unlike: Option<&'a str>,
    files: [&'a str; 2],
    shapes: [&'a [usize]; 2],
    types: [&'a str; 2],
    shape: Option<&'a [usize]>,
    pixels: Option<usize>,
    differing: Option<usize>,
    beyond: Option<usize>,
    max: Option<Json>,
    mean: Option<Json>,
    at: Option<Place>,
}

#[derive(Serialize)]
struct Place {
    row: usize,
    column: usize,
    channel: usize,
    a: Json,
    b: Json,
}

/// A number, or the string that stands for one JSON does not have.
struct Json(Number);

impl Serialize for Json {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            Number::Int(x) => serializer.serialize_i64(x),
            Number::Float(x) if x.is_nan() => serializer.serialize_str("nan"),
            Number::Float(x) if x.is_infinite() => serializer.serialize_str(if x > 0.0 { "inf" } else { "-inf" }),
            Number::Float(x) => serializer.serialize_f64(x),
        }
    }
}
