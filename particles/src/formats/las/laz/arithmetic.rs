//! The arithmetic decoder of LAZ with its adaptive models: A. Said, Introduction to Arithmetic Coding, HP Laboratories
//! report HPL-2004-76, in the variant of the LAZ Specification 1.4.
//!
//! In every state `value < length` and `length >= 2^24`, and a model gives every symbol a part of the length, so that no
//! input can make an operation overflow or a symbol leave its model.

use halfline_ground::error::{Error, Result};

/// A source of coded bytes.
pub(super) trait Source {
    /// The next byte.
    ///
    /// # Errors
    /// [`Error::Scene`] at the end, and errors of reading.
    fn byte(&mut self) -> Result<u8>;

    /// The error for a code that no encoder writes.
    fn invalid(&self) -> Error;
}

/// The problem in errors for a code that no encoder writes.
pub(super) const INVALID: &str = "the compressed points are not valid";

/// A decoder of symbols and bits.
pub(super) struct Decoder<S> {
    source: S,
    value: u32,
    length: u32,
}

/// The least length of the interval.
const LEAST: u32 = 1 << 24;

/// Bits of the probabilities of symbols and of a bit.
const SYMBOL_BITS: u32 = 15;
const BIT_BITS: u32 = 13;

impl<S: Source> Decoder<S> {
    /// Call [`Decoder::begin`] before the first symbol.
    pub(super) fn new(source: S) -> Self {
        Self { source, value: 0, length: u32::MAX }
    }

    pub(super) fn source(&mut self) -> &mut S {
        &mut self.source
    }

    /// Reads the first four bytes of a coded sequence.
    ///
    /// # Errors
    /// As [`Source::byte`] and [`Source::invalid`]; so of all methods that follow.
    pub(super) fn begin(&mut self) -> Result<()> {
        (self.value, self.length) = (0, u32::MAX);
        for _ in 0..4 {
            self.value = self.value << 8 | u32::from(self.source.byte()?);
        }
        if self.value == self.length { Err(self.source.invalid()) } else { Ok(()) }
    }

    fn widen(&mut self) -> Result<()> {
        while self.length < LEAST {
            self.value = self.value << 8 | u32::from(self.source.byte()?);
            self.length <<= 8;
        }
        Ok(())
    }

    /// The next symbol of a model.
    pub(super) fn symbol(&mut self, model: &mut Symbols) -> Result<u32> {
        let part = self.length >> SYMBOL_BITS;
        let (mut low, mut high) = (0, model.starts.len());
        let (mut below, mut above) = (0, self.length);
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            let start = part * model.starts[middle];
            if start > self.value {
                (high, above) = (middle, start);
            } else {
                (low, below) = (middle, start);
            }
        }
        self.value -= below;
        self.length = above - below;
        model.count(low);
        self.widen()?;
        Ok(low as u32)
    }

    /// The next bit of a model.
    pub(super) fn bit(&mut self, model: &mut Bit) -> Result<u32> {
        let zero = model.zero * (self.length >> BIT_BITS);
        let bit = self.value >= zero;
        if bit {
            self.value -= zero;
            self.length -= zero;
        } else {
            self.length = zero;
        }
        model.count(bit);
        self.widen()?;
        Ok(bit.into())
    }

    /// The next `count` bits without a model, at most 32.
    pub(super) fn bits(&mut self, count: u32) -> Result<u32> {
        if count > 19 {
            let low = self.bits(16)?;
            return Ok(self.bits(count - 16)? << 16 | low);
        }
        self.length >>= count;
        let found = self.value / self.length;
        self.value %= self.length;
        if found >= 1 << count {
            return Err(self.source.invalid());
        }
        self.widen()?;
        Ok(found)
    }
}

/// An adaptive model of symbols from 0.
pub(super) struct Symbols {
    counts: Vec<u32>,
    /// The beginning of each symbol's part, of 2^15.
    starts: Vec<u32>,
    total: u32,
    /// Symbols from one update to the next, and until the next.
    cycle: u32,
    left: u32,
}

impl Symbols {
    /// A model of `count` equally probable symbols, 2 to 2048.
    pub(super) fn new(count: usize) -> Self {
        let cycle = count as u32;
        let mut model = Self { counts: vec![1; count], starts: vec![0; count], total: 0, cycle, left: 0 };
        model.update();
        model.cycle = (cycle + 6) >> 1;
        model.left = model.cycle;
        model
    }

    fn count(&mut self, symbol: usize) {
        self.counts[symbol] += 1;
        self.left -= 1;
        if self.left == 0 {
            self.update();
        }
    }

    fn update(&mut self) {
        self.total += self.cycle;
        if self.total > 1 << SYMBOL_BITS {
            self.counts.iter_mut().for_each(|count| *count = (*count + 1) >> 1);
            self.total = self.counts.iter().sum();
        }
        let (scale, mut sum) = ((1 << 31) / self.total, 0);
        for (start, count) in self.starts.iter_mut().zip(&self.counts) {
            *start = (scale * sum) >> (31 - SYMBOL_BITS);
            sum += count;
        }
        self.cycle = ((5 * self.cycle) >> 2).min((self.counts.len() as u32 + 6) << 3);
        self.left = self.cycle;
    }
}

/// An adaptive model of a bit.
pub(super) struct Bit {
    zeros: u32,
    total: u32,
    /// The probability of 0, of 2^13.
    zero: u32,
    cycle: u32,
    left: u32,
}

impl Default for Bit {
    fn default() -> Self {
        Self { zeros: 1, total: 2, zero: 1 << (BIT_BITS - 1), cycle: 4, left: 4 }
    }
}

impl Bit {
    fn count(&mut self, bit: bool) {
        self.zeros += u32::from(!bit);
        self.left -= 1;
        if self.left > 0 {
            return;
        }
        self.total += self.cycle;
        if self.total > 1 << BIT_BITS {
            self.total = (self.total + 1) >> 1;
            self.zeros = (self.zeros + 1) >> 1;
            self.total += u32::from(self.zeros == self.total);
        }
        self.zero = (((1 << 31) / self.total) * self.zeros) >> (31 - BIT_BITS);
        self.cycle = ((5 * self.cycle) >> 2).min(64);
        self.left = self.cycle;
    }
}

/// Models that are made when they are first used: most of the hundreds that a point may use never are.
pub(super) struct Models {
    symbols: usize,
    models: Vec<Option<Symbols>>,
}

impl Models {
    /// `count` models of so many symbols each.
    pub(super) fn new(count: usize, symbols: usize) -> Self {
        Self { symbols, models: (0..count).map(|_| None).collect() }
    }

    /// One of them.
    pub(super) fn at(&mut self, index: usize) -> &mut Symbols {
        self.models[index].get_or_insert_with(|| Symbols::new(self.symbols))
    }
}
