//! Colours in LAZ: bytes as differences from the last colour, green and blue also from the change of red.

use super::arithmetic::{Decoder, Source, Symbols};
use halfline_ground::error::Result;

/// A decoder of red, green and blue.
pub(super) struct Colors {
    changed: Symbols,
    bytes: [Symbols; 6],
}

impl Default for Colors {
    fn default() -> Self {
        Self { changed: Symbols::new(128), bytes: std::array::from_fn(|_| Symbols::new(256)) }
    }
}

impl Colors {
    /// The next colour in six bytes; `last` is the one before.
    pub(super) fn next<S: Source>(&mut self, from: &mut Decoder<S>, last: [u8; 6]) -> Result<[u8; 6]> {
        let changed = from.symbol(&mut self.changed)?;
        let mut color = last;
        let mut read = |byte: usize, expected: u8| -> Result<u8> {
            if changed >> byte & 1 == 0 {
                return Ok(last[byte]);
            }
            Ok(expected.wrapping_add(from.symbol(&mut self.bytes[byte])? as u8))
        };
        // The low bytes are even.
        color[0] = read(0, last[0])?;
        color[1] = read(1, last[1])?;
        if changed >> 6 & 1 == 0 {
            // Grey.
            return Ok([color[0], color[1], color[0], color[1], color[0], color[1]]);
        }
        for half in [0, 1] {
            let shift = |channel: usize, color: &[u8; 6]| {
                i32::from(color[2 * channel + half]) - i32::from(last[2 * channel + half])
            };
            let red = shift(0, &color);
            let near = |byte: usize, by: i32| (i32::from(last[byte]) + by).clamp(0, 255) as u8;
            color[2 + half] = read(2 + half, near(2 + half, red))?;
            let mean = (red + shift(1, &color)) / 2;
            color[4 + half] = read(4 + half, near(4 + half, mean))?;
        }
        Ok(color)
    }
}

/// A decoder of near infrared.
pub(super) struct Infrared {
    changed: Symbols,
    bytes: [Symbols; 2],
}

impl Default for Infrared {
    fn default() -> Self {
        Self { changed: Symbols::new(4), bytes: std::array::from_fn(|_| Symbols::new(256)) }
    }
}

impl Infrared {
    /// The next number in two bytes; `last` is the one before.
    pub(super) fn next<S: Source>(&mut self, from: &mut Decoder<S>, mut last: [u8; 2]) -> Result<[u8; 2]> {
        let changed = from.symbol(&mut self.changed)?;
        for (byte, model) in self.bytes.iter_mut().enumerate() {
            if changed >> byte & 1 == 1 {
                last[byte] = last[byte].wrapping_add(from.symbol(model)? as u8);
            }
        }
        Ok(last)
    }
}
