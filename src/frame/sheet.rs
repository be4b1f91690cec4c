//! What a file holds: buffers as the samples that it stores, and where they come from. Writers take a sheet and readers
//! give one; a file is a function of its sheet, so tiles that are put together as sheets give the full frame's file.

use super::format::Format;
use super::provenance::Provenance;
use super::{Aov, exr, npy, npz, pfm, png};
use crate::error::{Error, Place, Result};
use crate::window::Window;
use std::borrow::Cow;
use std::io::{self, Write};
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

impl Layer<'_> {
    /// Bytes of a pixel.
    pub fn pixel(&self) -> usize {
        self.kind.size() * self.channels
    }

    /// The samples as what `from` makes of their bytes, of which there are `N`.
    pub(super) fn samples<T, const N: usize>(&self, from: impl Fn([u8; N]) -> T) -> impl Iterator<Item = T> {
        self.bytes.as_chunks::<N>().0.iter().map(move |bytes| from(*bytes))
    }
}

/// The content of one file.
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

impl<'a> Sheet<'a> {
    /// The layers and what their provenance says; `None` if that is not what they are.
    pub fn new(layers: Vec<Layer<'a>>, provenance: Provenance) -> Option<Self> {
        let (window, full, buffers) = (provenance.window()?, provenance.full()?, provenance.buffers()?);
        let pixels = window.width() as usize * window.height() as usize;
        let whole =
            |layer: &Layer<'_>| layer.pixel() > 0 && pixels.checked_mul(layer.pixel()) == Some(layer.bytes.len());
        let mut found: Vec<Aov> = layers.iter().map(|layer| layer.aov).collect();
        if layers.iter().any(|layer| layer.aov == Aov::Color && layer.channels == 4) {
            found.push(Aov::Alpha);
        }
        (found == buffers && layers.iter().all(whole)).then_some(Self { layers, provenance, window, full })
    }

    /// The only layer, for formats that hold one.
    ///
    /// # Errors
    /// `InvalidInput` where there are none or several.
    pub(super) fn layer(&self) -> io::Result<&Layer<'a>> {
        match &self.layers[..] {
            [layer] => Ok(layer),
            layers => Err(invalid(format!("{} buffers do not go into a file for one", layers.len()))),
        }
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.window.width() as usize, self.window.height() as usize]
    }

    /// Writes the file.
    ///
    /// # Errors
    /// `out`'s own, and `InvalidInput` for layers that the format does not hold.
    pub fn write(&self, format: Format, out: &mut dyn Write) -> io::Result<()> {
        match format {
            Format::Png => png::write_sheet(self, out),
            Format::Exr => exr::write(self, out),
            Format::Npy => npy::write_sheet(self, out),
            Format::Npz => npz::write(self, out),
            Format::Pfm => pfm::write(self, out),
            Format::Raw => out.write_all(&self.layer()?.bytes),
        }
    }

    /// Reads the whole of a file that halfline wrote, and tells its format by content.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] at the file for one that is malformed, cut short, or
    /// does not say where it comes from.
    pub fn read(path: &Path) -> Result<(Format, Sheet<'static>)> {
        let bytes = std::fs::read(path).map_err(|error| Error::read(path, error))?;
        Sheet::from_bytes(&bytes, &path.display().to_string())
    }

    /// The same of a file's bytes; `name` is what errors call it.
    ///
    /// # Errors
    /// [`Error::Scene`], as [`Sheet::read`].
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<(Format, Sheet<'static>)> {
        type Reader = fn(&[u8], &str) -> Result<Option<Sheet<'static>>>;
        let readers: [(&[u8], Format, Reader); 6] = [
            (png::MAGIC, Format::Png, png::read_sheet),
            (exr::MAGIC, Format::Exr, exr::read),
            (npy::MAGIC, Format::Npy, npy::read_sheet),
            (npz::MAGIC, Format::Npz, npz::read),
            (b"PF\n", Format::Pfm, pfm::read),
            (b"Pf\n", Format::Pfm, pfm::read),
        ];
        let Some((_, format, read)) = readers.into_iter().find(|(magic, ..)| bytes.starts_with(magic)) else {
            let problem =
                format!("no {} that tells where it comes from", Format::endings(|format| format != Format::Raw));
            return Err(Error::scene(Place::file(name), problem, "give files that halfline render wrote"));
        };
        let sheet = read(bytes, name)?.ok_or_else(|| {
            let problem = "the file does not tell what part of which rendering it is";
            Error::scene(Place::file(name), problem, "give files as halfline render wrote them, not changed by others")
        })?;
        Ok((format, sheet))
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
