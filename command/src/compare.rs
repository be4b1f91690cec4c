//! `halfline compare A B`.

mod report;

use super::clash::check_inputs;
use super::messages::{QuietArgs, is_quiet};
use super::process::ExitCode;
use super::standard::print;
use super::values::share;
use halfline::error::{Error, Result};
use halfline_files::write::buffers::FrameFile;
use halfline_files::write::file::{is_standard, is_standard_output};
use halfline_measure::frames::MatchedBuffers;
use halfline_measure::picture;
use report::FrameComparison;
use std::io::{self, Write};
use std::path::PathBuf;

/// Compares two frames (.png, .npy, .npz, .exr or .pfm); exits with 1 if they differ by more than the tolerance.
///
/// In files with several buffers, buffers of the same name are compared; a buffer that only one file has is a
/// difference. NaN equals NaN and an infinity equals itself; against anything else they differ infinitely, beyond any
/// tolerance. Frames of different shapes, and PNGs of 8 and of 16 bits, are different.
///
/// Examples:
///   halfline compare expected.png actual.png -o difference.png
///   halfline compare expected.npy actual.npy --tolerance 1e-6 --json
///   halfline compare expected.exr actual.exr --aov depth,normal
///   halfline compare expected.png actual.png --tolerance 2 --share 0.1%
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Compare {
    /// The expected frame; `-` is standard input.
    a: PathBuf,
    /// The actual frame; `-` is standard input.
    b: PathBuf,
    /// The largest allowed difference, in the files' units (PNG: levels).
    #[arg(long, value_name = "X", default_value = "0", value_parser = tolerance, allow_negative_numbers = true)]
    tolerance: f64,
    /// The share of the pixels of a buffer that may differ by more, such as 0.1%.
    #[arg(long, value_name = "P%", value_parser = part)]
    share: Option<f64>,
    /// The buffers to compare, such as depth,normal [default: all].
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    aov: Vec<String>,
    /// Writes expected | difference | actual as one PNG, even if they are equal; `-` is standard output.
    #[arg(short, long, value_name = "PNG")]
    output: Option<PathBuf>,
    /// Prints one JSON object; numbers that are not finite are the strings "inf", "-inf" and "nan".
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: QuietArgs,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x >= 0.0 => Ok(x),
        _ => Err("expected a number, 0 or more".into()),
    }
}

impl Compare {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        let to_stdout = self.output.as_deref().is_some_and(is_standard_output);
        if is_standard(&self.a) && is_standard(&self.b) {
            return Err(Error::settings(
                "only one of the frames can come from standard input",
                "use a file for A or for B",
            ));
        }
        if to_stdout && self.json {
            let problem = "the picture and the JSON cannot both go to standard output";
            return Err(Error::settings(problem, "use a file for -o"));
        }
        check_inputs(self.output.as_deref(), &[self.a.clone(), self.b.clone()])?;
        self.output.as_deref().map_or(Ok(()), picture::check)?;
        let (a, b) = (FrameFile::read(&self.a)?, FrameFile::read(&self.b)?);
        let pairs = MatchedBuffers::of(&a, &b, &self.aov)?;
        let found = FrameComparison::of(&a, &b, pairs, (self.tolerance, self.share.unwrap_or(0.0)));
        if let Some(path) = &self.output {
            found.draw(path)?;
        }
        let text = if self.json { found.json()? } else { found.summary() };
        // With the picture on standard output, the summary is a message on standard error.
        if to_stdout {
            if is_quiet() {
                return Ok(found.exit_code());
            }
            let _ = io::stderr().write_all(format!("{text}\n").as_bytes());
        } else {
            print(&format!("{text}\n"))?;
        }
        Ok(found.exit_code())
    }
}

/// A share that is in percent, or below 1: 1 alone could be meant as either.
fn part(text: &str) -> Result<f64, String> {
    match share(text)? {
        1.0 if !text.ends_with('%') => Err("expected a percentage, such as 1%, or a share below 1".into()),
        found => Ok(found),
    }
}
