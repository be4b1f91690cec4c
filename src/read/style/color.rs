//! Colours in sRGB and in text.

use crate::error::{Error, Result};

/// Converts 8-bit sRGB to linear RGB.
pub(in crate::read) fn linear(srgb: [u8; 3]) -> [f32; 3] {
    srgb.map(|level| {
        let x = f64::from(level) / 255.0;
        // IEC 61966-2-1.
        (if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }) as f32
    })
}

/// Parses a colour: `#rrggbb` in sRGB, or `r,g,b` in linear RGB.
///
/// # Errors
/// [`Error::Settings`] for anything else.
pub fn color(text: &str) -> Result<[f32; 3]> {
    let hex = text.strip_prefix('#').filter(|hex| hex.len() == 6 && hex.is_ascii());
    if let Some(rgb) = hex.and_then(|hex| u32::from_str_radix(hex, 16).ok()) {
        return Ok(of_hex(rgb));
    }
    let numbers: Option<Vec<f32>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let color = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    color.filter(|color| color.iter().all(|c| c.is_finite() && *c >= 0.0)).ok_or_else(|| {
        Error::settings(format!("`{text}` is not a colour"), "use #rrggbb (sRGB) or r,g,b (linear, 0 or more)")
    })
}

pub(super) fn of_hex(rgb: u32) -> [f32; 3] {
    let [_, red, green, blue] = rgb.to_be_bytes();
    linear([red, green, blue])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_read() {
        assert_eq!(color("#ffffff").expect("white"), [1.0; 3]);
        assert_eq!(color("0.5, 0,2").expect("linear"), [0.5, 0.0, 2.0]);
        assert!((color("#808080").expect("gray")[0] - 0.2158605).abs() < 1e-6, "IEC 61966-2-1 of 128/255");
        for bad in ["", "#12", "#12345g", "1,2", "1,2,-3", "red", "nan,0,0"] {
            color(bad).expect_err(bad);
        }
    }
}
