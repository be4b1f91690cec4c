//! One zlib stream of parts that were compressed independently. fdeflate writes a stream of one block, from which a part
//! is made that ends at a byte: the block no longer counts as the last one, and an empty stored block after it fills the
//! byte (RFC 1951, 3.2.4), as a compressor's flush does.

use std::io::{self, Read};
use std::sync::LazyLock;

/// The header of the stream: a window of 32 KiB, the fastest compression (RFC 1950).
pub(super) const BEGIN: [u8; 2] = [0x78, 0x01];

/// An empty stored block without its header, which ends at a byte: 0 bytes, and their complement.
const STORED: [u8; 4] = [0, 0, 0xff, 0xff];

/// The modulus of Adler-32.
const PRIME: u64 = 65521;

/// A part of a stream.
pub(super) struct Part {
    /// Its blocks.
    pub(super) bytes: Vec<u8>,
    /// The checksum of its content alone.
    adler: u32,
    /// The length of its content.
    length: u64,
}

impl Part {
    /// Compresses `content`.
    ///
    /// # Errors
    /// None for memory; the type is the compressor's.
    pub(super) fn new(content: &[u8]) -> io::Result<Self> {
        let mut compressor = fdeflate::Compressor::new(Vec::with_capacity(content.len() / 2))?;
        compressor.write_data(content)?;
        let mut bytes = compressor.finish()?;
        let adler = bytes.split_off(bytes.len().saturating_sub(4));
        let adler = adler.try_into().map_or(0, u32::from_be_bytes);
        bytes.drain(..BEGIN.len().min(bytes.len()));
        if let Some(first) = bytes.first_mut() {
            // The first bit says that the block is the last.
            *first &= !1;
        }
        // The code of the block's end ends with a 1, so the zeros after it fill the byte. They are the beginning of the
        // next block's header, 3 zeros for a stored one.
        let zeros = bytes.last().map_or(0, |last| last.leading_zeros());
        if zeros < 3 {
            bytes.push(0);
        }
        bytes.extend(STORED);
        Ok(Self { bytes, adler, length: content.len() as u64 })
    }
}

/// Adler-32 of parts in order (RFC 1950, 8.2).
pub(super) struct Adler {
    /// The sum of the bytes plus 1, and the sum of these sums.
    sums: [u64; 2],
    length: u64,
}

impl Default for Adler {
    fn default() -> Self {
        Self { sums: [1, 0], length: 0 }
    }
}

impl Adler {
    /// Adds the next part: its sums were begun with 1, but continue with the sum so far.
    pub(super) fn append(&mut self, part: &Part) {
        let [sum, sums] = self.sums;
        let own = [u64::from(part.adler & 0xffff), u64::from(part.adler >> 16)];
        let before = sum + PRIME - 1;
        self.sums = [(before + own[0]) % PRIME, (sums + own[1] + part.length % PRIME * (before % PRIME)) % PRIME];
        self.length += part.length;
    }

    /// Bytes of content so far.
    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// The end of the stream: an empty block, the last one, and the checksum.
    pub(super) fn end(&self) -> Vec<u8> {
        let sum = (self.sums[1] << 16 | self.sums[0]) as u32;
        [&[1][..], &STORED, &sum.to_be_bytes()].concat()
    }
}

/// Whether parts of this fdeflate can be joined: its blocks end as [`Part::new`] expects. Tried once per process, since
/// another version may be compiled in.
pub(super) fn is_possible() -> bool {
    static POSSIBLE: LazyLock<bool> = LazyLock::new(|| can_join().unwrap_or(false));
    *POSSIBLE
}

fn can_join() -> io::Result<bool> {
    // Their codes have various lengths, so that the blocks end at each of a byte's bits.
    let contents: Vec<Vec<u8>> = (0..64).map(|n: u8| (0..n).map(|k| k.wrapping_mul(n)).collect()).collect();
    let (mut stream, mut adler) = (BEGIN.to_vec(), Adler::default());
    for content in &contents {
        let part = Part::new(content)?;
        adler.append(&part);
        stream.extend(part.bytes);
    }
    stream.extend(adler.end());
    let mut read = Vec::new();
    let complete = flate2::read::ZlibDecoder::new(&stream[..]).read_to_end(&mut read).is_ok();
    Ok(complete && read == contents.concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_joined_at_every_bit() {
        assert!(is_possible());
        // Blocks that end at each bit of a byte occur in the trial.
        let mut ends = [false; 8];
        for n in 0..64u8 {
            let content: Vec<u8> = (0..n).map(|k| k.wrapping_mul(n)).collect();
            let part = Part::new(&content).expect("in memory").bytes;
            let before = &part[..part.len() - STORED.len()];
            let (last, filled) =
                before.split_last().map_or((0, 0), |(last, rest)| (*last, rest.last().copied().unwrap_or(0)));
            ends[if last == 0 { filled.leading_zeros() } else { last.leading_zeros() } as usize] = true;
        }
        assert_eq!(ends, [true; 8]);
    }
}
