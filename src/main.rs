//! The command `halfline`: runs, prints at most one error, exits with its code.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::command(std::env::args_os()).into()
}
