//! The result of a comparison, as text and as JSON.

use crate::messages::say;
use crate::process::ExitCode;
use halfline::error::{Error, Result};
use halfline_files::write::buffers::FrameFile;
use halfline_measure::compare::{Difference, compare, sides};
use halfline_measure::frames::{BufferPair, MatchedBuffers};
use halfline_measure::{ArrayValue, picture};
use serde::{Serialize, Serializer};
use std::path::Path;

/// The common buffers of two files, their differences, and the buffers that only one file has.
pub(super) struct FrameComparison<'a> {
    tolerance: f64,
    share: f64,
    files: [&'a str; 2],
    pairs: MatchedBuffers<'a>,
    differences: Vec<Difference>,
    /// Why the files differ regardless of their buffers.
    unlike: Option<String>,
}

impl<'a> FrameComparison<'a> {
    /// `tolerance` is the largest allowed difference, `share` the largest share of the pixels of a buffer that may exceed it.
    pub(super) fn of(
        a: &'a FrameFile,
        b: &'a FrameFile,
        pairs: MatchedBuffers<'a>,
        (tolerance, share): (f64, f64),
    ) -> Self {
        let differences = pairs.common.iter().map(|pair| compare(pair.a, pair.b, tolerance, share)).collect();
        let places = a.origin.zip(b.origin).filter(|(a, b)| a != b);
        let windows = places.map(|([x, y], [u, v])| format!("the data windows begin at {x},{y} and at {u},{v}"));
        let missing: Vec<String> = pairs.missing.iter().map(|(name, file)| format!("only {file} has {name}")).collect();
        let nothing = pairs.common.is_empty().then(|| "the files have no buffer in common".to_owned());
        let unlike: Vec<String> = windows.into_iter().chain(missing).chain(nothing).collect();
        let unlike = (!unlike.is_empty()).then(|| unlike.join("; "));
        Self { tolerance, share, files: [&a.name, &b.name], pairs, differences, unlike }
    }

    /// Whether both files have the same buffers, equal within the tolerance.
    fn is_equal(&self) -> bool {
        self.unlike.is_none() && self.differences.iter().all(Difference::is_within)
    }

    /// 0 if they are equal, 1 if they differ.
    pub(super) fn exit_code(&self) -> ExitCode {
        if self.is_equal() { ExitCode::SUCCESS } else { ExitCode(1) }
    }

    /// Writes the difference picture of the only pair of buffers.
    pub(super) fn draw(&self, path: &Path) -> Result<()> {
        match (&self.pairs.common[..], &self.differences[..]) {
            // Different shapes are a result, not an error of the command.
            ([_], [difference]) if difference.unlike.is_some() => {
                say(format_args!("warning: {} is not written, because there are no common pixels", path.display()));
                Ok(())
            }
            ([pair], [difference]) => picture::write(pair.a, pair.b, difference, path),
            (pairs, _) => {
                let names: Vec<&str> = pairs.iter().filter_map(|pair| pair.name).collect();
                let problem = format!("{} shows one buffer, but {} are compared", path.display(), pairs.len());
                Err(Error::settings(problem, format!("choose one with --aov: {}", names.join(", "))))
            }
        }
    }

    fn each(&self) -> impl Iterator<Item = (&BufferPair<'a>, &Difference)> {
        self.pairs.common.iter().zip(&self.differences)
    }

    pub(super) fn summary(&self) -> String {
        if let (None, [(pair, difference)]) = (&self.unlike, &self.each().collect::<Vec<_>>()[..]) {
            return summary(pair, difference);
        }
        let differing = self.differences.iter().filter(|difference| !difference.is_within()).count();
        let verdict = if self.is_equal() { "equal" } else { "different" };
        let count = self.differences.len();
        let mut text = match (self.is_equal(), &self.unlike) {
            (true, _) => format!("{verdict}: {count} buffers"),
            (false, Some(why)) => format!("{verdict}: {why}; {differing} of {count} common buffers differ"),
            (false, None) => format!("{verdict}: {differing} of {count} buffers"),
        };
        for (pair, difference) in self.each() {
            let lines = summary(pair, difference).replace('\n', "\n  ");
            text += &format!("\n{}: {lines}", pair.name.unwrap_or("buffer"));
        }
        text
    }

    pub(super) fn json(&self) -> Result<String> {
        let one = match &self.each().collect::<Vec<_>>()[..] {
            [(pair, difference)] => Some(BufferReport::of(pair, difference)),
            _ => None,
        };
        let like = self.differences.iter().any(|difference| difference.unlike.is_none());
        let some = |value: fn(&Difference) -> usize| like.then(|| self.differences.iter().map(value).sum());
        let most = self.differences.iter().map(|difference| difference.max).fold(0.0, f64::max);
        let inner = one.as_ref().and_then(|one| one.unlike.map(str::to_owned));
        let report = JsonReport {
            schema: "halfline-compare",
            version: 1,
            equal: self.is_equal(),
            tolerance: Json(ArrayValue::Float(self.tolerance)),
            share: self.share,
            unlike: self.unlike.clone().or(inner),
            files: self.files,
            values: ComparedValues {
                pixels: some(|difference| difference.pixels),
                differing: some(|difference| difference.differing),
                beyond: some(|difference| difference.beyond),
                max: like.then_some(Json(ArrayValue::Float(most))),
                ..one.as_ref().map(|one| one.values).unwrap_or_default()
            },
            buffers: self.each().map(|(pair, difference)| BufferReport::of(pair, difference)).collect(),
            missing: self.pairs.missing.iter().map(|(buffer, file)| Missing { buffer, only_in: file }).collect(),
        };
        serde_json::to_string_pretty(&report).map_err(|error| Error::write("-", error.into()))
    }
}

