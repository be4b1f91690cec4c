//! The sRGB transfer function of IEC 61966-2-1, from linear light to levels and back.

use crate::parallel;
use std::sync::LazyLock;

/// The 8-bit sRGB level of a linear component: clamped to [0, 1], through the transfer function of IEC 61966-2-1, times
/// 255, rounded to the nearest whole number. NaN gives 0. Equal to the formula in f64 for every f32.
pub fn level(linear: f32) -> u8 {
    TABLE.level(linear)
}

/// The 8-bit levels of many components.
pub fn levels(linear: &[f32]) -> Vec<u8> {
    let mut levels = vec![0; linear.len()];
    let table = &*TABLE;
    parallel::each(&mut levels, |n, level| *level = table.level(linear[n]));
    levels
}

/// Converts 8-bit sRGB to linear RGB.
#[must_use]
pub fn linear(srgb: [u8; 3]) -> [f32; 3] {
    srgb.map(|level| decoded(f64::from(level) / 255.0) as f32)
}

/// The linear light of an sRGB component in [0, 1]: the inverse of the transfer function.
#[must_use]
pub fn decoded(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// The 16-bit sRGB level of a linear component: as [`level`] with 65535 for 255.
pub fn level16(linear: f32) -> u16 {
    // The cast saturates, and NaN gives 0.
    (65535.0 * encoded(linear.clamp(0.0, 1.0))).round() as u16
}

/// The formula in 8 bits, for x in [0, 1].
fn level_by_formula(x: f32) -> u8 {
    (255.0 * encoded(x)).round() as u8
}

/// The transfer function, for x in [0, 1].
fn encoded(x: f32) -> f64 {
    let x = f64::from(x);
    if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Cells per unit of linear light. Steps between levels are at least 1 / (12.92 * 255) > 1 / 4096 apart, because the
/// slope is greatest at black, so a cell holds at most one step. A power of two makes finding the cell exact.
const CELLS: usize = 4096;

static TABLE: LazyLock<LevelTable> = LazyLock::new(LevelTable::new);

struct LevelTable {
    /// The smallest f32 of each level; NaN after the last, which is never reached.
    least: [f32; 257],
    /// The level at the beginning of each cell; the last cell begins at 1.
    begin: [u8; CELLS + 1],
}

impl LevelTable {
    fn new() -> Self {
        let mut least = [f32::NAN; 257];
        for (level, least) in least[..256].iter_mut().enumerate() {
            // Positive floats have the order of their bits.
            let (mut low, mut high) = (0, 1f32.to_bits());
            while low < high {
                let middle = low.midpoint(high);
                if usize::from(level_by_formula(f32::from_bits(middle))) < level {
                    low = middle + 1;
                } else {
                    high = middle;
                }
            }
            *least = f32::from_bits(low);
        }
        Self { least, begin: std::array::from_fn(|cell| level_by_formula(cell as f32 / CELLS as f32)) }
    }

    fn level(&self, linear: f32) -> u8 {
        // The cast saturates: numbers below 0 and NaN are in the first cell, those above 1 in the last.
        let cell = ((linear * CELLS as f32) as usize).min(CELLS);
        let level = self.begin[cell];
        level + u8::from(linear >= self.least[usize::from(level) + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn level_equals_the_formula_on_a_dense_sweep() {
        let one = 1f32.to_bits();
        let near = |x: &f32| (x.to_bits().saturating_sub(100)..=(x.to_bits() + 100).min(one)).collect::<Vec<_>>();
        let bits = (0..=one).step_by(997).chain(TABLE.least[..256].iter().flat_map(near));
        for x in bits.map(f32::from_bits) {
            assert_eq!(level(x), level_by_formula(x), "{x:e} = {:#010x}", x.to_bits());
        }
    }

    #[test]
    #[ignore = "every f32 in [0, 1]: a thousand million"]
    fn level_equals_the_formula_everywhere() {
        (0..=1f32.to_bits()).into_par_iter().map(f32::from_bits).for_each(|x| {
            assert_eq!(level(x), level_by_formula(x), "{x:e}");
        });
    }

    #[test]
    fn sixteen_bits_refine_eight() {
        for (x, expected) in [(0.0, 0), (-1.0, 0), (f32::NAN, 0), (1.0, 65535), (f32::INFINITY, 65535), (0.5, 48192)] {
            assert_eq!(level16(x), expected, "{x}");
        }
        for x in (0..=1f32.to_bits()).step_by(4001).map(f32::from_bits) {
            // A level of 255 is 257 levels of 65535, and each has an error of half a level at most.
            assert!((i32::from(level16(x)) - 257 * i32::from(level(x))).abs() <= 129, "{x:e}");
        }
    }

    #[test]
    fn level_clamps() {
        for (x, expected) in [
            (-0.0, 0),
            (-1.0, 0),
            (f32::NEG_INFINITY, 0),
            (f32::NAN, 0),
            (1.0, 255),
            (1.5, 255),
            (f32::MAX, 255),
            (f32::INFINITY, 255),
        ] {
            assert_eq!(level(x), expected, "{x}");
        }
    }

    #[test]
    fn a_cell_holds_one_step() {
        let cell = |x: f32| (x * CELLS as f32) as usize;
        assert!(TABLE.least[1..256].windows(2).all(|pair| cell(pair[0]) < cell(pair[1])));
    }
}
