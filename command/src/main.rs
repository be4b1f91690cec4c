//! The command `halfline`: runs, prints at most one error, exits with its code.

use std::process::ExitCode;

fn main() -> ExitCode {
    halfline_command::command(std::env::args_os()).into()
}
