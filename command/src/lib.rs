#![doc = include_str!("../README.md")]
//!
//! # The library
//!
//! [`command`] is the whole command, for the wheel of the Python package and for the binary.

#![cfg_attr(
    not(feature = "view"),
    expect(
        dead_code,
        unreachable_pub,
        reason = "the subcommands view and page alone use some of what others share with them"
    )
)]

mod adapters;
mod bar;
mod camera_args;
mod camera_file;
mod camera_list;
#[cfg(feature = "view")]
pub mod choices;
mod clash;
#[cfg(feature = "measure")]
mod compare;
mod config;
mod cut_args;
mod exhaustion;
mod failure;
mod figure;
mod figure_args;
mod file_args;
mod film;
mod framing;
mod help;
mod info;
mod inset_args;
#[cfg(not(all(feature = "measure", feature = "view")))]
mod left_out;
mod legend;
mod lens_args;
mod light_args;
mod lines;
#[cfg(feature = "measure")]
mod measure;
mod merge;
mod messages;
mod names;
mod option_table;
#[cfg(feature = "view")]
mod page;
mod picture_scene;
mod picture_size;
mod plan;
mod preview;
mod process;
mod read_args;
mod render;
mod scene_args;
mod scene_frames;
mod shell;
mod sift;
mod signals;
mod standard;
mod tally;
mod threads;
mod together;
mod trace;
mod typed;
mod values;
#[cfg(feature = "view")]
mod view;
mod visible;
#[cfg(not(target_arch = "wasm32"))]
mod workers;

#[cfg(not(feature = "measure"))]
use left_out::{self as compare, self as measure};
#[cfg(not(feature = "view"))]
use left_out::{self as page, self as view};

/// The page of `halfline view` for the widget of the Python package, and for pages without a server.
#[cfg(feature = "view")]
pub mod shown {
    pub use crate::messages::{flags, in_page};
    pub use crate::option_table::{Call, Form, keywords, of_keyword};
    pub use crate::page::{MadePage, make as make_page};
    pub use crate::view::{Content, MemoryScene, PageText, WrittenOption, pose, stage};
}

/// Items that lanes work on together, in order; the Python package renders frames so.
#[cfg(feature = "view")]
pub use threads::pipeline;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use config::Config;
use failure::fail;
use halfline::error::Result;
use halfline_files::write::file::refuse_standard_output;
use process::ExitCode;
use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

/// Renders spheres, from atoms to planets, and bounds the error of every pixel.
#[derive(Debug, Parser)]
#[command(
    name = "halfline",
    version,
    about = "A GPU compute ray tracer for spheres, from atoms to planets: headless, fast, and it says how far from exact it is"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::Render>),
    Info(info::Info),
    Adapters(adapters::Adapters),
    Compare(compare::Compare),
    Merge(merge::Merge),
    Measure(Box<measure::Measure>),
    Page(Box<page::Page>),
    Plan(Box<plan::PlanArgs>),
    Sift(Box<sift::Sift>),
    Trace(Box<trace::Trace>),
    View(Box<view::View>),
    Completions(shell::Completions),
    Man(shell::Man),
}

/// Runs the command with these arguments, beginning with its name, and prints at most one error; the exit code.
pub fn command(given: impl Iterator<Item = OsString>) -> u8 {
    process::start(given);
    if standard::output_is_closed() {
        refuse_standard_output();
    }
    arguments().and_then(run).unwrap_or_else(|error| fail(&error)).0
}

/// The parsed arguments: flags, else environment variables, else the configuration file, else the defaults.
/// Clap prints usage errors itself and exits with 2.
fn arguments() -> Result<Arguments> {
    exhaustion::listen();
    let known = || {
        page::with_own_options(sift::with_own_options(view::without_files(plan::of_a_picture(Arguments::command()))))
    };
    let configured = Config::load().and_then(|config| config.apply(known()));
    let (command, fault) = match configured {
        Ok(command) => (command, None),
        Err(fault) => (Config::default().apply(known())?, Some(fault)),
    };
    read_args::check_range(process::all_arguments())?;
    let words = inset_args::joined(process::all_arguments().iter().cloned());
    let parsed = help::on_one_screen(command.clone(), &words).try_get_matches_from(words);
    let mut matches = parsed.unwrap_or_else(|error| end(&help::translated(error)));
    // A configuration file that cannot be read is an error only for commands that use it; help does not.
    if let Some(fault) = fault.filter(|_| matches.subcommand_name().is_some_and(config::is_configured)) {
        return Err(fault);
    }
    Arguments::from_arg_matches_mut(&mut matches).or_else(|error| end(&error.format(&mut command.clone())))
}

/// Prints a message of clap and ends the process. Help and version are results, so failing to print them is an error.
fn end(error: &clap::Error) -> ! {
    // Without any argument the commands that most people need say more than a list of options.
    if error.use_stderr() && process::arguments().eq(["render"]) {
        let _ = io::stderr().write_all(render::START.as_bytes());
        std::process::exit(2);
    }
    failure::print_usage(error);
    let arrived = error.print().and_then(|()| io::stdout().flush()).and_then(|()| standard::check_output());
    std::process::exit(if arrived.is_err() && !error.use_stderr() { 8 } else { error.exit_code() })
}

/// Runs the chosen subcommand.
fn run(arguments: Arguments) -> Result<ExitCode> {
    // RUST_LOG: a level, or TARGET=LEVEL between commas. Without it, or where it cannot be read, nothing is logged.
    let levels = std::env::var("RUST_LOG").ok().and_then(|text| text.parse::<Targets>().ok()).unwrap_or_default();
    let colored = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    // Where standard error cannot be written, the subscriber would report that to standard error, and panic.
    let log = tracing_subscriber::fmt::layer().with_ansi(colored).with_writer(io::stderr).log_internal_errors(false);
    tracing_subscriber::registry().with(log.with_filter(levels)).init();
    signals::listen();
    #[cfg(not(target_arch = "wasm32"))]
    workers::start();
    match arguments.command {
        Command::Render(render) => render.run(),
        Command::Info(info) => info.run(),
        Command::Adapters(adapters) => adapters.run(),
        Command::Compare(compare) => compare.run(),
        Command::Merge(merge) => merge.run(),
        Command::Measure(measure) => measure.run(),
        Command::Page(page) => page.run(),
        Command::Plan(plan) => plan.run(),
        Command::Sift(sift) => sift.run(),
        Command::Trace(trace) => trace.run(),
        Command::View(view) => view.run(),
        Command::Completions(completions) => completions.run(Arguments::command()),
        Command::Man(man) => man.run(Arguments::command()),
    }
}