fn summary(pair: &BufferPair<'_>, found: &Difference) -> String {
    if let Some(why) = &found.unlike {
        return format!("different: {why}");
    }
    let (this, that) = (pair.a.values().dtype(), pair.b.values().dtype());
    let types = if this == that { this.to_owned() } else { format!("{this} against {that}") };
    let form = format!("{} of {types}", sides(pair.a.shape()));
    let Some(at) = found.at else { return format!("equal: {form}, every value is the same") };
    let verdict = match found.is_within() {
        true if found.beyond > 0 => "within the share",
        true => "equal",
        false => "different",
    };
    let (count, how) = if found.beyond == 0 { (found.differing, "differ, none") } else { (found.beyond, "differ") };
    let allowed = match found.share > 0.0 {
        true => format!(", and {} % may", 100.0 * found.share),
        false => String::new(),
    };
    format!(
        "{verdict}: {count} of {} pixels {how} beyond {:?}{allowed} ({form})\n\
         largest {:?} at row {}, column {}, channel {}: {} against {}\n\
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

/// The output of `--json`: a summary of all buffers, then each. `shapes`, `types`, `shape`, `mean` and `at` are null
/// where several buffers are compared; `shape` and the keys after it are null for buffers that cannot be compared.
#[derive(Serialize)]
struct JsonReport<'a> {
    schema: &'static str,
    version: u32,
    equal: bool,
    tolerance: Json,
    share: f64,
    unlike: Option<String>,
    files: [&'a str; 2],
    #[serde(flatten)]
    values: ComparedValues<'a>,
    buffers: Vec<BufferReport<'a>>,
    missing: Vec<Missing<'a>>,
}

/// A buffer that only one file has.
#[derive(Serialize)]
struct Missing<'a> {
    buffer: &'a str,
    only_in: &'a str,
}

/// A buffer that both files have.
#[derive(Serialize)]
struct BufferReport<'a> {
    name: Option<&'a str>,
    equal: bool,
    unlike: Option<&'a str>,
    #[serde(flatten)]
    values: ComparedValues<'a>,
}

/// The shapes and types of two buffers, and the differences of their values; see [`JsonReport`] for the absent ones.
#[derive(Clone, Copy, Default, Serialize)]
struct ComparedValues<'a> {
    shapes: Option<[&'a [usize]; 2]>,
    types: Option<[&'a str; 2]>,
    shape: Option<&'a [usize]>,
    pixels: Option<usize>,
    differing: Option<usize>,
    beyond: Option<usize>,
    max: Option<Json>,
    mean: Option<Json>,
    at: Option<ValueLocation>,
}

impl<'a> BufferReport<'a> {
    fn of(pair: &BufferPair<'a>, found: &'a Difference) -> Self {
        let like = found.unlike.is_none();
        Self {
            name: pair.name,
            equal: found.is_within(),
            unlike: found.unlike.as_deref(),
            values: ComparedValues {
                shapes: Some([pair.a.shape(), pair.b.shape()]),
                types: Some([pair.a.values().dtype(), pair.b.values().dtype()]),
                shape: like.then(|| pair.a.shape()),
                pixels: like.then_some(found.pixels),
                differing: like.then_some(found.differing),
                beyond: like.then_some(found.beyond),
                max: like.then_some(Json(ArrayValue::Float(found.max))),
                mean: like.then_some(Json(ArrayValue::Float(found.mean))),
                at: found.at.map(|at| ValueLocation {
                    row: at.row,
                    column: at.column,
                    channel: at.channel,
                    a: Json(at.a),
                    b: Json(at.b),
                }),
            },
        }
    }
}

#[derive(Clone, Copy, Serialize)]
struct ValueLocation {
    row: usize,
    column: usize,
    channel: usize,
    a: Json,
    b: Json,
}

/// A number, or a string for a number that JSON cannot hold.
#[derive(Clone, Copy)]
struct Json(ArrayValue);

impl Serialize for Json {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            ArrayValue::Int(x) => serializer.serialize_i64(x),
            ArrayValue::Float(x) if x.is_nan() => serializer.serialize_str("nan"),
            ArrayValue::Float(x) if x.is_infinite() => serializer.serialize_str(if x > 0.0 { "inf" } else { "-inf" }),
            ArrayValue::Float(x) => serializer.serialize_f64(x),
        }
    }
}
