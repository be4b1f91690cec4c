//! Whole numbers of LAZ, coded as differences from what is expected, and the running median that is expected.

use super::arithmetic::{Bit, Decoder, Models, Source};
use halfline_ground::error::Result;

/// The most bits of a difference that have a model; lower bits have none.
const MODELLED: u32 = 8;

/// A decoder of numbers of so many bits in several contexts.
pub(super) struct Integers {
    bits: u32,
    /// The models of the number of bits of a difference, by context.
    sizes: Models,
    one: Bit,
    /// The models of differences, by their number of bits.
    differences: Vec<Models>,
    size: u32,
}

impl Integers {
    /// Numbers of 16 or 32 bits.
    pub(super) fn new(bits: u32, contexts: usize) -> Self {
        let differences = (1..=bits).map(|size| Models::new(1, 1 << size.min(MODELLED))).collect();
        Self { bits, sizes: Models::new(contexts, bits as usize + 1), one: Bit::default(), differences, size: 0 }
    }

    /// The number of bits of the last difference.
    pub(super) fn size(&self) -> u32 {
        self.size
    }

    /// The next number.
    pub(super) fn next<S: Source>(&mut self, from: &mut Decoder<S>, expected: i32, context: usize) -> Result<i32> {
        self.size = from.symbol(self.sizes.at(context))?;
        let difference = match self.size {
            0 => from.bit(&mut self.one)? as i32,
            32 => i32::MIN,
            size => {
                let model = self.differences[size as usize - 1].at(0);
                let mut code = from.symbol(model)?;
                if size > MODELLED {
                    code = code << (size - MODELLED) | from.bits(size - MODELLED)?;
                }
                // The differences of this size are -2^size + 1 to -2^(size - 1), and 2^(size - 1) + 1 to 2^size.
                let code = i64::from(code);
                let signed = if code >= 1 << (size - 1) { code + 1 } else { code - (1 << size) + 1 };
                signed as i32
            }
        };
        let number = expected.wrapping_add(difference);
        let range = if self.bits < 32 { 1 << self.bits } else { 0 };
        Ok(match number {
            n if n < 0 => n.wrapping_add(range),
            n if n >= range => n - range,
            n => n,
        })
    }
}

/// The median of the last five numbers, approximately: it forgets the greatest and the least in turn.
#[derive(Clone, Copy, Default)]
pub(super) struct Median {
    sorted: [i32; 5],
    /// Whether the least is forgotten next.
    least: bool,
}

impl Median {
    pub(super) fn get(&self) -> i32 {
        self.sorted[2]
    }

    pub(super) fn add(&mut self, number: i32) {
        let middle = self.get();
        self.sorted[if self.least { 0 } else { 4 }] = number;
        self.sorted.sort_unstable();
        // A number on the side that is forgotten leaves it too long.
        let turns = if self.least { number <= middle } else { number >= middle };
        self.least ^= turns;
    }
}

/// The context of y by the size of the difference of x, and of z by the mean size of both.
pub(super) fn axis_context(single: bool, size: u32, most: u32) -> usize {
    (u32::from(single) + if size < most { size & !1 } else { most }) as usize
}
