//! `halfline view FILE`: a page that finds the camera.

mod content;
mod controls;
mod frames;
mod gather;
mod given;
mod handler;
mod lens;
mod memory;
mod moving;
mod parse;
mod pick;
mod python;
mod reading;
mod summary;

pub use content::{Content, PageText};
pub(crate) use gather::content;
pub(crate) use given::Given;
pub use given::WrittenOption;
pub use lens::pose;
pub use memory::MemoryScene;
pub(crate) use parse::Parser;

use super::messages::{QuietArgs, note};
use super::option_table::{NO_VIEW, has, hidden};
use super::process::ExitCode;
use super::scene_args::SceneArgs;
use super::signals::go_on;
use super::standard::print;
use clap::{Args, Command};
use halfline::error::{Error, Result};
use halfline_files::read::read_once;
use halfline_viewer::{Server, Stage, open_browser, ssh_line};
use handler::ViewHandler;
use std::fs::File;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// The answers to the page of a scene in memory.
///
/// # Errors
/// Errors of the options and of the camera with which it begins.
pub fn stage(scene: MemoryScene) -> Result<Arc<dyn Stage>> {
    Ok(Arc::new(ViewHandler::in_memory(scene)?))
}

/// Shows a scene on a page of the browser: find the camera by looking, pick spheres, and copy the command that renders what
/// is seen. The page is served to this machine alone; from a remote machine it comes through ssh.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, next_line_help = true)]
pub(crate) struct View {
    #[command(flatten)]
    args: SceneArgs,
    /// Port of 127.0.0.1; 0 for any free one [default: 8642, or a free one if it is taken].
    #[arg(long, help_heading = PAGE, value_name = "N")]
    port: Option<u16>,
    /// Opens no browser.
    #[arg(long, help_heading = PAGE)]
    no_open: bool,
    /// Ends after this time without a request, such as 30m, 90s or 2h [default: when it is interrupted].
    #[arg(long, help_heading = PAGE, value_name = "TIME", value_parser = duration)]
    idle: Option<Duration>,
    #[command(flatten)]
    quiet: QuietArgs,
}

/// The heading of the options of the page.
const PAGE: &str = "Page";

const EXAMPLES: &str = "\
The command takes the options of halfline render that read, select, colour and light. The page has keys: ? lists them.

Examples:
  halfline view 3SN6.cif --color-by chain
  halfline view run.dump --color-by velocity --range 0,3 --look plain
  halfline view particles.npy --port 8700 --no-open --idle 30m";

/// The options of `halfline view` alone.
const OWN: [&str; 4] = ["port", "no_open", "idle", "quiet"];

/// The command line in which `view` has only the options that it takes.
pub(super) fn without_files(command: Command) -> Command {
    command.mut_subcommand("view", |view| hidden(view, |id| has(id, NO_VIEW)))
}

impl View {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
        let command = Self::augment_args(Command::new("view"));
        let (given, _) = Given::typed(&command, &OWN, "remove it; the page copies a command to which it can be added")?;
        if let Some(once) = read_once(self.args.path()) {
            return Err(Error::settings(
                format!("view reads its file again, and {once} can be read once"),
                "use a file",
            ));
        }
        // A file that is not there is an error before a page is shown.
        File::open(self.args.path()).map_err(|e| Error::read(self.args.path(), e))?;
        let server = Server::bind(self.port).map_err(|error| self.not_bound(&error))?;
        let handler = Arc::new(ViewHandler::new(given)?);
        let (url, port, stop) = (server.url(), server.port(), Arc::new(AtomicBool::new(false)));
        let serve = {
            let (handler, stop, idle) = (Arc::clone(&handler), Arc::clone(&stop), self.idle);
            thread::Builder::new().name("server".into()).spawn(move || server.run(handler, idle, &stop))
        };
        let serving = serve.map_err(|error| Error::Limits {
            problem: format!("the system allows no more threads: {error}"),
            mend: "allow more threads".into(),
        })?;
        print(&format!("{url}\n"))?;
        if let Some(line) = ssh_line(port) {
            note(format_args!("on your own machine run this, and open the address there: {line}"));
        }
        if !self.no_open && !open_browser(&url) {
            note(format_args!("open the address in a browser; ctrl-C ends"));
        }
        let loaded = handler.load();
        while loaded.is_ok() && go_on() && !serving.is_finished() {
            thread::sleep(Duration::from_millis(50));
        }
        stop.store(true, Ordering::Relaxed);
        let served = serving.join();
        loaded?;
        match served {
            Ok(Err(error)) => Err(Error::write("the page", error)),
            _ if !go_on() => Ok(ExitCode(130)),
            _ => Ok(ExitCode::SUCCESS),
        }
    }

    fn not_bound(&self, error: &std::io::Error) -> Error {
        let port = self.port.unwrap_or(halfline_viewer::PORT);
        Error::settings(format!("port {port} of 127.0.0.1 cannot be used: {error}"), "use another --port, or 0 for any")
    }
}

fn duration(text: &str) -> Result<Duration, String> {
    let expected = "expected a time such as 30m, 90s or 2h";
    let (number, unit) = text.split_at(text.trim_end_matches(char::is_alphabetic).len());
    let scale = match unit {
        "s" | "" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(expected.into()),
    };
    let seconds = number.parse::<f64>().ok().map(|number| number * scale);
    let seconds = seconds.filter(|seconds| (0.1..=1e9).contains(seconds)).ok_or(expected)?;
    Ok(Duration::from_secs_f64(seconds))
}
