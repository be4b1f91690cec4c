//! Times of points in LAZ: up to four sequences of times, each with the difference between its last two.

use super::arithmetic::{Decoder, Source, Symbols};
use super::integer::Integers;
use halfline_ground::error::Result;

/// A decoder of times; they are the bits of f64 as whole numbers.
pub(super) struct Times {
    times: [i64; 4],
    steps: [i32; 4],
    /// The count of extreme multiples (-10, 0, 500) in each sequence since its last multiple of 1; the fourth replaces
    /// the difference.
    odd: [u8; 4],
    last: usize,
    next: usize,
    /// Whether "unchanged" has a code; in the layers of newer formats it is in the point's.
    old: bool,
    first: Symbols,
    multiples: Symbols,
    differences: Integers,
}

/// The greatest multiple of the last difference, and the codes behind the 511 of multiples.
const MOST: u32 = 500;
const UNCHANGED: u32 = 511;
const JUMP: u32 = 512;

impl Times {
    pub(super) fn new(first: i64, old: bool) -> Self {
        let more = usize::from(old);
        Self {
            times: [first, 0, 0, 0],
            steps: [0; 4],
            odd: [0; 4],
            last: 0,
            next: 0,
            old,
            first: Symbols::new(5 + more),
            multiples: Symbols::new(515 + more),
            differences: Integers::new(32, 9),
        }
    }

    /// The current time.
    pub(super) fn time(&self) -> i64 {
        self.times[self.last]
    }

    /// Reads the next time.
    pub(super) fn advance<S: Source>(&mut self, from: &mut Decoder<S>) -> Result<()> {
        // An encoder changes to a sequence that continues.
        for _ in 0..4 {
            let step = self.steps[self.last];
            let change = if step == 0 {
                let code = from.symbol(&mut self.first)? + u32::from(!self.old);
                match code {
                    0 => return Ok(()),
                    1 => {
                        let step = self.differences.next(from, 0, 0)?;
                        self.steps[self.last] = step;
                        self.odd[self.last] = 0;
                        self.add(step);
                        return Ok(());
                    }
                    2 => return self.jump(from),
                    code => code - 2,
                }
            } else {
                let code = from.symbol(&mut self.multiples)?;
                match code + u32::from(!self.old && code >= UNCHANGED) {
                    UNCHANGED => return Ok(()),
                    JUMP => return self.jump(from),
                    code if code > JUMP => code - JUMP,
                    code => return self.multiple(from, code, step),
                }
            };
            self.last = (self.last + change as usize) & 3;
        }
        Err(from.source().invalid())
    }

    /// A time whose difference is near a multiple of the last one.
    fn multiple<S: Source>(&mut self, from: &mut Decoder<S>, code: u32, step: i32) -> Result<()> {
        let factor = if code <= MOST { code as i32 } else { MOST as i32 - code as i32 };
        let (context, is_odd) = match factor {
            0 => (7, true),
            1 => (1, false),
            2..10 => (2, false),
            10..500 => (3, false),
            500 => (4, true),
            -9..0 => (5, false),
            _ => (6, true),
        };
        let difference = self.differences.next(from, factor.wrapping_mul(step), context)?;
        if factor == 1 {
            self.odd[self.last] = 0;
        } else if is_odd {
            self.odd[self.last] += 1;
            if self.odd[self.last] > 3 {
                self.odd[self.last] = 0;
                self.steps[self.last] = difference;
            }
        }
        self.add(difference);
        Ok(())
    }

    fn add(&mut self, difference: i32) {
        self.times[self.last] = self.times[self.last].wrapping_add(difference.into());
    }

    /// Begins a sequence.
    fn jump<S: Source>(&mut self, from: &mut Decoder<S>) -> Result<()> {
        self.next = (self.next + 1) & 3;
        let high = self.differences.next(from, (self.time() >> 32) as i32, 8)?;
        let low = from.bits(32)?;
        self.last = self.next;
        self.times[self.last] = i64::from(high) << 32 | i64::from(low);
        (self.steps[self.last], self.odd[self.last]) = (0, 0);
        Ok(())
    }
}
