//! The compression of XTC: whole numbers of three coordinates, packed as one number of as many bits as their ranges
//! need. An atom may be followed by up to ten that are close to it, in fewer bits; of these the first changes places
//! with the atom before it, because oxygen is the middle of water. A description is in the comments of xdrfile
//! (gitlab.com/gromacs/gromacs, src/gromacs/fileio/libxdrf.cpp).

use halfline_ground::error::{Error, Result};
use halfline_ground::memory::reserve;

/// Compressed positions.
pub(super) struct Packed<'a> {
    pub(super) bytes: &'a [u8],
    /// The least and the greatest coordinates.
    pub(super) least: [i64; 3],
    pub(super) most: [i64; 3],
    /// The index of the first small range in [`RANGES`].
    pub(super) small: i32,
}

/// The reason that positions cannot be unpacked.
pub(super) enum Fault {
    /// The fault of the compressed data, in words.
    Damaged(String),
    Other(Error),
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

/// The ranges of small differences; three coordinates of range `n` need `n` bits. They grow by about the cube root of
/// two. The first index is 9.
const RANGES: [u32; 73] = [
    0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 10, 12, 16, 20, 25, 32, 40, 50, 64, 80, 101, 128, 161, 203, 256, 322, 406, 512, 645,
    812, 1024, 1290, 1625, 2048, 2580, 3250, 4096, 5060, 6501, 8192, 10321, 13003, 16384, 20642, 26007, 32768, 41285,
    52015, 65536, 82570, 104031, 131072, 165140, 208063, 262144, 330280, 416127, 524287, 660561, 832255, 1048576,
    1321122, 1664510, 2097152, 2642245, 3329021, 4194304, 5284491, 6658042, 8388607, 10568983, 13316085, 16777216,
];

/// Ranges above this are packed coordinate by coordinate.
const TOGETHER: u64 = 0xff_ffff;

/// Unpacks `count` positions, each converted by `place`.
pub(super) fn unpack(
    packed: &Packed<'_>,
    count: u64,
    place: impl Fn([i64; 3]) -> [f64; 3],
) -> Result<Vec<[f64; 3]>, Fault> {
    let mut ranges = [0; 3];
    for (range, (least, most)) in ranges.iter_mut().zip(packed.least.iter().zip(&packed.most)) {
        *range =
            u64::try_from(most - least).map_err(|_| Fault::Damaged(format!("coordinates from {least} to {most}")))? + 1;
    }
    let apart = ranges.iter().any(|range| *range > TOGETHER);
    let length = |range: u64| u64::BITS - range.leading_zeros();
    let all = ranges.iter().map(|range| u128::from(*range)).product::<u128>();
    let together = if apart { 0 } else { u128::BITS - all.leading_zeros() };
    let mut bits = Bits { bytes: packed.bytes, buffer: 0, count: 0 };
    let mut small = Small::of(i64::from(packed.small))?;
    let (mut positions, mut run) = (Vec::new(), 0);
    while (positions.len() as u64) < count {
        let mut whole = if apart {
            let mut whole = [0; 3];
            for (x, range) in whole.iter_mut().zip(ranges) {
                // A range of 2^32 has 33 bits; the format stores 32 of them.
                *x = bits.take(length(range).min(32))? as i64;
            }
            whole
        } else {
            bits.mixed(together, ranges)?
        };
        whole.iter_mut().zip(packed.least).for_each(|(x, least)| *x += least);
        let mut change = 0;
        if bits.take(1)? == 1 {
            let code = bits.take(5)?;
            (run, change) = (code / 3, code as i64 % 3 - 1);
        }
        if positions.len() as u64 + 1 + run > count {
            return Err(Fault::Damaged(format!("more than {count} positions")));
        }
        reserve(&mut positions, 1 + run as usize)?;
        let mut before = whole;
        for n in 0..run {
            let near = bits.mixed(small.bits, [small.range; 3])?;
            let next = [0, 1, 2].map(|k| before[k] + near[k] - small.range as i64 / 2);
            positions.push(place(next));
            if n == 0 {
                positions.push(place(whole));
            }
            before = next;
        }
        if run == 0 {
            positions.push(place(whole));
        }
        if change != 0 {
            small = Small::of(i64::from(small.bits) + change)?;
        }
    }
    Ok(positions)
}

/// The range of small differences.
struct Small {
    range: u64,
    /// The bits of three of them, which are the index of the range.
    bits: u32,
}

impl Small {
    fn of(index: i64) -> Result<Self, Fault> {
        let range = usize::try_from(index).ok().and_then(|index| RANGES.get(index)).filter(|range| **range > 0);
        let wrong = || Fault::Damaged(format!("small differences of index {index}, which is not in 9 to 72"));
        range.map(|range| Self { range: u64::from(*range), bits: index as u32 }).ok_or_else(wrong)
    }
}

/// Bits, the highest of each byte first.
struct Bits<'a> {
    bytes: &'a [u8],
    /// The last bytes; their lowest `count` bits were not taken yet.
    buffer: u64,
    count: u32,
}

impl Bits<'_> {
    /// At most 32 bits as a number.
    fn take(&mut self, bits: u32) -> Result<u64, Fault> {
        while self.count < bits {
            let Some((byte, rest)) = self.bytes.split_first() else {
                return Err(Fault::Damaged("the compressed bytes end before the last position".into()));
            };
            (self.buffer, self.bytes, self.count) = (self.buffer << 8 | u64::from(*byte), rest, self.count + 8);
        }
        self.count -= bits;
        Ok(self.buffer >> self.count & ((1 << bits) - 1))
    }

    /// Three numbers below `ranges` as one number of `bits` bits, at most 72: the last is the remainder by its range.
    /// The bytes of the number are in ascending order.
    fn mixed(&mut self, bits: u32, ranges: [u64; 3]) -> Result<[i64; 3], Fault> {
        let mut number = 0u128;
        let mut done = 0;
        while done < bits {
            let step = (bits - done).min(8);
            number |= u128::from(self.take(step)?) << done;
            done += step;
        }
        let [_, y, z] = ranges;
        match u64::try_from(number) {
            Ok(number) => Ok([(number / z / y) as i64, (number / z % y) as i64, (number % z) as i64]),
            Err(_) => {
                let [y, z] = [u128::from(y), u128::from(z)];
                Ok([(number / z / y) as i64, (number / z % y) as i64, (number % z) as i64])
            }
        }
    }
}
