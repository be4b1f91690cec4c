//! The command `halfline`: runs, prints at most one error, exits with its code.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    match cli::arguments().and_then(|arguments| cli::run(&arguments)) {
        Ok(code) => code,
        Err(error) => {
            cli::say(format_args!("{error}"));
            ExitCode::from(cli::exit_code(&error))
        }
    }
}
