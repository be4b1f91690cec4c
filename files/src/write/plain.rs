//! Samples that a file holds uncompressed: .npy, .npz and .pfm.

use super::format::FileFormat;
use super::rows::{Found, Head, Rows, SeekRead, malformed};
use halfline::error::{Error, Result};
use halfline::frame::provenance::Provenance;
use std::borrow::Cow;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
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

/// Opens a file of one buffer. `layout` has the positions of the first number and of the end of all, from the first bytes
/// of the file and its length; `header` is the one that the file's head would give.
pub(super) fn open<'a>(
    mut input: Box<dyn SeekRead + 'a>,
    name: &str,
    format: FileFormat,
    layout: impl FnOnce(&[u8], u64) -> Result<[u64; 2]>,
    header: impl FnOnce(&Head) -> io::Result<Vec<u8>>,
) -> Result<Found<'a>> {
    let failed = |error| Error::read(name, error);
    let mut start = Vec::new();
    input.rewind().and_then(|()| Read::take(&mut input, HEADER).read_to_end(&mut start)).map_err(failed)?;
    let length = input.seek(SeekFrom::End(0)).map_err(failed)?;
    let [first, end] = layout(&start, length)?;
    if length - end > LONGEST {
        return Ok(None);
    }
    let mut tail = Vec::new();
    input.seek(SeekFrom::Start(end)).and_then(|_| input.read_to_end(&mut tail)).map_err(failed)?;
    let words = Provenance::from_trailer(&tail);
    let Some(head) = words.and_then(|words| Head::new(format, words)) else { return Ok(None) };
    if !header(&head).is_ok_and(|header| start.starts_with(&header)) {
        return Ok(None);
    }
    let bottom_up = (format == FileFormat::Pfm).then_some(head.size()[1]);
    let layers = vec![(first, head.row(0))];
    let rows = Plain { input, name: name.into(), layers, bottom_up, samples: Vec::new() };
    Ok(Some((head, Box::new(rows))))
}

/// The longest header that halfline writes.
const HEADER: u64 = 1 << 12;

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
