//! Numbers of an array in a file: text, bytes, or bytes in base64, perhaps in compressed blocks.

use crate::npy::header::{NumberKind, Scalar};
use crate::particles::bytes::DAMAGED;
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::read::ZlibDecoder;
use halfline_ground::error::{Error, Place};
use halfline_ground::memory::reserve;
use lzma_rust2::XzReader;
use std::io::Read;

/// The compression of blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressor {
    Zlib,
    /// Blocks without a frame and without their size.
    Lz4,
    /// A stream of xz for each block.
    Xz,
}

/// The encoding of the arrays of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Encoding {
    pub(super) big: bool,
    /// Whether the numbers before data have 8 bytes, else 4.
    pub(super) is_long: bool,
    pub(super) compressor: Option<Compressor>,
}

/// Padding may be left out or follow any run.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Bytes of an array, one after the other.
struct Bytes<'a> {
    rest: &'a [u8],
    is_base64: bool,
    /// Bytes that were decoded beyond those that were taken.
    ahead: Vec<u8>,
}

/// The problem of an array; memory that is short is another error.
pub(super) enum Fault {
    Damaged(String),
    Limits(Error),
}

impl Fault {
    /// The error of a file that is damaged at this place.
    pub(super) fn at(self, place: Place) -> Error {
        match self {
            Self::Damaged(problem) => Error::scene(place, problem, DAMAGED),
            Self::Limits(error) => error,
        }
    }
}

impl From<String> for Fault {
    fn from(problem: String) -> Self {
        Self::Damaged(problem)
    }
}

impl Bytes<'_> {
    /// The next `count` bytes.
    fn take(&mut self, count: usize) -> Result<Vec<u8>, Fault> {
        let ends = |left: usize| format!("the data end after {left} of {count} bytes");
        if !self.is_base64 {
            let (taken, rest) = self.rest.split_at_checked(count).ok_or_else(|| ends(self.rest.len()))?;
            let mut bytes = Vec::new();
            reserve(&mut bytes, count).map_err(Fault::Limits)?;
            bytes.extend_from_slice(taken);
            self.rest = rest;
            return Ok(bytes);
        }
        let mut bytes = std::mem::take(&mut self.ahead);
        // Four characters are at most three bytes.
        if count > bytes.len() + self.rest.len() / 4 * 3 + 3 {
            return Err(ends(bytes.len() + self.rest.len() / 4 * 3).into());
        }
        let mut run = Vec::new();
        while bytes.len() < count {
            // A run ends with its padding, and another one may follow.
            let most = (count - bytes.len()).div_ceil(3) * 4;
            run.clear();
            reserve(&mut run, most.min(self.rest.len())).map_err(Fault::Limits)?;
            let mut read = 0;
            for byte in self.rest {
                let is_padded = run.last() == Some(&b'=');
                if run.len() == most || *byte == b'<' || is_padded && *byte != b'=' && run.len().is_multiple_of(4) {
                    break;
                }
                read += 1;
                if !byte.is_ascii_whitespace() {
                    run.push(*byte);
                }
            }
            self.rest = &self.rest[read..];
            if run.is_empty() {
                return Err(ends(bytes.len()).into());
            }
            let decoded = BASE64.decode(&run).map_err(|error| format!("the text is not base64: {error}"))?;
            reserve(&mut bytes, decoded.len()).map_err(Fault::Limits)?;
            bytes.extend(decoded);
        }
        self.ahead = bytes.split_off(count);
        Ok(bytes)
    }
}

impl Encoding {
    /// The sizes before the data.
    fn sizes(&self, bytes: &mut Bytes<'_>, count: usize) -> Result<Vec<usize>, Fault> {
        let kind = if self.is_long { 8 } else { 4 };
        let bytes = bytes.take(count.checked_mul(kind).ok_or_else(|| format!("{count} blocks"))?)?;
        let size = |bytes: &[u8]| {
            let mut whole = [0; 8];
            whole[..kind].copy_from_slice(bytes);
            if self.big {
                whole[..kind].reverse();
            }
            usize::try_from(u64::from_le_bytes(whole)).map_err(|_| format!("{} bytes", u64::from_le_bytes(whole)))
        };
        Ok(bytes.chunks_exact(kind).map(size).collect::<Result<_, _>>()?)
    }

