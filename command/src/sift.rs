//! `halfline sift FILE`: a part of a scene for `render --visible`.

use super::clash::{check_inputs, check_text};
use super::messages::{QuietArgs, flags, note, warn};
use super::option_table::{NO_PART, has, hidden};
use super::process::ExitCode;
use super::render::stream::Source;
use super::scene_args::SceneArgs;
use super::standard::print_json;
use clap::{Arg, Args, Command};
use halfline::error::{Error, Result};
use halfline::progress::Cancel;
use halfline::render::stream::PartView;
use halfline_files::parts;
use halfline_files::write::file::is_standard_output;
use serde::Serialize;
use std::path::Path;

/// Keeps the spheres of a file that some ray of a frame may hit first, as a part of a scene that lies in several files or on several
/// machines. halfline render --visible makes the frame of all parts, bit for bit the frame of one machine.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, next_line_help = true)]
pub(crate) struct Sift {
    #[command(flatten)]
    args: SceneArgs,
    /// The id of the first sphere of the file in the whole scene; the others follow, without those that are not selected. Ids
    /// decide ties, and the buffer id holds them.
    #[arg(long, value_name = "N", help_heading = "Input")]
    first_id: u64,
    /// Prints one JSON object about the part on standard output.
    #[arg(long, help_heading = "Reporting")]
    json: bool,
    #[command(flatten)]
    quiet: QuietArgs,
}

const EXAMPLES: &str = "\
The command takes the options of halfline render that read, colour and show. All parts need the same camera, size,
window, samples, seed, tolerance, width of outlines and planes. The file is read in blocks and may be larger than
memory.

Examples:
  halfline sift a.npy --first-id 0 --eye 0,0,9 --at 0,0,0 --size 1920x1080 -o a.npz
  halfline sift b.npy --first-id 500000 --eye 0,0,9 --at 0,0,0 --size 1920x1080 -o b.npz
  halfline render --visible a.npz b.npz -o picture.png --aov id=id.npy";

/// The command line in which `sift` has only the options that it takes.
pub(super) fn with_own_options(command: Command) -> Command {
    command.mut_subcommand("sift", |sift| {
        let sift = hidden(sift, |id| has(id, NO_PART));
        sift.mut_arg("output", |arg: Arg| arg.help("The part: an .npz of NumPy arrays.").long_help(None).required(true))
            .mut_arg("scene", |arg: Arg| {
                arg.help(
                    "A file of rows: npy, csv, xyz, LAMMPS dump, ply, las, also .gz, .bz2, .xz or .zst; - for standard input.",
                )
            })
    })
}

/// The report of `--json`: the part that was written.
#[derive(Serialize)]
struct Report<'a> {
    halfline: &'static str,
    output: &'a Path,
    /// The ids of all spheres of the part; the end is excluded.
    ids: Vec<[u64; 2]>,
    spheres: u64,
    /// The spheres that are left.
    kept: usize,
    warnings: Vec<String>,
    #[serde(rename = "seen")]
    view: &'a PartView,
}

impl Sift {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        self.check()?;
        let Some(output) = &self.args.files.output else {
            return Err(Error::settings("no output is requested", "use -o PART.npz"));
        };
        let is_npz = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz"));
        if is_standard_output(output) || !is_npz {
            let problem = format!("{} cannot hold a part", output.display());
            return Err(Error::settings(problem, "use the file name extension .npz"));
        }
        if self.json {
            check_text([output.as_path()], "the report of --json")?;
        }
        let settings = self.args.settings(&[]);
        let source = Source::new(&self.args, &Cancel::default(), None).map_err(of_parts)?;
        check_inputs([output.as_path()], &source.inputs())?;
        let (part, warnings, framed) = source.part(&settings, self.first_id).map_err(of_parts)?;
        warn(&warnings);
        if framed {
            warn([
                "the camera frames the spheres of this part alone; give all parts of a scene the same --eye and --at, or --camera-from",
            ]);
        }
        parts::write(&part, output)?;
        note(format_args!("{}: {part}", output.display()));
        if self.json {
            let (ids, spheres, kept, view) = (part.all_ids(), part.count(), part.ids().len(), part.view());
            let halfline = env!("CARGO_PKG_VERSION");
            print_json(&Report { halfline, output, ids, spheres, kept, warnings, view })?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Refuses options that a part does not depend on, and those that would need other parts.
    fn check(&self) -> Result<()> {
        let command = SceneArgs::augment_args(Command::new("sift"));
        let mut refused = command.get_arguments().filter(|arg| has(arg.get_id().as_str(), NO_PART));
        let typed = |arg: &&Arg| self.args.typed.has(arg.get_id().as_str());
        if let Some(long) = refused.find(typed).and_then(Arg::get_long) {
            let problem = format!("--{long} is not an option of a part of a scene");
            return Err(Error::settings(problem, "remove it, or give it to halfline render --visible"));
        }
        Ok(())
    }
}

/// The errors of a stream in the words of a part.
fn of_parts(error: Error) -> Error {
    match error {
        Error::Settings { problem, mend } => {
            let (problem, mend) = (flags(&problem), flags(&mend));
            let problem = problem.strip_prefix("--stream: ").unwrap_or(&problem).to_owned();
            let mend = mend
                .replace(", or remove --stream", "")
                .replace("remove --stream, or ", "")
                .replace(", or --stream", "");
            Error::Settings { problem, mend }
        }
        other => other,
    }
}
