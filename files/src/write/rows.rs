//! The content of an image file: samples of buffers as the format stores them, and their provenance. Writers read rows
//! of samples from [`Rows`] and readers provide them, so no file is in memory as a whole. A file is a function of its
//! head and its rows, so merging tiles row by row gives the file of the full frame.

use super::cryptomatte::{CHANNELS, MatteHead};
use super::format::{Bits, FileFormat};
use super::layer::{LayerFormat, SampleType};
use halfline::error::{Error, Place, Result};
use halfline::frame::array::Array;
use halfline::frame::provenance::Provenance;
use halfline::window::Window;
use halfline_particles::blocks;
use std::borrow::Cow;
use std::io::{self, BufRead, Seek, Write};
use std::ops::Range;

/// Rows per compressed block of EXR.
pub(super) const EXR_ROWS: usize = 16;

/// Everything in a file except its samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// Its buffers, in the order of [`Aov::ALL`](halfline::Aov::ALL).
    pub forms: Vec<LayerFormat>,
    /// The Cryptomatte layers after the buffers.
    pub mattes: Vec<MatteHead>,
    /// Their provenance.
    pub provenance: Provenance,
    /// The window in the full frame.
    pub window: Window,
    /// W and H of the full frame.
    pub full: [u32; 2],
}

impl Head {
    /// The head of a file in `format` with this provenance; `None` if the provenance is not from such a file.
    pub(super) fn new(format: FileFormat, provenance: Provenance) -> Option<Self> {
        let (window, full, buffers) = (provenance.window()?, provenance.full()?, provenance.buffers()?);
        let forms = format.forms(&buffers, Bits::of(&provenance), provenance.lights(), provenance.has_wide_ids())?;
        Some(Self { forms, mattes: Vec::new(), provenance, window, full })
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.window.width() as usize, self.window.height() as usize]
    }

    /// The number of layers: buffers and mattes.
    pub(super) fn layers(&self) -> usize {
        self.forms.len() + self.mattes.len()
    }

    /// Bytes per pixel of one layer.
    pub(super) fn pixel(&self, layer: usize) -> usize {
        self.forms.get(layer).map_or(CHANNELS * SampleType::F32.size(), LayerFormat::pixel)
    }

    /// Bytes per row of one layer.
    pub(super) fn row(&self, layer: usize) -> usize {
        self.size()[0] * self.pixel(layer)
    }

    /// Bytes per row of all layers.
    pub(super) fn rows(&self) -> usize {
        (0..self.layers()).map(|layer| self.row(layer)).sum()
    }

    /// Bytes of all samples.
    pub fn bytes(&self) -> u64 {
        self.rows() as u64 * self.size()[1] as u64
    }

    /// The only buffer, for formats that hold a single one.
    ///
    /// # Errors
    /// `InvalidInput` where there is none or more than one.
    pub(super) fn form(&self) -> io::Result<LayerFormat> {
        match self.forms[..] {
            [form] => Ok(form),
            _ => Err(invalid(format!("{} buffers do not fit into a format for one", self.forms.len()))),
        }
    }

    /// All rows in bands of several megabytes.
    pub(super) fn bands(&self) -> impl DoubleEndedIterator<Item = Range<usize>> + use<> {
        let (rows, height) = (self.band_rows(), self.size()[1]);
        (0..height.div_ceil(rows)).map(move |n| n * rows..(n * rows + rows).min(height))
    }

    /// A multiple of the rows that EXR compresses together.
    pub(super) fn band_rows(&self) -> usize {
        const BYTES: usize = 4 << 20;
        (blocks::at_most(BYTES) / self.rows().max(1)).max(1).next_multiple_of(EXR_ROWS)
    }
}

/// Samples, row by row from the top, channels innermost, in little-endian bytes.
pub trait Rows: Send {
    /// The rows of one layer of the head. Files that are compressed as a whole give rows in order only.
    ///
    /// # Errors
    /// The errors of reading the file, [`Error::Scene`] for a malformed one.
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>>;
}

/// The head and the rows of an opened file; `None` where it has no provenance.
pub(super) type Found<'a> = Option<(Head, Box<dyn Rows + 'a>)>;

/// Arrays by the names of their buffers.
pub(super) type NamedArrays = Vec<(Option<String>, Array)>;

/// Rows for a writer, with errors wrapped as the system's; [`super::atomic`] unwraps them.
pub(super) fn pulled(rows: &mut dyn Rows, layer: usize, range: Range<usize>) -> io::Result<Cow<'_, [u8]>> {
    rows.rows(layer, range).map_err(io::Error::other)
}

/// A byte source.
pub(super) trait SeekRead: BufRead + Seek + Send {}

impl<T: BufRead + Seek + Send> SeekRead for T {}

/// A byte destination.
pub trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

/// The error for buffers that a format cannot hold.
pub(super) fn invalid(why: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

/// The error for a file of `format` that cannot be read.
pub(super) fn malformed(name: &str, format: &str, why: impl std::fmt::Display) -> Error {
    Error::scene(Place::file(name), format!("the {format} file is damaged or incomplete: {why}"), "render it again")
}
