//! The members of a ZIP archive, one after the other, without its directory. The crate zip reads streams too, but not
//! deflated members whose size follows them (9.8.2: "The file length is not available in the local header"), as
//! numpy.savez_compressed writes them to a pipe; rc-zip-sync (4.4.2) panics or does not end for damaged archives.

use crate::input::Input;
use flate2::CrcReader;
use flate2::bufread::DeflateDecoder;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::unquoted;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

/// The remedy where arrays are missing or malformed.
pub(super) const MEND: &str =
    "save positions of shape (n, 3) with numpy.savez, and radii and colors where there are any";

/// An archive that is read sequentially.
pub(super) struct Archive {
    pub(super) reader: Input,
    pub(super) path: PathBuf,
}

/// The header of a file in the archive.
pub(super) struct Member {
    pub(super) name: String,
    deflated: bool,
    /// Bytes in the archive; `None` if they follow the file.
    packed: Option<u64>,
    /// The checksum; `None` if it follows the file.
    crc: Option<u32>,
    /// Whether sizes after the file have 8 bytes.
    long: bool,
}

impl Archive {
    /// The next file's header; `None` at the directory.
    pub(super) fn member(&mut self) -> Result<Option<Member>> {
        let start: [u8; 4] = self.bytes()?;
        match start {
            [b'P', b'K', 3, 4] => {}
            [b'P', b'K', 1, 2] | [b'P', b'K', 5, 6] | [b'P', b'K', 6, 6] => return Ok(None),
            _ => return Err(self.fail("archive", "the archive is damaged, or has sizes only in its directory")),
        }
        let fixed: [u8; 26] = self.bytes()?;
        let two = |at: usize| u16::from_le_bytes([fixed[at], fixed[at + 1]]);
        let four = |at: usize| u32::from_le_bytes([fixed[at], fixed[at + 1], fixed[at + 2], fixed[at + 3]]);
        let (flags, method) = (two(2), two(4));
        let name = self.some(two(22).into())?;
        let name = String::from_utf8_lossy(&name).into_owned();
        let extra = self.some(two(24).into())?;
        let wide = zip64(&extra);
        let packed = match (four(14), wide) {
            (u32::MAX, Some([_, packed])) => packed,
            (packed, _) => packed.into(),
        };
        if flags & 1 != 0 || !matches!(method, 0 | 8) {
            let problem = format!("the compression method {method} of {} is not supported", unquoted(&name));
            return Err(self.fail("archive", problem));
        }
        let known = flags & 8 == 0;
        if !known && method == 0 {
            let problem = "an uncompressed array was written to a pipe, so its size follows it";
            let mend = "save with numpy.savez_compressed, or to a file";
            return Err(Error::scene(self.place("archive"), problem, mend));
        }
        Ok(Some(Member {
            name,
            deflated: method == 8,
            packed: known.then_some(packed),
            crc: known.then_some(four(10)),
            long: wide.is_some(),
        }))
    }

    /// Passes the content of a file to `read`, and then checks its length and checksum.
    pub(super) fn open(
        &mut self,
        member: &Member,
        read: impl FnOnce(&Path, &mut dyn BufRead) -> Result<()>,
    ) -> Result<()> {
        let shown = &unquoted(&member.name).to_string();
        let path = self.path.join(shown);
        let mut packed = (&mut self.reader).take(member.packed.unwrap_or(u64::MAX));
        let reader: Box<dyn Read + '_> =
            if member.deflated { Box::new(DeflateDecoder::new(&mut packed)) } else { Box::new(&mut packed) };
        let mut reader = BufReader::with_capacity(1 << 16, CrcReader::new(reader));
        read(&path, &mut reader)?;
        let failed = |e| Error::read(&self.path, e);
        io::copy(&mut reader, &mut io::sink()).map_err(failed)?;
        let sum = reader.get_ref().crc().sum();
        drop(reader);
        let left = packed.limit();
        if member.packed.is_some() {
            let passed = io::copy(&mut packed, &mut io::sink()).map_err(|e| Error::read(&self.path, e))?;
            if passed < left {
                return Err(self.fail(shown, "the file ends within it"));
            }
        }
        let crc = match member.crc {
            Some(crc) => crc,
            None => self.descriptor(member.long)?,
        };
        if crc != sum {
            return Err(self.fail(shown, "the content does not match its checksum"));
        }
        Ok(())
    }

    /// The checksum after a file of unknown size.
    fn descriptor(&mut self, long: bool) -> Result<u32> {
        let mut crc: [u8; 4] = self.bytes()?;
        // The signature is optional.
        if crc == [b'P', b'K', 7, 8] {
            crc = self.bytes()?;
        }
        self.some(if long { 16 } else { 8 })?;
        Ok(u32::from_le_bytes(crc))
    }

    fn bytes<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.reader.read_exact(&mut bytes).map_err(|e| self.cut(e))?;
        Ok(bytes)
    }

    /// Reads `count` bytes, at most 65535.
    fn some(&mut self, count: usize) -> Result<Vec<u8>> {
        let mut bytes = vec![0; count];
        self.reader.read_exact(&mut bytes).map_err(|e| self.cut(e))?;
        Ok(bytes)
    }

    fn cut(&self, error: io::Error) -> Error {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => self.fail("archive", "the file ends within it"),
            _ => Error::read(&self.path, error),
        }
    }

    fn place(&self, field: &str) -> Place {
        Place::file(self.path.display().to_string()).named(field)
    }

    fn fail(&self, field: &str, problem: impl Into<String>) -> Error {
        Error::scene(self.place(field), problem, MEND)
    }
}

/// The unpacked and packed sizes in the ZIP64 field.
fn zip64(mut extra: &[u8]) -> Option<[u64; 2]> {
    while let [a, b, c, d, rest @ ..] = extra {
        let (id, length) = (u16::from_le_bytes([*a, *b]), usize::from(u16::from_le_bytes([*c, *d])));
        let field = rest.get(..length)?;
        if id == 1 {
            let number = |at: usize| Some(u64::from_le_bytes(field.get(at..at + 8)?.try_into().ok()?));
            return Some([number(0)?, number(8)?]);
        }
        extra = &rest[length..];
    }
    None
}
