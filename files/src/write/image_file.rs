//! Image files of every format: opens, reads and writes them.

use super::digest::Digest;
use super::format::FileFormat;
use super::rows::{Found, SeekRead, pulled};
use super::{copy, exr, npy, npz, pfm, png};
use halfline::error::{Error, Place, Result};
use halfline::memory::check;
use std::fs::File;
use std::io::{self, BufReader, Cursor};
use std::path::Path;

pub use super::cryptomatte::MatteHead;
pub use super::layer::{LayerFormat, SampleType};
pub use super::rows::{Head, Rows, Sink};

impl Head {
    /// The most bytes that reading or writing the file in `format` needs at once.
    pub fn memory(&self, format: FileFormat) -> u64 {
        let row = self.rows() as u64;
        // A band's samples as read, as converted, and as encoded.
        let band = 4 * row * self.band_rows() as u64;
        band + match format {
            FileFormat::Exr => exr::memory(row),
            FileFormat::Png => png::memory(row),
            FileFormat::Tiff | FileFormat::Jpeg | FileFormat::WebP => copy::memory(self),
            _ => 0,
        }
    }
}

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
        type OpenFile = for<'b> fn(Box<dyn SeekRead + 'b>, &str) -> Result<Found<'b>>;
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
            if let Some(format) = copy::detect(start) {
                let problem = format!("a {} file is a copy of a picture and is not read back", format.name());
                return Err(Error::scene(Place::file(name), problem, "render to .png too, and use that file"));
            }
            let problem = format!("not a {} file with provenance", FileFormat::endings(FileFormat::is_read));
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

/// The content of one file, in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageFile {
    /// Its format, which its content shows.
    pub format: FileFormat,
    /// Everything but its samples.
    pub head: Head,
    /// The samples of each layer in little-endian bytes, row by row from the top, channels innermost.
    pub samples: Vec<Vec<u8>>,
}

impl ImageFile {
    /// Reads a complete file that halfline wrote; the format is detected from the content.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Limits`] for one that does not fit into memory,
    /// [`Error::Scene`] at the file for one that is malformed, truncated, changed, or has no provenance.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display().to_string();
        Self::of(Opened::file(path, &name)?, &name)
    }

    /// Reads a file from memory; errors refer to it by `name`.
    ///
    /// # Errors
    /// As [`ImageFile::read`].
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self> {
        Self::of(Opened::new(Box::new(Cursor::new(bytes)), name)?, name)
    }

    fn of(Opened { format, head, mut rows }: Opened<'_>, name: &str) -> Result<Self> {
        check(head.bytes(), || format!("the samples of {name}"))?;
        let mut samples = vec![Vec::new(); head.layers()];
        let mut digest = Digest::new(&head);
        for band in head.bands() {
            for (layer, all) in samples.iter_mut().enumerate() {
                let some = rows.rows(layer, band.clone())?;
                digest.update(layer, &some);
                all.extend_from_slice(&some);
            }
        }
        digest.check(&head.provenance, name)?;
        Ok(Self { format, head, samples })
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
        FileFormat::Tiff => copy::write_tiff(head, rows, out),
        FileFormat::Jpeg => copy::write_jpeg(head, rows, out),
        FileFormat::WebP => copy::write_webp(head, rows, out),
        FileFormat::Raw => {
            head.form()?;
            head.bands().try_for_each(|band| out.write_all(&pulled(rows, 0, band)?))
        }
    }
}
