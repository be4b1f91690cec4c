//! What a file holds: samples of buffers as it stores them, and where they come from. Writers take rows of samples and
//! readers give them, so that no file is ever in memory as a whole; a file is a function of its head and its rows, so tiles
//! that are put together row by row give the full frame's file.

use super::format::Format;
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
pub enum Kind {
    /// A level of 0 to 255, or a byte.
    U8,
    /// A level of 0 to 65535.
    U16,
    /// A count.
    U32,
    /// An index.
    I32,
    /// A number.
    F32,
    /// A number.
    F64,
}

impl Kind {
    /// Bytes of a sample.
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
pub struct Form {
    /// Which one. Colour of four channels has alpha as its last.
    pub aov: Aov,
    /// The type of its samples.
    pub kind: Kind,
    /// Samples of a pixel.
    pub channels: usize,
}

impl Form {
    /// Bytes of a pixel.
    pub fn pixel(&self) -> usize {
        self.kind.size() * self.channels
    }
}

/// All that a file says besides its samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// Its buffers, in the order of [`Aov::ALL`].
    pub forms: Vec<Form>,
    /// Where they come from.
    pub provenance: Provenance,
    /// Which part of the full frame.
    pub window: Window,
    /// W and H of the full frame.
    pub full: [u32; 2],
}

impl Head {
    /// Of a file in `format` with this provenance; `None` if that is not what one says.
    pub(super) fn new(format: Format, provenance: Provenance) -> Option<Self> {
        let (window, full, buffers) = (provenance.window()?, provenance.full()?, provenance.buffers()?);
        let forms = format.forms(&buffers, provenance.bits())?;
        Some(Self { forms, provenance, window, full })
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.window.width() as usize, self.window.height() as usize]
    }

    /// Bytes of a row of one buffer.
    pub(super) fn row(&self, layer: usize) -> usize {
        self.size()[0] * self.forms[layer].pixel()
    }

    /// Bytes of a row of all buffers.
    fn rows(&self) -> usize {
        (0..self.forms.len()).map(|layer| self.row(layer)).sum()
    }

    /// Bytes of all samples.
    pub fn bytes(&self) -> u64 {
        self.rows() as u64 * self.size()[1] as u64
    }

    /// The only buffer, for formats that hold one.
    ///
    /// # Errors
    /// `InvalidInput` where there are none or several.
    pub(super) fn form(&self) -> io::Result<Form> {
        match self.forms[..] {
            [form] => Ok(form),
            _ => Err(invalid(format!("{} buffers do not go into a file for one", self.forms.len()))),
        }
    }

    /// All rows, so many at a time that their samples are some megabytes.
    pub(super) fn bands(&self) -> impl DoubleEndedIterator<Item = Range<usize>> + use<> {
        let (rows, height) = (self.band_rows(), self.size()[1]);
        (0..height.div_ceil(rows)).map(move |n| n * rows..(n * rows + rows).min(height))
    }

    /// A multiple of what EXR compresses together.
    pub(super) fn band_rows(&self) -> usize {
        const BYTES: usize = 4 << 20;
        (BYTES / self.rows().max(1)).max(1).next_multiple_of(exr::ROWS)
    }

    /// Bytes that reading or writing the file in `format` needs at once, at most.
    pub fn memory(&self, format: Format) -> u64 {
        let row = self.rows() as u64;
        // The samples of a band as they come, as they are wanted, and what is made of them.
        let band = 4 * row * self.band_rows() as u64;
        band + if format == Format::Exr { exr::memory(row) } else { 0 }
    }
}

/// Samples, row by row from the top, channels innermost, in little-endian bytes.
pub trait Rows: Send {
    /// Those of one buffer of the head. Files that are compressed as a whole give rows in order only.
    ///
    /// # Errors
    /// What reading the file runs into, [`Error::Scene`] for one that is malformed.
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>>;
}

/// Rows for a writer, whose errors are the system's: [`super::atomic`] takes ours out of them again.
pub(super) fn pulled(rows: &mut dyn Rows, layer: usize, range: Range<usize>) -> io::Result<Cow<'_, [u8]>> {
    rows.rows(layer, range).map_err(io::Error::other)
}

/// Where bytes come from.
pub(super) trait Input: BufRead + Seek + Send {}

impl<T: BufRead + Seek + Send> Input for T {}

/// Where a file is written to.
pub trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

/// A file that was opened.
pub(super) struct Opened<'a> {
    pub(super) format: Format,
    pub(super) head: Head,
    pub(super) rows: Box<dyn Rows + 'a>,
}

