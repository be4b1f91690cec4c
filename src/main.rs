//! The command `halfline`: run, print one error, exit with its code.

mod cli;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    match cli::run(&arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("halfline: {error}");
            ExitCode::from(cli::exit_code(&error))
        }
    }
}
