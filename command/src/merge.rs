//! `halfline merge TILE... -o FULL`.

use super::clash::check_inputs;
use super::messages::QuietArgs;
use super::process::ExitCode;
use super::{go_on, note, say};
use halfline::error::{Error, Result};
use halfline::quote::count;
use halfline_files::write::file::{check_writable, is_special, is_standard_output};
use halfline_files::write::format::FileFormat;
use halfline_files::write::merge::{Mosaic, Tile};
use std::path::PathBuf;

/// Merges tiles into the full frame: byte for byte the file that rendering the whole frame would have written.
///
/// Tiles are files of one format that `halfline render` wrote with --tile or --crop; each contains its position. The
/// tiles must cover every pixel exactly once and belong to one rendering: the same scene, size, settings, adapter,
/// driver and program. Otherwise nothing is written, and the error names the tiles that differ or overlap and the
/// missing parts (exit code 3).
/// Examples:
///   halfline merge tile-*.png -o full.png
///   halfline merge left.exr right.exr -o both.exr
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Merge {
    /// The tiles, in any order.
    #[arg(required = true, value_name = "TILE")]
    tiles: Vec<PathBuf>,
    /// The full frame, with the file name extension of the tiles; - is standard output.
    #[arg(short, long, value_name = "FULL")]
    output: PathBuf,
    #[command(flatten)]
    quiet: QuietArgs,
}

impl Merge {
    pub(crate) fn run(&self) -> Result<ExitCode> {
        self.quiet.apply();
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
        if !has_no_ending && FileFormat::of(&self.output) != Some(format) {
            let problem = format!("the tiles are {} files, but {output} is not", format.ending());
            return Err(Error::settings(problem, format!("use the file name extension {}", format.ending())));
        }
        mosaic.warnings().iter().for_each(|warning| say(format_args!("warning: {warning}")));
        mosaic.write(&self.output, &go_on)?;
        let ([width, height], n) = (mosaic.size(), mosaic.len());
        note(format_args!("merged {} into {output}, {width} x {height} pixels", count(n as u64, "tile")));
        Ok(ExitCode::SUCCESS)
    }
}
