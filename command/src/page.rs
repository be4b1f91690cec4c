//! `halfline page FILE -o FILE.html`: a page that shows the scene without a server.

mod html;

use super::clash::check_inputs;
use super::messages::{QuietArgs, flags, note, warn};
use super::option_table::{NO_VIEW, has, hidden};
use super::process::ExitCode;
use super::scene_args::SceneArgs;
use super::signals::go_on;
use super::standard::print_json;
use super::view::{Content, Given, MemoryScene, PageText, content, stage};
use clap::{Arg, Args, Command};
use halfline::error::{Error, Result};
use halfline::render::Renderer;
use halfline_files::read::ColumnNames;
use halfline_files::write::file::write_atomically;
use halfline_viewer::{FrameRequest, Picture, Pixels};
use html::Html;
use serde::Serialize;
use std::ffi::OsStr;
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
    /// The title of the page [default: the name of the file].
    #[arg(long, help_heading = "Page", value_name = "TEXT")]
    title: Option<String>,
    /// The caption below the picture.
    #[arg(long, help_heading = "Page", value_name = "TEXT")]
    caption: Option<String>,
    /// Prints a report as JSON.
    #[arg(long, help_heading = "Reporting")]
    json: bool,
}

const EXAMPLES: &str = "\
The command takes the options of halfline render that read, select, colour, light and frame. --columns names further
columns that the page shows of a sphere that is picked, and that its selections read, beside chain, residue, name and
element.

Examples:
  halfline page 3SN6.cif -o figure.html --color-by chain --title 'A receptor' --caption 'PDB 3SN6, by chain'
  halfline page run.dump -o film.html --frames 1-50 --color-by velocity
  halfline page particles.npy -o page.html --look plain";

/// The options of `halfline page` that a picture of it does not have.
const OWN: [&str; 7] = ["output", "columns", "frames", "title", "caption", "quiet", "json"];

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
        let page = hidden(page, |id| id != "output" && has(id, NO_VIEW));
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

/// A page, and what is in it.
#[derive(Debug)]
pub struct MadePage {
    /// The file.
    pub html: String,
    /// The number of frames.
    pub frames: usize,
    /// The spheres of all frames.
    pub spheres: usize,
    /// The names of the columns.
    pub columns: Vec<String>,
    /// Bytes of the program in the file.
    pub program_bytes: usize,
    /// Bytes of the frames in the file.
    pub content_bytes: usize,
    /// Warnings of its picture.
    pub warnings: Vec<String>,
}

/// Makes a page. The renderer renders the picture for browsers that cannot run the page's program, from the
/// very content of the page.
///
/// # Errors
/// [`Error::Settings`] for a command without the program of pages, and for options that pictures do not take; errors of the picture.
pub fn make(memory: MemoryScene) -> Result<MadePage> {
    let MemoryScene { mut content, renderer, backend, words } = memory;
    let program = html::program()?;
    // A page says the name of the file, and not where it lay.
    let file = content.source.as_ref().and_then(|path| Path::new(path).file_name());
    content.source = file.map(OsStr::to_os_string);
    let bytes = content.pack()?;
    drop(content);
    let bug = |what: &str| Error::settings(what, "report this as a bug");
    let content = Content::unpack(&bytes).ok_or_else(|| bug("the content of the page cannot be read back"))?;
    let (camera, size, frames) = (content.camera, content.size, content.frames.len());
    let caption = content.text.caption.clone();
    let title = content.text.title.clone().unwrap_or_else(|| content.name.clone());
    let spheres = content.frames.iter().map(|frame| frame.scene.spheres.len()).sum();
    let columns = content.frames[0].columns.names().map(str::to_owned).collect();
    let shown = stage(MemoryScene { content, renderer, backend, words })?;
    let picture = shown.frame(&FrameRequest::still(camera, size), &(Arc::new(go_on) as _));
    let picture = picture.map_err(|refusal| Error::settings(refusal.message, "use other options"))?;
    let Picture { pixels: Pixels::Png(png), info } = picture.ok_or(Error::Interrupted)? else {
        return Err(bug("the page has no picture"));
    };
    let warnings = serde_json::from_value(info["warnings"].clone()).unwrap_or_default();
    let html = Html::new((&title, caption.as_deref()), size, &program, &bytes, &png)?;
    let Html { text, program: program_bytes, content: content_bytes } = html;
    Ok(MadePage { html: text, frames, spheres, columns, program_bytes, content_bytes, warnings })
}

impl Page {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        let (given, matches) = Given::typed(&own(Self::augment_args(Command::new("page"))), &OWN, "remove it")?;
        let mut kept = Vec::new();
        for text in matches.get_raw("columns").into_iter().flatten() {
            kept.extend(ColumnNames::with_others(&text.to_string_lossy())?.1);
        }
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
        let SceneArgs { read, color, camera, .. } = &self.args;
        let others = [&read.topology, &camera.from, &camera.list.file].into_iter().flatten().chain(&read.add).cloned();
        let inputs: Vec<_> = others.chain(color.map_file()).chain([self.args.path().to_path_buf()]).collect();
        check_inputs([path], &inputs)?;
        let settings = self.args.settings(&[]);
        let text = PageText { title: self.title.clone(), caption: self.caption.clone() };
        let content = Content { text, ..content(&given, self.args.read.frames.as_ref(), &kept)? };
        // The file is read before a device is opened.
        let renderer = Arc::new(Mutex::new(Some(Renderer::new(&settings)?)));
        let made = make(MemoryScene { content, renderer, backend: settings.backend, words: flags })?;
        write_atomically(path, |out| out.write_all(made.html.as_bytes()))?;
        warn(&made.warnings);
        note(format_args!("{}: {:.1} MB", path.display(), made.html.len() as f64 * 1e-6));
        if self.json {
            print_json(&Report {
                schema: 1,
                version: env!("CARGO_PKG_VERSION"),
                output: path,
                frames: made.frames,
                spheres: made.spheres,
                columns: made.columns,
                bytes: made.html.len(),
                program_bytes: made.program_bytes,
                content_bytes: made.content_bytes,
                warnings: made.warnings,
            })?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
