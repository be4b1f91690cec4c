//! Binary files as a sequence of bytes, with the place of every byte. What is read grows with the content of the file,
//! not with the counts in its header.

use crate::input::{Input, fill};
use crate::source::Source;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::reserve;
use std::io::BufRead;
use std::path::{Path, PathBuf};

/// A binary file.
pub(crate) struct BinaryFile {
    reader: Input,
    path: PathBuf,
}

/// The remedy for a damaged file.
pub(crate) const DAMAGED: &str = "the file is damaged; copy or write it again";

/// The most bytes that a list grows by at a time.
const STEP: usize = 1 << 20;

/// Skips at most `most` bytes, fewer at the end of the file; returns their number.
///
/// # Errors
/// Errors of reading the file.
pub(crate) fn skip(reader: &mut impl BufRead, path: &Path, most: u64) -> Result<u64> {
    let mut left = most;
    while left > 0 {
        let block = reader.fill_buf().map_err(|e| Error::read(path, e))?.len();
        if block == 0 {
            break;
        }
        let passed = left.min(block as u64);
        reader.consume(passed as usize);
        left -= passed;
    }
    Ok(most - left)
}

impl BinaryFile {
    pub(crate) fn new(source: Source) -> Self {
        Self { reader: source.reader, path: source.path }
    }

    /// The rest of a file that was read to its data.
    pub(crate) fn of(reader: Input, path: PathBuf) -> Self {
        Self { reader, path }
    }

    /// The position of the next byte, from 0.
    pub(crate) fn at(&self) -> u64 {
        self.reader.position()
    }

    /// The file.
    pub(crate) fn file(&self) -> Place {
        Place::file(self.path.display().to_string())
    }

    /// An error of the field that begins at a byte.
    pub(crate) fn fail(&self, byte: u64, field: &str, problem: impl Into<String>, mend: &str) -> Error {
        Error::scene(self.file().named(format!("byte {byte}: {field}")), problem, mend)
    }

    /// Reports that a particle was found, which resets the limits of silent streams.
    pub(crate) fn found(&self) {
        self.reader.found();
    }

    /// Whether all bytes were read.
    ///
    /// # Errors
    /// Errors of reading the file.
    pub(crate) fn is_end(&mut self) -> Result<bool> {
        Ok(self.reader.fill_buf().map_err(|e| Error::read(&self.path, e))?.is_empty())
    }

    /// Reads exactly these bytes of a field.
    ///
    /// # Errors
    /// [`Error::Scene`] where the file ends before the last of them, and errors of reading the file.
    pub(crate) fn fill(&mut self, bytes: &mut [u8], field: &str) -> Result<()> {
        let began = self.at();
        match fill(&mut self.reader, bytes).map_err(|e| Error::read(&self.path, e))? {
            found if found < bytes.len() => Err(self.ends(began, found as u64, bytes.len() as u64, field)),
            _ => Ok(()),
        }
    }

    /// Reads a field of `N` bytes.
    ///
    /// # Errors
    /// As [`BinaryFile::fill`].
    pub(crate) fn bytes<const N: usize>(&mut self, field: &str) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        self.fill(&mut bytes, field)?;
        Ok(bytes)
    }

    /// Replaces the content of `into` with the next `count` bytes. The list grows with the bytes that exist.
    ///
    /// # Errors
    /// As [`BinaryFile::fill`], and [`Error::Limits`].
    pub(crate) fn block(&mut self, count: u64, into: &mut Vec<u8>, field: &str) -> Result<()> {
        into.clear();
        let began = self.at();
        while (into.len() as u64) < count {
            let done = into.len();
            let step = (count - done as u64).min(STEP as u64) as usize;
            reserve(into, step)?;
            into.resize(done + step, 0);
            let found = fill(&mut self.reader, &mut into[done..]).map_err(|e| Error::read(&self.path, e))?;
            if found < step {
                return Err(self.ends(began, (done + found) as u64, count, field));
            }
        }
        Ok(())
    }

    /// Replaces the content of `into` with the rest of the file.
    ///
    /// # Errors
    /// [`Error::Limits`], and errors of reading the file.
    pub(crate) fn all(&mut self, into: &mut Vec<u8>) -> Result<()> {
        into.clear();
        loop {
            let block = self.reader.fill_buf().map_err(|e| Error::read(&self.path, e))?;
            let length = block.len();
            if length == 0 {
                return Ok(());
            }
            reserve(into, length)?;
            into.extend_from_slice(block);
            self.reader.consume(length);
        }
    }

    /// Skips `count` bytes.
    ///
    /// # Errors
    /// As [`BinaryFile::fill`].
    pub(crate) fn pass(&mut self, count: u64, field: &str) -> Result<()> {
        let began = self.at();
        match self.skip(count)? {
            passed if passed < count => Err(self.ends(began, passed, count, field)),
            _ => Ok(()),
        }
    }

    /// Skips at most `most` bytes, fewer at the end of the file; returns their number.
    ///
    /// # Errors
    /// Errors of reading the file.
    pub(crate) fn skip(&mut self, most: u64) -> Result<u64> {
        skip(&mut self.reader, &self.path, most)
    }

    /// The error for a file that ends after `found` of the `count` bytes of a field, which begins at a byte.
    fn ends(&self, byte: u64, found: u64, count: u64, field: &str) -> Error {
        let problem = format!("the file ends after {found} of {count} bytes");
        self.fail(byte, field, problem, "the file was cut short or is damaged; copy or write it again")
    }
}
