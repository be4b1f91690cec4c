//! `halfline measure`.

mod table;

use super::bar::Bar;
use super::clash::check_inputs;
use super::lines::ProgressOutput;
use super::messages::{QuietArgs, flags, note, warn};
use super::picture_size::scene_size;
use super::process::{ExitCode, arguments};
use super::scene_args::tolerance;
use super::signals::{go_on, watch};
use super::standard::print;
use super::values::at_least_one;
use clap::{Args, ValueEnum};
use halfline::error::{Error, Result};
use halfline::settings::{Backend, Tolerance};
use halfline_files::read::{self, ParticleOptions, ReadOptions};
use halfline_files::write::file::check_writable;
use halfline_measure::record::Record;
use halfline_measure::run::{Options, Subject, measure};
use halfline_measure::variant::Variant;
use halfline_measure::{export, report};
use std::io::ErrorKind;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

/// Measures speed and error of every method on a scene or a suite of scenes, on the GPU and on the CPU.
///
/// Each method renders a first frame, then the methods alternate; errors are relative to exact arithmetic. Examples:
///   halfline measure scenes/weekend.toml --out weekend
///   halfline measure --suite ladder --methods textbook,stable,certified --out ladder
///   halfline measure --from weekend/records.json
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Measure {
    #[command(flatten)]
    subject: What,
    /// The methods: textbook, unit, geometric, stable, f64, double-float, certified, exact [default: all].
    #[arg(long, value_name = "M,M,...", value_delimiter = ',', conflicts_with = "from")]
    methods: Vec<Variant>,
    /// The folder for records.json, records.csv, report.html and the plots; created if it does not exist.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Prints the whole record as JSON on standard output instead of a table.
    #[arg(long)]
    json: bool,
    /// Frames after the first; slow methods render fewer [default: 5, in suites 1].
    #[arg(long, value_name = "N", conflicts_with = "from", value_parser = at_least_one)]
    repeat: Option<NonZeroU32>,
    /// Image size in pixels, of a scene or of the ladder suite.
    #[arg(long, value_name = "WxH", value_parser = scene_size, conflicts_with = "from")]
    size: Option<(u32, u32)>,
    /// Backends to measure: auto (both), gpu, cpu.
    #[arg(long, value_name = "B", default_value = "auto", conflicts_with = "from")]
    backend: Backend,
    /// The adapter, by index or part of its name (see halfline adapters).
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "from")]
    adapter: Option<String>,
    /// Promised relative error of certified distances; at least 2^-50.
    #[arg(long, value_name = "X", default_value = "1e-5", value_parser = tolerance, allow_negative_numbers = true, conflicts_with = "from")]
    tolerance: Tolerance,
    /// Methods that would take longer than this for one frame on the CPU path are skipped, seconds.
    #[arg(long, value_name = "S", default_value = "30", value_parser = seconds, conflicts_with = "from")]
    patience: f64,
    #[command(flatten)]
    quiet: QuietArgs,
}

/// The subject: a scene or a suite to measure, or a record to export again.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct What {
    /// The scene: .toml, .nff, or - for standard input.
    scene: Option<PathBuf>,
    /// A suite of scenes: extremes (hard cases for renderers), ladder (a wall of spheres from near to far).
    #[arg(long, value_name = "SUITE")]
    suite: Option<Suite>,
    /// Exports an existing records.json again without measuring; - is standard input.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Suite {
    Extremes,
    Ladder,
}

