//! The command `halfline`: runs, prints at most one error, exits with its code.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::arguments().and_then(|arguments| cli::run(&arguments)).unwrap_or_else(|error| cli::fail(&error))
}
