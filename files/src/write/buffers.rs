//! The buffers of a file as named arrays, whatever its format and program.

use super::{exr, npy, npz, pfm, png};
use halfline::error::{Error, Place, Result};
use halfline::frame::array::Array;
use halfline::frame::provenance::Provenance;
use halfline::memory::check;
use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;

/// A buffer of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedBuffer {
    /// Its name in the file, such as `depth`; `None` where the file has none.
    pub name: Option<String>,
    /// Its values.
    pub array: Array,
}

/// A file's buffers.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameFile {
    /// The file's name, for messages.
    pub name: String,
    /// The buffers in the file's order.
    pub buffers: Vec<NamedBuffer>,
    /// Column and row of the first pixel in the full frame, where the format stores it.
    pub origin: Option<[i32; 2]>,
}

impl FrameFile {
    /// Reads a .png, .npy, .npz, .exr or .pfm file, detected by content; `-` is standard input.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] at a malformed file, [`Error::Limits`] for one
    /// that does not fit into memory.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(&bytes_of(path)?, &path.display().to_string())
    }

    /// Reads a file from memory; errors refer to it by `name`.
    ///
    /// # Errors
    /// As [`FrameFile::read`].
    pub fn from_bytes(bytes: &[u8], name: &str) -> Result<Self> {
        let (buffers, origin) = match bytes {
            [0x89, b'P', b'N', b'G', ..] => (vec![(png_buffer(bytes), png::read(bytes, name)?)], None),
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => (vec![(trailed_buffer(bytes), npy::read(bytes, name)?)], None),
            [b'P', b'K', 3 | 5, 4 | 6, ..] => (npz::read(bytes, name)?, None),
            [0x76, 0x2f, 0x31, 0x01, ..] => exr::read(bytes, name)?,
            [b'P', b'F' | b'f', white, ..] if white.is_ascii_whitespace() => {
                (vec![(trailed_buffer(bytes), pfm::read(bytes, name)?)], None)
            }
            _ => {
                let mend = "use a frame that halfline wrote; .raw files do not store a shape";
                return Err(Error::scene(Place::file(name), "not a PNG, EXR, PFM, .npy or .npz file", mend));
            }
        };
        let buffers = buffers.into_iter().map(|(name, array)| NamedBuffer { name, array }).collect();
        Ok(Self { name: name.to_owned(), buffers, origin })
    }
}

/// All bytes of a file, or of standard input for `-`, as long as there is memory for twice as many.
///
/// # Errors
/// [`Error::Io`], [`Error::Limits`].
fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    let mut input: Box<dyn Read> = match super::file::is_standard(path) {
        true => Box::new(std::io::stdin().lock()),
        false => Box::new(File::open(path).map_err(|error| Error::read(path, error))?),
    };
    let mut bytes = Vec::new();
    loop {
        let more = bytes.len().max(1 << 16);
        check(more as u64, || format!("more of {} than its first {} bytes", path.display(), bytes.len()))?;
        bytes.reserve_exact(more);
        let read = Read::take(&mut input, more as u64).read_to_end(&mut bytes);
        if read.map_err(|error| Error::read(path, error))? < more {
            return Ok(bytes);
        }
    }
}

/// The only buffer named in a provenance text.
fn single(buffers: Option<&str>) -> Option<String> {
    // In a PNG alpha is a channel of colour.
    let name = buffers?.strip_suffix(",alpha").unwrap_or(buffers?);
    (!name.contains(',')).then(|| name.to_owned())
}

/// The buffer named after the numbers of a .npy or .pfm.
fn trailed_buffer(bytes: &[u8]) -> Option<String> {
    // The trailer is short text; the numbers before it may contain any bytes.
    const LONGEST: usize = 1 << 16;
    let tail = &bytes[bytes.len().saturating_sub(LONGEST)..];
    let starts = tail.windows(10).enumerate().filter(|(_, window)| *window == b"\nhalfline ").map(|(at, _)| at);
    let words = starts.rev().find_map(|at| Provenance::from_trailer(&tail[at..]))?;
    single(words.get("halfline:buffers"))
}

/// The buffer named in the text chunks of a PNG.
fn png_buffer(bytes: &[u8]) -> Option<String> {
    let reader = ::png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
    let chunk = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == "halfline:buffers")?;
    single(Some(&chunk.get_text().ok()?))
}
