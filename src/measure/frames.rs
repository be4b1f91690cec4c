//! The buffers of a file as named arrays, whatever its format and program; and the buffers of two files that
//! correspond.

mod exr;
mod file;
mod npz;
mod pfm;

use super::{Array, bytes_of};
use crate::error::{Error, Place, Result};
use crate::frame::provenance::Provenance;
use crate::quote::setting::AOV;
use crate::quote::{list, quote};
use crate::write::{npy, png};
use std::io::Cursor;
use std::path::Path;

pub use file::{FrameFile, NamedBuffer};

/// Corresponding buffers of two files.
#[derive(Debug, Clone, PartialEq)]
pub struct BufferPair<'a> {
    /// Their name, where either file gives one.
    pub name: Option<&'a str>,
    /// The first file's.
    pub a: &'a Array,
    /// The second file's.
    pub b: &'a Array,
}

/// The buffers of two files, matched.
#[derive(Debug, Clone, PartialEq)]
pub struct MatchedBuffers<'a> {
    /// The buffers that both have.
    pub common: Vec<BufferPair<'a>>,
    /// Buffers that only one of them has: the buffer's name, and the file's.
    pub missing: Vec<(&'a str, &'a str)>,
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
        let one = |aov: Option<String>, array: Array| Self {
            name: name.to_owned(),
            buffers: vec![NamedBuffer { name: aov, array }],
            origin: None,
        };
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Ok(one(png_buffer(bytes), png::read(bytes, name)?)),
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => Ok(one(trailed_buffer(bytes), npy::read(bytes, name)?)),
            [b'P', b'K', 3 | 5, 4 | 6, ..] => npz::read(bytes, name),
            [0x76, 0x2f, 0x31, 0x01, ..] => exr::read(bytes, name),
            [b'P', b'F' | b'f', white, ..] if white.is_ascii_whitespace() => {
                Ok(one(trailed_buffer(bytes), pfm::read(bytes, name)?))
            }
            _ => {
                let mend = "use a frame that halfline wrote; .raw files do not store a shape";
                Err(Error::scene(Place::file(name), "not a PNG, EXR, PFM, .npy or .npz file", mend))
            }
        }
    }

    /// The array of a file with one buffer.
    #[must_use]
    pub fn into_array(mut self) -> Option<Array> {
        self.buffers.pop().filter(|_| self.buffers.is_empty()).map(|buffer| buffer.array)
    }

    /// Matches the buffers of two files: those of the same name, or those in `wanted`. If each file has a single
    /// buffer, they are matched whatever their names.
    ///
    /// # Errors
    /// [`Error::Settings`] for a name that a file does not have, and for an unnamed buffer beside several.
    pub fn pairs<'a>(a: &'a Self, b: &'a Self, wanted: &'a [String]) -> Result<MatchedBuffers<'a>> {
        if !wanted.is_empty() {
            let pair = |name: &'a String| Ok(BufferPair { name: Some(name), a: a.buffer(name)?, b: b.buffer(name)? });
            return Ok(MatchedBuffers { common: wanted.iter().map(pair).collect::<Result<_>>()?, missing: Vec::new() });
        }
        if let ([one], [other]) = (&a.buffers[..], &b.buffers[..]) {
            let name = one.name.as_deref().or(other.name.as_deref());
            return Ok(MatchedBuffers {
                common: vec![BufferPair { name, a: &one.array, b: &other.array }],
                missing: Vec::new(),
            });
        }
        for (nameless, other) in [(a, b), (b, a)] {
            if nameless.buffers.iter().any(|buffer| buffer.name.is_none()) {
                let problem =
                    format!("{} has an unnamed buffer, which may be any of those of {}", nameless.name, other.name);
                return Err(Error::settings(problem, format!("choose with {AOV}: {}", other.names())));
            }
        }
        let (mut common, mut missing) = (Vec::new(), Vec::new());
        for buffer in &a.buffers {
            let name = buffer.name.as_deref().unwrap_or_default();
            match b.buffers.iter().find(|other| other.name == buffer.name) {
                Some(other) => common.push(BufferPair { name: Some(name), a: &buffer.array, b: &other.array }),
                None => missing.push((name, &a.name[..])),
            }
        }
        let only_b = b.buffers.iter().filter(|buffer| a.buffers.iter().all(|other| other.name != buffer.name));
        missing.extend(only_b.map(|buffer| (buffer.name.as_deref().unwrap_or_default(), &b.name[..])));
        Ok(MatchedBuffers { common, missing })
    }

    fn buffer(&self, name: &str) -> Result<&Array> {
        let found = match &self.buffers[..] {
            // A file with one unnamed buffer matches any name.
            [only] if only.name.is_none() => Some(only),
            all => all.iter().find(|buffer| buffer.name.as_deref() == Some(name)),
        };
        found.map(|buffer| &buffer.array).ok_or_else(|| {
            Error::settings(
                format!("{} has no buffer {}", self.name, quote(name)),
                format!("the file has {}", self.names()),
            )
        })
    }

    fn names(&self) -> String {
        list(self.buffers.iter().filter_map(|buffer| buffer.name.as_deref()))
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

#[cfg(test)]
mod tests;
