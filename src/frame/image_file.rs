//! The content of an image file: samples of buffers as the format stores them, and their provenance. Writers read rows
//! of samples from [`Rows`] and readers provide them, so no file is in memory as a whole. A file is a function of its
//! head and its rows, so merging tiles row by row gives the file of the full frame.

use super::format::FileFormat;
use super::provenance::Provenance;
use super::{Aov, exr, npy, npz, pfm, png};
use crate::error::{Error, Place, Result};
use crate::memory::check;
use crate::window::Window;
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Seek, Write};
use std::ops::Range;
use std::path::Path;

/// The type of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleType {
    /// A level of 0 to 255, or a byte.
    U8,
    /// A level of 0 to 65535.
    U16,
    /// A 32-bit unsigned integer.
    U32,
    /// A 32-bit integer.
    I32,
    /// A 32-bit float.
    F32,
    /// A 64-bit float.
    F64,
}

impl SampleType {
    /// Bytes per sample.
    pub fn size(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// How a file stores a buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerFormat {
    /// The buffer. Colour with four channels has alpha as the last.
    pub aov: Aov,
    /// The type of its samples.
    pub kind: SampleType,
    /// Samples per pixel.
    pub channels: usize,
}

impl LayerFormat {
    /// Bytes per pixel.
    pub fn pixel(&self) -> usize {
        self.kind.size() * self.channels
    }
}

/// Everything in a file except its samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// Its buffers, in the order of [`Aov::ALL`].
    pub forms: Vec<LayerFormat>,
    /// Their provenance.
    pub provenance: Provenance,
    /// The window in the full frame.
    pub window: Window,
    /// W and H of the full frame.
    pub full: [u32; 2],
}

impl Head {
    /// The head of a file in `format` with this provenance; `None` if the provenance is not that of such a file.
    pub(super) fn new(format: FileFormat, provenance: Provenance) -> Option<Self> {
        let (window, full, buffers) = (provenance.window()?, provenance.full()?, provenance.buffers()?);
        let forms = format.forms(&buffers, provenance.bits())?;
        Some(Self { forms, provenance, window, full })
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.window.width() as usize, self.window.height() as usize]
    }

    /// Bytes per row of one buffer.
    pub(super) fn row(&self, layer: usize) -> usize {
        self.size()[0] * self.forms[layer].pixel()
    }

    /// Bytes per row of all buffers.
    fn rows(&self) -> usize {
        (0..self.forms.len()).map(|layer| self.row(layer)).sum()
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
        (BYTES / self.rows().max(1)).max(1).next_multiple_of(exr::ROWS)
    }

    /// The most bytes that reading or writing the file in `format` needs at once.
    pub fn memory(&self, format: FileFormat) -> u64 {
        let row = self.rows() as u64;
        // A band's samples as read, as converted, and as encoded.
        let band = 4 * row * self.band_rows() as u64;
        band + if format == FileFormat::Exr { exr::memory(row) } else { 0 }
    }
}

/// Samples, row by row from the top, channels innermost, in little-endian bytes.
pub trait Rows: Send {
    /// The rows of one buffer of the head. Files that are compressed as a whole give rows in order only.
    ///
    /// # Errors
    /// The errors of reading the file, [`Error::Scene`] for a malformed one.
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>>;
}

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

/// An opened file.
pub(super) struct Opened<'a> {
    pub(super) format: FileFormat,
    pub(super) head: Head,
    pub(super) rows: Box<dyn Rows + 'a>,
}

impl<'a> Opened<'a> {
    /// Opens the file at `path`.
    ///
    /// # Errors
    /// See [`ImageFile::read`].
    pub(super) fn file(path: &Path, name: &str) -> Result<Self> {
        let file = File::open(path).map_err(|error| Error::read(path, error))?;
        Self::new(Box::new(BufReader::with_capacity(1 << 16, file)), name)
    }