impl<'a> Opened<'a> {
    /// The file at `path`.
    ///
    /// # Errors
    /// See [`Sheet::read`].
    pub(super) fn file(path: &Path, name: &str) -> Result<Self> {
        let file = File::open(path).map_err(|error| Error::read(path, error))?;
        Self::new(Box::new(BufReader::with_capacity(1 << 16, file)), name)
    }

    /// What `input` holds; `name` is what errors call it.
    ///
    /// # Errors
    /// See [`Sheet::read`].
    pub(super) fn new(mut input: Box<dyn Input + 'a>, name: &str) -> Result<Self> {
        type Open = for<'b> fn(Box<dyn Input + 'b>, &str) -> Result<Option<(Head, Box<dyn Rows + 'b>)>>;
        let formats: [(&[u8], Format, Open); 6] = [
            (png::MAGIC, Format::Png, png::open),
            (exr::MAGIC, Format::Exr, exr::open),
            (npy::MAGIC, Format::Npy, npy::open),
            (npz::MAGIC, Format::Npz, npz::open),
            (b"PF\n", Format::Pfm, pfm::open),
            (b"Pf\n", Format::Pfm, pfm::open),
        ];
        let start = input.fill_buf().map_err(|error| Error::read(name, error))?;
        let Some((_, format, open)) = formats.into_iter().find(|(magic, ..)| start.starts_with(magic)) else {
            let problem =
                format!("no {} that tells where it comes from", Format::endings(|format| format != Format::Raw));
            return Err(Error::scene(Place::file(name), problem, "give files that halfline render wrote"));
        };
        let (head, rows) = open(input, name)?.ok_or_else(|| {
            let problem = "the file does not tell what part of which rendering it is";
            Error::scene(Place::file(name), problem, "give files as halfline render wrote them, not changed by others")
        })?;
        Ok(Self { format, head, rows })
    }
}

/// One buffer as a file stores it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layer<'a> {
    /// Which one. Colour of four channels has alpha as its last.
    pub aov: Aov,
    /// The type of its samples.
    pub kind: Kind,
    /// Samples of a pixel.
    pub channels: usize,
    /// The samples in little-endian bytes, row by row from the top, channels innermost.
    pub bytes: Cow<'a, [u8]>,
}

/// The content of one file, in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sheet<'a> {
    /// The buffers, in the order of [`Aov::ALL`].
    pub layers: Vec<Layer<'a>>,
    /// Where they come from.
    pub provenance: Provenance,
    /// Which part of the full frame.
    pub window: Window,
    /// W and H of the full frame.
    pub full: [u32; 2],
}

impl Sheet<'static> {
    /// Reads the whole of a file that halfline wrote, and tells its format by content.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Limits`] for one that does not fit the memory,
    /// [`Error::Scene`] at the file for one that is malformed, cut short, changed, or does not say where it comes from.
    pub fn read(path: &Path) -> Result<(Format, Self)> {
        let name = path.display().to_string();
        Self::of(Opened::file(path, &name)?, &name)
    }

    /// The same of a file's bytes; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Sheet::read`].
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<(Format, Self)> {
        Self::of(Opened::new(Box::new(Cursor::new(bytes)), name)?, name)
    }

    fn of(Opened { format, head, mut rows }: Opened<'_>, name: &str) -> Result<(Format, Self)> {
        check(head.bytes(), || format!("the samples of {name}"))?;
        let mut layers: Vec<Layer<'static>> = Vec::new();
        for Form { aov, kind, channels } in head.forms.iter().copied() {
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
/// `out`'s own, those of `rows`, and `InvalidInput` for buffers that the format does not hold.
pub(super) fn write(format: Format, head: &Head, rows: &mut dyn Rows, out: &mut dyn Sink) -> io::Result<()> {
    match format {
        Format::Png => png::write_sheet(head, rows, out),
        Format::Exr => exr::write(head, rows, out),
        Format::Npy => npy::write_sheet(head, rows, out),
        Format::Npz => npz::write(head, rows, out),
        Format::Pfm => pfm::write(head, rows, out),
        Format::Raw => {
            head.form()?;
            head.bands().try_for_each(|band| out.write_all(&pulled(rows, 0, band)?))
        }
    }
}

/// What does not go into a format.
pub(super) fn invalid(why: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, why)
}

/// A file of that format which cannot be read.
pub(super) fn malformed(name: &str, format: &str, why: impl std::fmt::Display) -> Error {
    Error::scene(Place::file(name), format!("not a whole {format}: {why}"), "render it again")
}
