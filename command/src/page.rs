//! `halfline page FILE -o FILE.html`: a page that shows the scene without a server.

mod html;

use super::clash::check_inputs;
use super::config::Config;
use super::inset_args::joined;
use super::messages::{QuietArgs, flags, note, warn};
use super::option_table::{NO_VIEW, ids_with};
use super::process::{ExitCode, all_arguments};
use super::scene_args::SceneArgs;
use super::signals::go_on;
use super::standard::print_json;
use super::view::{Content, Given, MemoryScene, content, stage};
use clap::{Arg, Args, Command};
use halfline::error::{Error, Result};
use halfline::render::Renderer;
use halfline_files::read::ColumnNames;
use halfline_files::write::file::write_atomically;
use halfline_viewer::{FrameRequest, Pixels};
use html::Html;
use serde::Serialize;
use std::path::Path;
use std::sync::{Arc, Mutex};

/// Writes a page that shows the scene in any browser, without a server and without anything from elsewhere: one file, in which a
/// reader turns, picks and selects. It renders with WebGPU where the browser has it, else on the processor; pixels are certified in both.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, next_line_help = true)]
pub(crate) struct Page {
    #[command(flatten)]
    args: SceneArgs,
    #[command(flatten)]
    quiet: QuietArgs,
    /// Prints a report as JSON.
    #[arg(long, help_heading = "Reporting")]
    json: bool,
}

const EXAMPLES: &str = "\
The options are those of halfline render that read, select, colour, light and frame. --columns names also the columns that the page
shows of a sphere that is picked, and that its selections read.

Examples:
  halfline page 3SN6.cif -o figure.html --color-by chain --columns chain,resname
  halfline page run.dump -o film.html --frames 1-50 --color-by velocity
  halfline page particles.npy -o page.html --look plain";

/// The options of `halfline page` that a picture of it does not have.
const OWN: [&str; 5] = ["output", "columns", "frames", "quiet", "json"];

/// The report of `--json`.
#[derive(Serialize)]
struct Report<'a> {
    schema: u32,
    version: &'static str,
    output: &'a Path,
    frames: usize,
    spheres: usize,
    columns: Vec<String>,
    /// Bytes of the file, and of its parts as they are in it.
    bytes: usize,
    program_bytes: usize,
    content_bytes: usize,
    warnings: Vec<String>,
}

/// The command line in which `page` has only the options that it takes.
pub(super) fn with_own_options(command: Command) -> Command {
    command.mut_subcommand("page", |page| {
        let page = ids_with(NO_VIEW)
            .filter(|id| *id != "output")
            .fold(page, |page, id| page.mut_arg(id, |arg: Arg| arg.hide(true)));
        own(page.mut_arg("output", |arg: Arg| {
            arg.help("The page: an .html file; - for standard output.").long_help(None).required(true)
        }))
    })
}

/// `--columns` takes names without a meaning too.
fn own(page: Command) -> Command {
    let named = |text: &str| ColumnNames::with_others(text).map(|(named, _)| named);
    page.mut_arg("columns", |arg: Arg| arg.value_parser(named))
}

impl Page {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        let (given, kept) = self.given()?;
        let path = self.args.files.output.as_deref().unwrap_or(Path::new("-"));
        if path
            .extension()
            .is_some_and(|ending| !ending.eq_ignore_ascii_case("html") && !ending.eq_ignore_ascii_case("htm"))
        {
            return Err(Error::settings(
                format!("{} is not the name of a page", path.display()),
                "use a name that ends in .html",
            ));
        }
        check_inputs([path], &[self.args.path().to_path_buf()])?;
        let program = html::program()?;
        let bytes = content(given, self.args.read.frames.as_ref(), &kept)?.pack()?;
        // The picture for browsers without WebAssembly comes from the very content of the page.
        let content = Content::unpack(&bytes)
            .ok_or_else(|| Error::settings("the content cannot be read back", "report this as a bug"))?;
        let (camera, size) = (content.camera, content.size);
        let counts = (content.frames.len(), content.frames.iter().map(|frame| frame.scene.spheres.len()).sum());
        let columns = content.frames[0].columns.names().map(str::to_owned).collect();
        let name = content.name.clone();
        let settings = self.args.settings(&[]);
        let renderer = Arc::new(Mutex::new(Some(Renderer::new(&settings)?)));
        let shown = stage(MemoryScene::of(content, renderer, settings.backend, flags))?;
        let refused = |refusal: halfline_viewer::Refusal| Error::settings(refusal.message, "use another option");
        let picture = shown.frame(&FrameRequest::still(camera, size), &(Arc::new(go_on) as _)).map_err(refused)?;
        let Some(picture) = picture else { return Err(Error::Interrupted) };
        let Pixels::Png(png) = picture.pixels else {
            return Err(Error::settings("there is no picture", "report this as a bug"));
        };
        let warnings: Vec<String> = serde_json::from_value(picture.info["warnings"].clone()).unwrap_or_default();
        let html = Html::new(&name, size, &program, &bytes, &png)?;
        write_atomically(path, |out| out.write_all(html.text.as_bytes()))?;
        warn(&warnings);
        note(format_args!("{}: {:.1} MB", path.display(), html.text.len() as f64 * 1e-6));
        if self.json {
            print_json(&Report {
                schema: 1,
                version: env!("CARGO_PKG_VERSION"),
                output: path,
                frames: counts.0,
                spheres: counts.1,
                columns,
                bytes: html.text.len(),
                program_bytes: html.program,
                content_bytes: html.content,
                warnings,
            })?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The options that are typed, and the names of the columns of the page.
    ///
    /// # Errors
    /// [`Error::Settings`] for an option that a page does not have.
    fn given(&self) -> Result<(Given, Vec<String>)> {
        let command = own(Self::augment_args(Command::new("page")));
        // The first word is the name of the command, which is that of the program here.
        let words = joined(all_arguments().iter().skip(1).cloned());
        let matches = command.clone().try_get_matches_from(words);
        let matches = matches.map_err(|error| Error::settings(error.to_string(), "use halfline page --help"))?;
        let typed = |id: &&str| matches.value_source(id) == Some(clap::parser::ValueSource::CommandLine);
        if let Some(id) = ids_with(NO_VIEW).filter(|id| *id != "output").find(typed) {
            let problem = format!("--{} is an option of pictures in files", id.replace('_', "-"));
            return Err(Error::settings(problem, "remove it"));
        }
        let mut kept = Vec::new();
        for text in matches.get_raw("columns").into_iter().flatten() {
            kept.extend(ColumnNames::with_others(&text.to_string_lossy())?.1);
        }
        Ok((Given::of(&command, &matches, &OWN, Config::load()?.preferences())?, kept))
    }
}