impl Measure {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        if let Some(folder) = &self.out {
            let inputs: Vec<_> = [&self.subject.scene, &self.subject.from].into_iter().flatten().cloned().collect();
            let outputs = ["records.json", "records.csv", "report.html"].map(|name| folder.join(name));
            check_inputs(outputs.iter().map(PathBuf::as_path), &inputs)?;
            check_folder(folder)?;
        }
        let record = match &self.subject.from {
            Some(path) => read(path)?,
            None => with_flags(self.measure()?),
        };
        warn(&record.warnings);
        if let Some(folder) = &self.out {
            write(&record, folder)?;
        }
        let text = if self.json { export::json(&record)? } else { table::of(&record) };
        print(&text)?;
        Ok(ExitCode::SUCCESS)
    }

    fn measure(&self) -> Result<Record> {
        let options = Options {
            backend: self.backend,
            adapter: self.adapter.clone(),
            variants: match &self.methods[..] {
                [] => Variant::all(),
                // In the order of the list, without duplicates.
                some => Variant::all().into_iter().filter(|variant| some.contains(variant)).collect(),
            },
            rounds: self.repeat.map(NonZeroU32::get),
            tolerance: self.tolerance,
            patience: self.patience,
            command: command(),
        };
        let subject = self.subject()?;
        let bar = Bar::with_output(ProgressOutput::Auto, 1);
        measure(&subject, &options, &bar.watch(), &mut |line| bar.suspended(|| note(format_args!("{line}"))))
    }

    fn subject(&self) -> Result<Subject> {
        let subject = match (&self.subject.suite, &self.subject.scene) {
            (Some(Suite::Extremes), _) if self.size.is_some() => {
                return Err(Error::settings("the scenes of the suite extremes have fixed sizes", "remove --size"));
            }
            (Some(Suite::Extremes), _) => {
                let folder = std::env::var_os("HALFLINE_DATA").map(PathBuf::from);
                Subject::extremes(folder.as_deref())?
            }
            (Some(Suite::Ladder), _) => Subject::ladder()?,
            (None, Some(path)) => {
                let read = read::scene(
                    path,
                    &ReadOptions {
                        particles: ParticleOptions { watch: watch(), ..Default::default() },
                        ..ReadOptions::default()
                    },
                )?;
                let name = path.file_name().unwrap_or(path.as_os_str());
                Subject::scene(name.to_string_lossy(), read.scene, read.skipped.warnings())
            }
            (None, None) => return Err(Error::settings("there is nothing to measure", "use a scene or --suite")),
        };
        Ok(match self.size {
            Some((width, height)) => subject.resized([width, height]),
            None => subject,
        })
    }
}

/// The record with the options of the command in its messages.
fn with_flags(mut record: Record) -> Record {
    let refusals = record.runs.iter_mut().filter_map(|run| run.refused.as_mut());
    record.warnings.iter_mut().chain(refusals).for_each(|message| *message = flags(message));
    record
}

fn read(path: &Path) -> Result<Record> {
    let text = if halfline_files::write::file::is_standard(path) {
        std::io::read_to_string(std::io::stdin())
    } else {
        std::fs::read_to_string(path)
    };
    Record::from_json(&text.map_err(|e| Error::read(path, e))?, &path.display().to_string())
}

/// Checks before the work begins that files can be written into the folder, or that it can be created.
fn check_folder(folder: &Path) -> Result<()> {
    if folder.is_dir() {
        return check_writable(&folder.join("records.json"));
    }
    if folder.exists() {
        let why = std::io::Error::new(ErrorKind::NotADirectory, "the path is not a folder");
        return Err(Error::write(folder, why));
    }
    check_writable(folder)
}

/// Writes all exports of the record.
fn write(record: &Record, folder: &Path) -> Result<()> {
    if !go_on() {
        return Err(Error::Interrupted);
    }
    std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e))?;
    export::write(record, folder)?;
    report::write(record, folder).map(drop)
}

/// The command line, quoted for a shell.
fn command() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=:+".contains(c);
    let quoted = |text: String| match !text.is_empty() && text.chars().all(plain) {
        true => text,
        false => format!("'{}'", text.replace('\'', r"'\''")),
    };
    let arguments = arguments().map(|text| quoted(text.to_string_lossy().into_owned()));
    std::iter::once("halfline".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ")
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(x) if x > 0.0 => Ok(x),
        _ => Err("expected a positive number of seconds".into()),
    }
}
