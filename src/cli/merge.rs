//! `halfline merge TILE... -o FULL`.

use super::clash::check_inputs;
use super::{go_on, say};
use halfline::error::{Error, Result};
use halfline::frame::file::{check_writable, is_special, is_standard_output};
use halfline::frame::format::Format;
use halfline::frame::merge::{Mosaic, Tile};
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
        check_inputs([self.output.as_path()], &self.tiles)?;
        check_writable(&self.output)?;
        let mut tiles = Vec::with_capacity(self.tiles.len());
        for path in &self.tiles {
            if !go_on() {
                return Err(Error::Interrupted);
            }
            tiles.push(Tile::open(path)?);
        }
        let mosaic = Mosaic::new(tiles)?;
        let (format, output) = (mosaic.format(), self.output.display());
        let has_no_ending = is_standard_output(&self.output) || is_special(&self.output);
        if !has_no_ending && Format::of(&self.output) != Some(format) {
            let problem = format!("the tiles are {} files, {output} is none", format.ending());
            return Err(Error::settings(problem, format!("end its name in {}", format.ending())));
        }
        mosaic.warnings().iter().for_each(|warning| say(format_args!("warning: {warning}")));
        mosaic.write(&self.output, &go_on)?;
        let ([width, height], n) = (mosaic.size(), mosaic.len());
        say(format_args!("{n} tiles are {width} x {height} pixels: {output}"));
        Ok(ExitCode::SUCCESS)
    }
}
