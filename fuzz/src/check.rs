//! Checks of every target: limits of memory and time, and errors that a terminal can show.

use halfline::error::Error;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::io::Read;
use std::path::PathBuf;

/// The limits of a run.
pub(crate) struct Allowed {
    /// Peak memory in bytes.
    pub(crate) bytes: usize,
    /// Seconds of one processor; not checked in the test suite.
    #[cfg_attr(not(fuzzing), expect(dead_code, reason = "only the fuzzer looks at it"))]
    pub(crate) seconds: f64,
}

/// Bytes that a reader may use for any file: its buffers, blocks of lines, a decompressor, names of columns.
const FREE: usize = 24 << 20;

/// Bytes per byte of a file, decompressed. A byte of TOML can be a table (`files/src/read/native/room.rs`), a byte of an
/// array a number that exists in several forms.
pub(crate) const PER_BYTE: usize = 256;
pub(crate) const PER_BYTE_OF_TOML: usize = 1500;

/// The most images of an atom of a crystal whose space group is named; an atom has at least three bytes.
pub(crate) const IMAGES: usize = 192;
pub(crate) const PER_BYTE_OF_CRYSTAL: usize = 256 * IMAGES / 3;

/// Seconds per file, and per byte of it: a million times the seconds of a plain reader, on a machine with other load.
const SECONDS: f64 = 1.0;
const PER_BYTE_SECONDS: f64 = 1e-4;

/// The most points in a byte of LAZ, and the memory and time of each.
pub(crate) const POINTS_OF_LAZ: usize = 1100;
const PER_POINT: usize = 256;
const PER_POINT_SECONDS: f64 = 1e-6;

/// The most decompressed bytes that are run.
const UNPACKED: u64 = 8 << 20;

/// The most characters of an error or a warning: a place, a few quoted words, a list of names.
const LONGEST: usize = 2000;

/// The limits of a file of so many bytes.
pub(crate) fn allowed(bytes: usize, per_byte: usize) -> Allowed {
    Allowed { bytes: FREE + per_byte * bytes, seconds: SECONDS + PER_BYTE_SECONDS * bytes as f64 }
}

/// The limits of a file of so many bytes that may be LAZ.
pub(crate) fn allowed_points(bytes: usize) -> Allowed {
    let points = POINTS_OF_LAZ * bytes;
    Allowed {
        bytes: FREE + PER_BYTE_OF_TOML * bytes + PER_POINT * points,
        seconds: SECONDS + PER_BYTE_SECONDS * bytes as f64 + PER_POINT_SECONDS * points as f64,
    }
}

/// Checks that an error is short and has no control characters, and that it is the system's only where the system gave it.
pub(crate) fn check_error(error: &Error) -> String {
    let text = error.to_string();
    let is_of_content = matches!(error, Error::Io { source, .. } if source.raw_os_error().is_none());
    assert!(!is_of_content, "not the system's error: {text}");
    check_words(&text);
    text
}

pub(crate) fn check_words(text: &str) {
    let length = text.chars().count();
    assert!((1..=LONGEST).contains(&length), "{length} characters: {text:?}");
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "{text:?}");
}

/// The folder for files that readers open by name, in memory where the system has such a folder.
pub(crate) fn desk() -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    folder.join(format!("halfline-fuzz-{}", std::process::id()))
}

/// The input as a reader receives it.
pub(crate) struct Unpacked {
    pub(crate) length: usize,
    /// Whether it decompresses without error.
    pub(crate) whole: bool,
}

/// The decompressed bytes; `None` if there are too many.
pub(crate) fn unpacked(content: &[u8]) -> Option<Unpacked> {
    let (mut count, mut whole) = (0, true);
    let mut pass = |reader: &mut dyn Read| {
        let mut block = vec![0; 1 << 14];
        while count as u64 <= UNPACKED {
            match reader.read(&mut block) {
                Ok(0) => break,
                Ok(read) => count += read,
                Err(_) => {
                    whole = false;
                    break;
                }
            }
        }
    };
    match content {
        [0x1f, 0x8b, ..] => pass(&mut flate2::bufread::MultiGzDecoder::new(content)),
        [b'B', b'Z', b'h', ..] => pass(&mut bzip2::bufread::MultiBzDecoder::new(content)),
        [0xfd, b'7', b'z', ..] => pass(&mut lzma_rust2::XzReader::new(content, true)),
        [0x28, 0xb5, ..] | [0x50..=0x5f, 0x2a, ..] => pass(&mut Frames { rest: content, frame: None }),
        // Arrays of an archive are deflated separately, with a factor of at most 1032.
        [b'P', b'K', ..] => count = content.len().saturating_mul(1032),
        _ => {}
    }
    (count as u64 <= UNPACKED).then_some(Unpacked { length: count.max(content.len()), whole })
}

/// The content of frames of Zstandard.
struct Frames<'a> {
    rest: &'a [u8],
    frame: Option<FrameDecoder>,
}

impl Read for Frames<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        loop {
            let Some(frame) = &mut self.frame else {
                if self.rest.is_empty() {
                    return Ok(0);
                }
                let mut frame = FrameDecoder::new();
                match frame.reset(&mut self.rest) {
                    Ok(()) => self.frame = Some(frame),
                    Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                        length, ..
                    })) => {
                        let skipped = self.rest.split_at_checked(length as usize);
                        self.rest = skipped.ok_or(std::io::ErrorKind::UnexpectedEof)?.1;
                    }
                    Err(error) => return Err(std::io::Error::other(error)),
                }
                continue;
            };
            if frame.can_collect() > 0 {
                return frame.read(bytes);
            }
            if frame.is_finished() {
                let sums = [frame.get_checksum_from_data(), frame.get_calculated_checksum()];
                if sums[0].is_some() && sums[0] != sums[1] {
                    return Err(std::io::ErrorKind::InvalidData.into());
                }
                self.frame = None;
                continue;
            }
            let blocks = BlockDecodingStrategy::UptoBlocks(1);
            frame.decode_blocks(&mut self.rest, blocks).map_err(std::io::Error::other)?;
        }
    }
}

/// Bytes in pieces of irregular lengths.
pub(crate) struct Pieces {
    content: Vec<u8>,
    at: usize,
}

impl Pieces {
    pub(crate) fn new(content: &[u8]) -> Self {
        Self { content: content.to_vec(), at: 0 }
    }
}

impl Read for Pieces {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        let rest = &self.content[self.at..];
        let count = (1 + self.at % 7).min(rest.len()).min(bytes.len());
        bytes[..count].copy_from_slice(&rest[..count]);
        self.at += count;
        Ok(count)
    }
}