    /// Reads the head from `input`; errors refer to it by `name`.
    ///
    /// # Errors
    /// See [`ImageFile::read`].
    pub(super) fn new(mut input: Box<dyn SeekRead + 'a>, name: &str) -> Result<Self> {
        type OpenFile = for<'b> fn(Box<dyn SeekRead + 'b>, &str) -> Result<Option<(Head, Box<dyn Rows + 'b>)>>;
        let formats: [(&[u8], FileFormat, OpenFile); 6] = [
            (png::MAGIC, FileFormat::Png, png::open),
            (exr::MAGIC, FileFormat::Exr, exr::open),
            (npy::MAGIC, FileFormat::Npy, npy::open),
            (npz::MAGIC, FileFormat::Npz, npz::open),
            (b"PF\n", FileFormat::Pfm, pfm::open),
            (b"Pf\n", FileFormat::Pfm, pfm::open),
        ];
        let start = input.fill_buf().map_err(|error| Error::read(name, error))?;
        let Some((_, format, open)) = formats.into_iter().find(|(magic, ..)| start.starts_with(magic)) else {
            let problem =
                format!("not a {} file with provenance", FileFormat::endings(|format| format != FileFormat::Raw));
            return Err(Error::scene(Place::file(name), problem, "use files that halfline render wrote"));
        };
        let (head, rows) = open(input, name)?.ok_or_else(|| {
            let problem = "the file has no provenance";
            Error::scene(
                Place::file(name),
                problem,
                "use files as halfline render wrote them, not edited by other programs",
            )
        })?;
        Ok(Self { format, head, rows })
    }
}

/// One buffer as a file stores it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layer<'a> {
    /// The buffer. Colour with four channels has alpha as the last.
    pub aov: Aov,
    /// The type of its samples.
    pub kind: SampleType,
    /// Samples per pixel.
    pub channels: usize,
    /// The samples in little-endian bytes, row by row from the top, channels innermost.
    pub bytes: Cow<'a, [u8]>,
}

/// The content of one file, in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFile<'a> {
    /// The buffers, in the order of [`Aov::ALL`].
    pub layers: Vec<Layer<'a>>,
    /// Their provenance.
    pub provenance: Provenance,
    /// The window in the full frame.
    pub window: Window,
    /// W and H of the full frame.
    pub full: [u32; 2],
}

impl ImageFile<'static> {
    /// Reads a complete file that halfline wrote; the format is detected from the content.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Limits`] for one that does not fit into memory,
    /// [`Error::Scene`] at the file for one that is malformed, truncated, changed, or has no provenance.
    pub fn read(path: &Path) -> Result<(FileFormat, Self)> {
        let name = path.display().to_string();
        Self::of(Opened::file(path, &name)?, &name)
    }

    /// Reads a file from memory; errors refer to it by `name`.
    ///
    /// # Errors
    /// As [`ImageFile::read`].
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<(FileFormat, Self)> {
        Self::of(Opened::new(Box::new(Cursor::new(bytes)), name)?, name)
    }

    fn of(Opened { format, head, mut rows }: Opened<'_>, name: &str) -> Result<(FileFormat, Self)> {
        check(head.bytes(), || format!("the samples of {name}"))?;
        let mut layers: Vec<Layer<'static>> = Vec::new();
        for LayerFormat { aov, kind, channels } in head.forms.iter().copied() {
            layers.push(Layer { aov, kind, channels, bytes: Cow::Owned(Vec::new()) });
        }
        let mut digest = super::digest::Digest::new(layers.len());
        for band in head.bands() {
            for (n, layer) in layers.iter_mut().enumerate() {
                let samples = rows.rows(n, band.clone())?;
                digest.update(n, &samples);
                layer.bytes.to_mut().extend_from_slice(&samples);
            }
        }
        digest.check(&head.provenance, name)?;
        let Head { provenance, window, full, .. } = head;
        Ok((format, Self { layers, provenance, window, full }))
    }
}

/// Writes the file of `head` and `rows`.
///
/// # Errors
/// The errors of `out` and `rows`, and `InvalidInput` for buffers that the format cannot hold.
pub(super) fn write(format: FileFormat, head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    match format {
        FileFormat::Png => png::write_sheet(head, rows, out),
        FileFormat::Exr => exr::write(head, rows, out),
        FileFormat::Npy => npy::write_sheet(head, rows, out),
        FileFormat::Npz => npz::write(head, rows, out),
        FileFormat::Pfm => pfm::write(head, rows, out),
        FileFormat::Raw => {
            head.form()?;
            head.bands().try_for_each(|band| out.write_all(&pulled(rows, 0, band)?))
        }
    }
}

/// The error for buffers that a format cannot hold.
pub(super) fn invalid(why: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

/// The error for a file of `format` that cannot be read.
pub(super) fn malformed(name: &str, format: &str, why: impl std::fmt::Display) -> Error {
    Error::scene(Place::file(name), format!("the {format} file is damaged or incomplete: {why}"), "render it again")
}
