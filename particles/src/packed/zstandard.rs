//! Frames of Zstandard (RFC 8878), one behind the other, with those that are to be skipped. The checksum and the length of the
//! content are verified where a frame has them.

use crate::gauge::Counts;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::io::{self, BufRead, Read};
use std::sync::Arc;

/// The content of all frames.
pub(super) struct Frames<R> {
    source: Source<R>,
    frame: Option<Frame>,
    counts: Arc<Counts>,
    /// The most bytes of a window.
    window: u64,
}

/// The frame that is being decompressed.
struct Frame {
    decoder: FrameDecoder,
    /// Bytes that were delivered.
    length: u64,
}

impl<R: BufRead> Frames<R> {
    pub(super) fn new(reader: R, counts: Arc<Counts>, window: u64) -> Self {
        Self {
            source: Source { reader, error: None, is_end: false, start: [0; 5], known: 0 },
            frame: None,
            counts,
            window,
        }
    }

    /// Begins the next frame; returns false at the end of the file.
    fn begin(&mut self) -> io::Result<bool> {
        if self.source.reader.fill_buf()?.is_empty() {
            return Ok(false);
        }
        // A decoder that is used again reserves the window of the header.
        let mut decoder = FrameDecoder::new();
        decoder.set_max_window_size(self.window);
        self.source.known = 0;
        match decoder.reset(&mut self.source) {
            // RFC 8878, 3.1.1.1.1.4.
            Ok(()) if self.source.start[4] & RESERVED > 0 => {
                return Err(io::Error::new(io::ErrorKind::InvalidData, "the reserved bit of a frame's header is set"));
            }
            Ok(()) => self.frame = Some(Frame { decoder, length: 0 }),
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                let mut rest = self.source.by_ref().take(length.into());
                if io::copy(&mut rest, &mut io::sink())? < length.into() {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
            }
            Err(error) => return Err(self.source.error_of(error)),
        }
        Ok(true)
    }
}

impl<R: BufRead> Read for Frames<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            let Some(Frame { decoder, length }) = &mut self.frame else {
                match self.begin()? {
                    true => continue,
                    false => return Ok(0),
                }
            };
            if decoder.can_collect() > 0 {
                let read = decoder.read(bytes)?;
                *length += read as u64;
                return Ok(read);
            }
            if decoder.is_finished() {
                check(decoder, *length)?;
                self.frame = None;
            } else {
                // Bytes are delivered when there are more than the window has.
                let more = decoder.decode_blocks(&mut self.source, BlockDecodingStrategy::UptoBytes(1));
                let at_end = more.map_err(|error| self.source.error_of(error))?;
                if !at_end || decoder.can_collect() > 0 {
                    self.counts.unpacked();
                }
            }
        }
    }
}

/// The bit of a frame's descriptor that is reserved.
const RESERVED: u8 = 1 << 3;

/// Checks the content of a frame against its checksum and its length.
fn check(decoder: &FrameDecoder, length: u64) -> io::Result<()> {
    let problem = match decoder.get_checksum_from_data() {
        Some(sum) if decoder.get_calculated_checksum() != Some(sum) => "the checksum differs",
        // 0 is also the length of frames that do not say it.
        _ if ![0, length].contains(&decoder.content_size()) => "the length of the content differs",
        _ => return Ok(()),
    };
    Err(io::Error::new(io::ErrorKind::InvalidData, problem))
}

/// The compressed bytes, and the error of reading them, which the decoder returns as one of the data.
struct Source<R> {
    reader: R,
    error: Option<io::Error>,
    /// Whether the decoder reads on behind the last byte.
    is_end: bool,
    /// The magic number and the descriptor of the frame, and how many of these bytes were read.
    start: [u8; 5],
    known: usize,
}

impl<R: Read> Read for Source<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.reader.read(bytes);
        if let (Ok(read), true) = (&read, self.known < self.start.len()) {
            let more = (self.start.len() - self.known).min(*read);
            self.start[self.known..self.known + more].copy_from_slice(&bytes[..more]);
            self.known += more;
        }
        self.is_end |= matches!(read, Ok(0)) && !bytes.is_empty();
        read.map_err(|error| {
            let kind = error.kind();
            if kind != io::ErrorKind::Interrupted {
                self.error = Some(error);
            }
            kind.into()
        })
    }
}

impl<R> Source<R> {
    /// The error of the source, or else of the data.
    fn error_of(&mut self, error: FrameDecoderError) -> io::Error {
        let is_long = matches!(error, FrameDecoderError::WindowSizeTooBig { .. });
        let kind = if is_long { io::ErrorKind::OutOfMemory } else { io::ErrorKind::InvalidData };
        match self.error.take() {
            Some(error) => error,
            None if self.is_end => io::ErrorKind::UnexpectedEof.into(),
            None => io::Error::new(kind, error.to_string()),
        }
    }
}
