//! Plots of a measurement, each as SVG and as PNG. They use only the record; [`growth`] has a separate plot.

mod axis;
mod canvas;
mod cells;
mod crops;
pub mod growth;
mod heat;
pub mod inset;
mod ladder;
pub mod legend;
mod look;
mod plane;
mod raster;

use super::record::Record;
use super::total::main_place;
use halfline::error::{Error, Result};
use halfline_files::write::file;
use std::io;
use std::path::{Path, PathBuf};

/// A drawn plot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plot {
    /// Stem of its files.
    pub name: &'static str,
    /// An explanation for readers.
    pub caption: &'static str,
    /// The picture as an SVG file.
    pub svg: String,
    /// The picture as a PNG file, 2000 pixels wide.
    pub png: Vec<u8>,
}

/// One kind of plot.
struct Kind {
    name: &'static str,
    caption: &'static str,
    /// Whether the record has the necessary data.
    applies: fn(&Record) -> bool,
    draw: fn(&Record) -> look::Drawn<canvas::Drawing>,
}

/// The list of plots, and the data that each one needs.
const KINDS: [Kind; 7] = [
    Kind {
        name: "speed-error",
        caption: "Lower and further left is better. A method below and to the left of the line would dominate all others.",
        applies: is_timed,
        draw: |record| plane::draw(record, plane::Against::Wrong),
    },
    Kind {
        name: "speed-distance",
        caption: "The same against the largest relative error of a distance, where the right sphere is shown.",
        applies: is_timed,
        draw: |record| plane::draw(record, plane::Against::Distance),
    },
    Kind {
        name: "error-distance",
        caption: "The share of wrong pixels. Methods without wrong pixels are side by side at the bottom.",
        applies: has_distances,
        draw: |record| ladder::draw(record, ladder::Against::Wrong),
    },
    Kind {
        name: "error-distance-t",
        caption: "The largest relative error of a distance, where the right sphere is shown.",
        applies: has_distances,
        draw: |record| ladder::draw(record, ladder::Against::Distance),
    },
    Kind {
        name: "error-distance-outline",
        caption: "The change of radius, relative to it, that would make every wrong pixel right.",
        applies: has_distances,
        draw: |record| ladder::draw(record, ladder::Against::Outline),
    },
    Kind {
        name: "heat",
        caption: "The largest relative error of the distance in each cell of the image, on one scale for all methods.",
        applies: |record| heat::place(record).is_some(),
        draw: heat::draw,
    },
    Kind {
        name: "crops",
        caption: "The middle of each picture as it was rendered; wrong pixels are coloured.",
        applies: |record| crops::place(record).is_some(),
        draw: crops::draw,
    },
];

fn is_timed(record: &Record) -> bool {
    record.runs.iter().any(|run| run.refused.is_none() && !run.steady_ms.is_empty())
}

/// A single distance needs no axis.
fn has_distances(record: &Record) -> bool {
    let Some(place) = main_place(record) else { return false };
    let here = record.runs.iter().filter(|run| run.place == place && run.refused.is_none());
    let mut distances =
        here.filter_map(|run| record.scenes.get(run.scene)?.farthest).filter(|distance| *distance > 0.0);
    distances.next().is_some_and(|first| distances.any(|other| other != first))
}

/// Every plot that the record has the data for.
///
/// # Errors
/// [`Error::Io`] at the plot's name if drawing fails.
pub fn plots(record: &Record) -> Result<Vec<Plot>> {
    let drawn = |kind: &Kind| {
        let drawing = (kind.draw)(record).map_err(|error| Error::write(kind.name, io::Error::other(error)))?;
        Ok(Plot { name: kind.name, caption: kind.caption, svg: drawing.svg, png: drawing.png })
    };
    KINDS.iter().filter(|kind| (kind.applies)(record)).map(drawn).collect()
}

impl Plot {
    /// Writes `NAME.svg` and `NAME.png` into an existing folder.
    ///
    /// # Errors
    /// [`Error::Io`] naming the file.
    pub fn write(&self, dir: &Path) -> Result<[PathBuf; 2]> {
        let paths = ["svg", "png"].map(|ending| dir.join(format!("{}.{ending}", self.name)));
        file::write_atomically(&paths[0], |out| out.write_all(self.svg.as_bytes()))?;
        file::write_atomically(&paths[1], |out| out.write_all(&self.png))?;
        Ok(paths)
    }
}

#[cfg(test)]
pub(crate) mod sample;
#[cfg(test)]
mod tests;
