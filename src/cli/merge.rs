//! `halfline merge TILE... -o FULL`.

use super::{go_on, say};
use halfline::error::{Error, Result};
use halfline::frame::file::{check_writable, is_standard, write_sheet};
use halfline::frame::format::Format;
use halfline::frame::merge::{Tile, merge};
use halfline::frame::sheet::Sheet;
use std::path::PathBuf;
use std::process::ExitCode;

/// Puts tiles together into the full frame, byte for byte the file that rendering it whole would have written.
///
/// Tiles are files of one format that `halfline render` wrote with --tile or --crop; they say themselves where they belong.
/// Nothing is written unless they hold every pixel once, of one rendering: the same scene, size, settings, adapter, driver
/// and program. Otherwise the tiles that are foreign or overlap, and the parts that are missing, are named (exit code 3).
///
/// Examples:
///   halfline merge tile-*.png -o full.png
///   halfline merge left.exr right.exr -o both.exr
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Merge {
    /// The tiles, in any order.
    #[arg(required = true, value_name = "TILE")]
    tiles: Vec<PathBuf>,
    /// The full frame, in the tiles' format: its ending must be theirs; - is standard output.
    #[arg(short, long, value_name = "FULL")]
    output: PathBuf,
}

impl Merge {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        check_writable(&self.output)?;
        let mut tiles = Vec::with_capacity(self.tiles.len());
        for path in &self.tiles {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            let (format, sheet) = Sheet::read(path)?;
            tiles.push(Tile { name: path.display().to_string(), format, sheet });
        }
        let (format, sheet) = merge(&tiles)?;
        if !is_standard(&self.output) && Format::of(&self.output) != Some(format) {
            let problem = format!("the tiles are {} files, {} is none", format.ending(), self.output.display());
            return Err(Error::settings(problem, format!("end its name in {}", format.ending())));
        }
        if !go_on() {
            return Err(Error::Interrupted);
        }
        write_sheet(&sheet, format, &self.output)?;
        let ([width, height], n) = (sheet.full, tiles.len());
        say(format_args!("{n} tiles are {width} x {height} pixels: {}", self.output.display()));
        Ok(ExitCode::SUCCESS)
    }
}
