//! The command line: one file per subcommand, exit codes in one place.

mod compare;

use clap::{Parser, Subcommand};
use halfline::error::{Error, Result};
use std::process::ExitCode;

/// Renders spheres, from atoms to planets, and says how far from exact the answers are.
#[derive(Debug, Parser)]
#[command(name = "halfline", version, about)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Compare(compare::Compare),
}

/// Runs the chosen subcommand.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode> {
    match &arguments.command {
        Command::Compare(compare) => compare.run(),
    }
}

/// What a shell script may rely on. 0 is success, 1 a difference found by `compare`, 2 also what clap uses.
pub(crate) fn exit_code(error: &Error) -> u8 {
    match error {
        Error::Settings { .. } => 2,
        Error::Scene { .. } => 3,
        Error::Adapter { .. } => 4,
        Error::Limits { .. } => 5,
        Error::DeviceLost(_) => 6,
        Error::Accuracy { .. } => 7,
        Error::Io { .. } => 8,
        Error::Interrupted => 130,
        _ => 101,
    }
}
