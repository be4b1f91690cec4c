//! `--legend`: what may be a legend's file, and how it is written.

use super::clash::place;
use super::scene_args::SceneArgs;
use super::shots::{check_pattern, numbered};
use halfline::error::{Error, Result};
use halfline::frame::file::{check_writable, write_atomically};
use halfline::scene::style::Legend;
use std::path::{Path, PathBuf};

/// The file of legends that is asked for, if it can be one; told before any work.
pub(super) fn check(asked: &SceneArgs) -> Result<()> {
    let Some(path) = &asked.read.legend else { return Ok(()) };
    if !is_png(path) && !ends_in(path, "svg") {
        return Err(Error::settings(format!("{} is no legend", path.display()), "end the name in .svg or .png"));
    }
    if asked.files.names()?.iter().any(|other| place(other) == place(path)) {
        let problem = format!("{} would be written twice", path.display());
        return Err(Error::settings(problem, "name a file of its own for the legend"));
    }
    if asked.read.has_many_legends() {
        check_pattern(path)?;
    }
    Ok(())
}

/// The legend's file of the picture of this number, if it can be written.
pub(super) fn file(asked: &SceneArgs, number: u64) -> Result<Option<PathBuf>> {
    let path = asked.read.legend.as_deref().map(|path| numbered(path, number));
    path.as_deref().map_or(Ok(()), check_writable)?;
    Ok(path)
}

/// Writes a legend whole or not at all.
pub(super) fn write(legend: &Legend, path: &Path) -> Result<()> {
    let plot = legend.plot()?;
    let bytes = if is_png(path) { plot.png } else { plot.svg.into_bytes() };
    write_atomically(path, |out| out.write_all(&bytes))
}

fn is_png(path: &Path) -> bool {
    ends_in(path, "png")
}

fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}
