//! Samples that a file holds uncompressed: .npy, .npz and .pfm.

use super::rows::{Rows, SeekRead, malformed};
use crate::error::{Error, Result};
use std::borrow::Cow;
use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;

/// Their positions.
pub(super) struct Plain<'a> {
    pub(super) input: Box<dyn SeekRead + 'a>,
    pub(super) name: String,
    /// For each buffer, the position of its first byte and the bytes per row.
    pub(super) layers: Vec<(u64, usize)>,
    /// The number of rows, where the last one comes first.
    pub(super) bottom_up: Option<usize>,
    pub(super) samples: Vec<u8>,
}

impl Rows for Plain<'_> {
    fn rows(&mut self, layer: usize, rows: Range<usize>) -> Result<Cow<'_, [u8]>> {
        let (start, row) = self.layers[layer];
        let first = self.bottom_up.map_or(rows.start, |height| height - rows.end);
        self.samples.resize(rows.len() * row, 0);
        let read = self.input.seek(SeekFrom::Start(start + first as u64 * row as u64));
        read.and_then(|_| self.input.read_exact(&mut self.samples)).map_err(|error| match error.kind() {
            ErrorKind::UnexpectedEof => malformed(&self.name, "data", "it ends before its last number"),
            _ => Error::read(&self.name, error),
        })?;
        if self.bottom_up.is_some() {
            reverse(&mut self.samples, row);
        }
        Ok(Cow::Borrowed(&self.samples))
    }
}

/// Reverses the order of the rows.
pub(super) fn reverse(samples: &mut [u8], row: usize) {
    let (mut first, mut last) = (0, samples.len() / row);
    while first + 1 < last {
        last -= 1;
        let (head, tail) = samples.split_at_mut(last * row);
        head[first * row..][..row].swap_with_slice(&mut tail[..row]);
        first += 1;
    }
}

/// The first bytes of a file, up to the longest header, and the file's length.
pub(super) fn start(input: &mut dyn SeekRead, name: &str) -> Result<(Vec<u8>, u64)> {
    let mut bytes = Vec::new();
    let mut read = |input: &mut dyn SeekRead| {
        input.rewind()?;
        Read::take(&mut *input, HEADER).read_to_end(&mut bytes)?;
        input.seek(SeekFrom::End(0))
    };
    let length = read(input).map_err(|error| Error::read(name, error))?;
    Ok((bytes, length))
}

/// The longest header that halfline writes.
const HEADER: u64 = 1 << 12;

/// The bytes after `from`, if they are no longer than a provenance.
pub(super) fn tail(input: &mut dyn SeekRead, from: u64, length: u64, name: &str) -> Result<Option<Vec<u8>>> {
    let Some(left) = length.checked_sub(from).filter(|left| *left <= LONGEST) else { return Ok(None) };
    let mut bytes = Vec::with_capacity(left as usize);
    let read = input.seek(SeekFrom::Start(from)).and_then(|_| Read::take(&mut *input, left).read_to_end(&mut bytes));
    read.map_err(|error| Error::read(name, error))?;
    Ok(Some(bytes))
}

/// The longest provenance with its delimiters.
const LONGEST: u64 = 1 << 17;

#[cfg(test)]
mod tests {
    use super::reverse;

    #[test]
    fn rows_are_reversed() {
        for (samples, reversed) in [(vec![1, 2], vec![1, 2]), (vec![1, 2, 3, 4, 5, 6], vec![5, 6, 3, 4, 1, 2])] {
            let mut turned = samples.clone();
            reverse(&mut turned, 2);
            assert_eq!(turned, reversed);
            reverse(&mut turned, 2);
            assert_eq!(turned, samples);
        }
        reverse(&mut [], 2);
    }
}
