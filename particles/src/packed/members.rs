//! Data of gzip and bzip2 behind each other, and the bytes behind the last of them as `gzip` and `bzip2` take them.

use bzip2::bufread::BzDecoder;
use flate2::bufread::GzDecoder;
use std::io::{self, BufRead, Read};

/// The decoder of one of the data, until the next begins.
enum Member<R> {
    Gzip(GzDecoder<Ahead<R>>),
    Bzip2(BzDecoder<Ahead<R>>),
    End,
}

/// The content of all data.
pub(super) struct Members<R>(Member<R>);

impl<R: BufRead> Members<R> {
    pub(super) fn gzip(reader: R) -> Self {
        Self(Member::Gzip(GzDecoder::new(Ahead::new(reader))))
    }

    pub(super) fn bzip2(reader: R) -> Self {
        Self(Member::Bzip2(BzDecoder::new(Ahead::new(reader))))
    }
}

impl<R: BufRead> Read for Members<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = match &mut self.0 {
                Member::Gzip(decoder) => decoder.read(bytes)?,
                Member::Bzip2(decoder) => decoder.read(bytes)?,
                Member::End => return Ok(0),
            };
            if read > 0 || bytes.is_empty() {
                return Ok(read);
            }
            self.0 = match std::mem::replace(&mut self.0, Member::End) {
                Member::Gzip(decoder) => {
                    let mut rest = decoder.into_inner();
                    if rest.is_padding()? { Member::End } else { Member::Gzip(GzDecoder::new(rest)) }
                }
                Member::Bzip2(decoder) => {
                    let mut rest = decoder.into_inner();
                    if rest.is_stream()? { Member::Bzip2(BzDecoder::new(rest)) } else { Member::End }
                }
                Member::End => Member::End,
            };
        }
    }
}

/// A reader whose next bytes were looked at.
struct Ahead<R> {
    /// These bytes, and the number of those that were delivered.
    start: Vec<u8>,
    passed: usize,
    reader: R,
}

impl<R: BufRead> Ahead<R> {
    fn new(reader: R) -> Self {
        Self { start: Vec::new(), passed: 0, reader }
    }

    /// Whether zeros follow up to the end, or nothing. Tapes are filled with them.
    fn is_padding(&mut self) -> io::Result<bool> {
        loop {
            let buffer = self.fill_buf()?;
            let zeros = buffer.iter().take_while(|byte| **byte == 0).count();
            if zeros < buffer.len() || buffer.is_empty() {
                // A member does not begin with a zero, so what follows zeros is none.
                return Ok(buffer.is_empty());
            }
            self.consume(zeros);
        }
    }

    /// Whether a stream of bzip2 follows. Other bytes are ignored, but not the beginning of a stream. Streams without content are
    /// passed, because a decoder of each would take longer than its bytes.
    fn is_stream(&mut self) -> io::Result<bool> {
        const EMPTY: [u8; 10] = [0x17, 0x72, 0x45, 0x38, 0x50, 0x90, 0, 0, 0, 0];
        loop {
            for (k, of) in [&b"B"[..], b"Z", b"h", b"123456789"].into_iter().enumerate() {
                match self.look(k)? {
                    None if k > 0 => return Err(io::ErrorKind::UnexpectedEof.into()),
                    Some(byte) if of.contains(&byte) => {}
                    _ => return Ok(false),
                }
            }
            for (k, byte) in EMPTY.into_iter().enumerate() {
                if self.look(4 + k)? != Some(byte) {
                    return Ok(true);
                }
            }
            self.consume(4 + EMPTY.len());
        }
    }

    /// The byte behind so many bytes; `None` at the end.
    fn look(&mut self, bytes: usize) -> io::Result<Option<u8>> {
        self.start.drain(..std::mem::take(&mut self.passed));
        while self.start.len() <= bytes {
            let Some(next) = self.reader.fill_buf()?.first().copied() else { return Ok(None) };
            self.start.push(next);
            self.reader.consume(1);
        }
        Ok(Some(self.start[bytes]))
    }
}

impl<R: BufRead> BufRead for Ahead<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.passed < self.start.len() { Ok(&self.start[self.passed..]) } else { self.reader.fill_buf() }
    }

    fn consume(&mut self, bytes: usize) {
        if self.passed < self.start.len() {
            self.passed += bytes;
        } else {
            self.reader.consume(bytes);
        }
    }
}

impl<R: BufRead> Read for Ahead<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(bytes)?;
        self.consume(read);
        Ok(read)
    }
}
