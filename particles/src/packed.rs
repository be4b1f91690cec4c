//! Compression of files: recognised by the first bytes, and undone in a stream. Data that follow each other in one file (members
//! of gzip, streams of bzip2 and xz, frames of Zstandard) are one content.

mod members;
#[cfg(feature = "formats")]
mod zstandard;

use super::gauge::Counts;
use halfline_ground::error::Error;
#[cfg(feature = "formats")]
use lzma_rust2::XzReader;
use members::Members;
use std::io::{self, BufRead, Read};
use std::sync::Arc;

/// The line that brings the formats that a build lacks.
pub(crate) const WHOLE: &str = "cargo install --path command brings all formats";

/// The first bytes that show a compression.
pub(super) const MAGIC: u64 = 6;

/// The most bytes of decompressed content that data may refer back to: `zstd -d` takes no more by itself, and the levels of xz have
/// half of it. A window grows with its content.
const WINDOW: u64 = 128 << 20;

/// The same for a block of xz, in KiB, with what its decoder needs besides.
const XZ_MEMORY: u32 = (WINDOW >> 10) as u32 + 128;

/// A compression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packing {
    Gzip,
    Bzip2,
    Xz,
    Zstandard,
}

impl Packing {
    /// The compression of a file with these first bytes; [`MAGIC`] of them are enough.
    pub(super) fn of(start: &[u8]) -> Option<Self> {
        match start {
            [0x1f, 0x8b, _, ..] => Some(Self::Gzip),
            [b'B', b'Z', b'h', ..] => Some(Self::Bzip2),
            [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => Some(Self::Xz),
            // A frame, or one to be skipped, which other programs put before it.
            [0x28, 0xb5, 0x2f, 0xfd, ..] | [0x50..=0x5f, 0x2a, 0x4d, 0x18, ..] => Some(Self::Zstandard),
            _ => None,
        }
    }

    /// The decompressed content of `raw`; `counts` gets notice of decompressed bytes that are not delivered yet.
    #[cfg_attr(not(feature = "formats"), expect(unused_variables, reason = "Zstandard alone counts"))]
    pub(super) fn reader(self, raw: impl BufRead + Send + 'static, counts: &Arc<Counts>) -> Unpacked {
        let reader: Box<dyn Read + Send> = match self {
            Self::Gzip => Box::new(Members::gzip(raw)),
            Self::Bzip2 => Box::new(Members::bzip2(raw)),
            #[cfg(feature = "formats")]
            Self::Xz => Box::new(XzReader::new_mem_limit(raw, true, XZ_MEMORY)),
            #[cfg(feature = "formats")]
            Self::Zstandard => Box::new(zstandard::Frames::new(raw, Arc::clone(counts), WINDOW)),
            #[cfg(not(feature = "formats"))]
            Self::Xz | Self::Zstandard => Box::new(Refused(self)),
        };
        Unpacked { reader, packing: self }
    }

    /// Its name, and the program that tests and decompresses it.
    fn names(self) -> [&'static str; 2] {
        match self {
            Self::Gzip => ["gzip", "gzip"],
            Self::Bzip2 => ["bzip2", "bzip2"],
            Self::Xz => ["xz", "xz"],
            Self::Zstandard => ["Zstandard", "zstd"],
        }
    }
}

/// Decompressed bytes.
pub(super) struct Unpacked {
    reader: Box<dyn Read + Send>,
    packing: Packing,
}

impl Read for Unpacked {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.reader.read(bytes).map_err(|error| self.error(error))
    }
}

impl Unpacked {
    /// The error with the program that tests or decompresses the file; errors of the file itself stay.
    fn error(&self, error: io::Error) -> io::Error {
        let is_ours = error.get_ref().is_some_and(|inner| inner.is::<Error>());
        let kinds = [io::ErrorKind::Interrupted, io::ErrorKind::Unsupported];
        if is_ours || error.raw_os_error().is_some() || kinds.contains(&error.kind()) {
            return error;
        }
        let [name, program] = self.packing.names();
        let test = format!("(`{program} -t` tests the file)");
        // Each decoder has its own kinds of damaged data.
        let kind = match error.kind() {
            kind @ (io::ErrorKind::OutOfMemory | io::ErrorKind::UnexpectedEof) => kind,
            _ => io::ErrorKind::InvalidData,
        };
        let text = match kind {
            io::ErrorKind::OutOfMemory => {
                let most = WINDOW >> 20;
                // By itself it has the same limit.
                let long = if self.packing == Packing::Zstandard { " -M2048MB" } else { "" };
                format!(
                    "the {name} data refer back by more than {most} MiB (`{program} -d{long}` decompresses the file)"
                )
            }
            io::ErrorKind::UnexpectedEof => format!("the {name} data end too early {test}"),
            _ => format!("the {name} data are damaged: {error} {test}"),
        };
        io::Error::new(kind, text)
    }
}

/// Data that this build does not decompress.
#[cfg(not(feature = "formats"))]
struct Refused(Packing);

#[cfg(not(feature = "formats"))]
impl Read for Refused {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        let problem = format!("this build of halfline does not decompress {}; {}", self.0.names()[0], WHOLE);
        Err(io::Error::new(io::ErrorKind::Unsupported, problem))
    }
}

#[cfg(test)]
mod tests;