    /// The numbers of an array, whose bytes begin at `data`: `count` numbers of this type.
    pub(super) fn numbers(
        &self,
        data: &[u8],
        is_base64: bool,
        scalar: Scalar,
        count: usize,
    ) -> Result<Vec<f64>, Fault> {
        let expected = count * scalar.size();
        let mut bytes = Bytes { rest: data, is_base64, ahead: Vec::new() };
        let values = match self.compressor {
            None => {
                let size = self.sizes(&mut bytes, 1)?[0];
                if size != expected {
                    return Err(format!("{size} bytes do not match {count} numbers").into());
                }
                bytes.take(size)?
            }
            Some(compressor) => self.blocks(&mut bytes, compressor, expected)?,
        };
        let mut numbers = Vec::new();
        reserve(&mut numbers, count).map_err(Fault::Limits)?;
        numbers.extend(values.chunks_exact(scalar.size()).map(|bytes| scalar.number(bytes)));
        Ok(numbers)
    }

    /// The bytes of compressed blocks. A last block of 0 bytes, or of the size of the others, is as long as they are.
    fn blocks(&self, bytes: &mut Bytes<'_>, compressor: Compressor, expected: usize) -> Result<Vec<u8>, Fault> {
        let head = self.sizes(bytes, 3)?;
        let [count, size, last] = [head[0], head[1], head[2]];
        let whole = if last == 0 {
            count.checked_mul(size)
        } else {
            count.saturating_sub(1).checked_mul(size).and_then(|all| all.checked_add(last))
        };
        let whole = if count == 0 { Some(0) } else { whole };
        if whole != Some(expected) || last > size {
            return Err(format!("{count} blocks of {size} bytes, the last of {last}, are not {expected} bytes").into());
        }
        // Every block has at least a byte.
        if count > bytes.rest.len() {
            return Err(format!("{count} blocks do not fit into the file").into());
        }
        let packed = self.sizes(bytes, count)?;
        // The runs of base64 before and behind these sizes are separate.
        bytes.ahead.clear();
        let mut unpacked = Vec::new();
        for (n, packed) in packed.into_iter().enumerate() {
            let block = bytes.take(packed)?;
            let size = if n + 1 == count && last > 0 { last } else { size };
            let before = unpacked.len();
            match compressor {
                Compressor::Zlib => read(ZlibDecoder::new(&block[..]), size, &mut unpacked)?,
                Compressor::Xz => read(XzReader::new(&block[..], true), size, &mut unpacked)?,
                Compressor::Lz4 => {
                    // A byte continues a length by at most 255.
                    if size / 255 > block.len() + 1 {
                        return Err(format!("block {n} of {} bytes is not {size} bytes", block.len()).into());
                    }
                    reserve(&mut unpacked, size).map_err(Fault::Limits)?;
                    unpacked.resize(before + size, 0);
                    let found = lz4_flex::block::decompress_into(&block, &mut unpacked[before..]);
                    let found = found.map_err(|error| format!("block {n} is damaged: {error}"))?;
                    unpacked.truncate(before + found);
                }
            }
            if unpacked.len() != before + size {
                return Err(format!("block {n} has {} bytes of {size}", unpacked.len() - before).into());
            }
        }
        Ok(unpacked)
    }
}

/// Appends at most `size` decompressed bytes, and one more where there are more. The list grows with them.
fn read(from: impl Read, size: usize, into: &mut Vec<u8>) -> Result<(), Fault> {
    let mut from = from.take(size as u64 + 1);
    let mut step = [0; 1 << 12];
    loop {
        match from.read(&mut step).map_err(|error| format!("a block is damaged: {error}"))? {
            0 => return Ok(()),
            found => {
                reserve(into, found).map_err(Fault::Limits)?;
                into.extend_from_slice(&step[..found]);
            }
        }
    }
}

/// The numbers of a text, as numbers of the array's type.
pub(super) fn numbers_of_text(text: &[u8], scalar: Scalar, count: usize) -> Result<Vec<f64>, Fault> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let mut numbers = Vec::new();
    for word in words {
        if numbers.len() == count {
            return Err(format!("there are more than {count} numbers").into());
        }
        reserve(&mut numbers, 1).map_err(Fault::Limits)?;
        numbers.push(number(word, scalar)?);
    }
    match numbers.len() {
        found if found < count => Err(format!("there are {found} of {count} numbers").into()),
        _ => Ok(numbers),
    }
}

/// A number of text, rounded to the type of the array.
pub(super) fn number(word: &[u8], scalar: Scalar) -> Result<f64, Fault> {
    let text = std::str::from_utf8(word).unwrap_or_default();
    let number = match scalar.kind {
        NumberKind::Float if scalar.size() == 4 => text.parse::<f32>().map(f64::from),
        _ => text.parse(),
    };
    number.map_err(|_| format!("{} is not a number", halfline_ground::quote::quote(word)).into())
}
