//! Subcommands that a small build leaves out: they are refused with the line that brings them.

use super::process::{ExitCode, all_arguments};
use clap::Args;
#[cfg(not(feature = "view"))]
use clap::Command;
use halfline::error::{Error, Result};
use std::ffi::OsString;

/// Not in this build: `cargo install --path command` brings it.
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub(crate) struct LeftOut {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<OsString>,
}

impl LeftOut {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        let name = all_arguments().get(1).map(|name| name.to_string_lossy()).unwrap_or_default();
        let problem = format!("this build of halfline has no {name}: it was compiled without default features");
        Err(Error::settings(problem, "cargo install --path command brings all of it"))
    }
}

#[cfg(not(feature = "measure"))]
pub(crate) use {LeftOut as Compare, LeftOut as Measure};
#[cfg(not(feature = "view"))]
pub(crate) use {LeftOut as Page, LeftOut as View};

#[cfg(not(feature = "view"))]
pub(super) fn with_own_options(command: Command) -> Command {
    command
}

#[cfg(not(feature = "view"))]
pub(super) fn without_files(command: Command) -> Command {
    command
}
