//! Colours in sRGB and in text.

use super::nearest::nearest;
use color_name::css::COLORS_DATA;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::quote;
use halfline_ground::srgb::{decoded, linear};
use std::sync::LazyLock;

/// The largest level of colours that are whole numbers up to `most`: of 8 bits where these hold them all, else of 16.
pub(crate) fn top_level(most: f32) -> f32 {
    if most <= 255.0 { 255.0 } else { 65535.0 }
}

/// A level of sRGB between 0 and `top` in linear light (IEC 61966-2-1).
pub(crate) fn srgb_to_linear(level: f32, top: f32) -> f32 {
    // A table, not a power for every point.
    static LIGHT: LazyLock<Vec<f32>> = LazyLock::new(|| (0..=255).map(|level| linear([level; 3])[0]).collect());
    if top == 255.0 && level.fract() == 0.0 {
        return LIGHT[usize::from(level as u8)];
    }
    decoded(f64::from(level) / f64::from(top)) as f32
}

/// Parses a colour: a CSS name such as `rebeccapurple`, in any case, or `#rgb` or `#rrggbb`, all in sRGB; or `r,g,b` in
/// linear RGB. Names and hexadecimal digits have the meaning of <https://www.w3.org/TR/css-color-4/>; its other notations
/// (`#rgba`, `hsl()`) are errors.
///
/// # Errors
/// [`Error::Settings`] for anything else; for an unknown name it suggests the nearest one.
pub fn color(text: &str) -> Result<[f32; 3]> {
    if let Some(rgb) = text.strip_prefix('#').and_then(hex) {
        return Ok(of_hex(rgb));
    }
    if let Some((_, srgb)) = COLORS_DATA.iter().find(|(name, _)| name.eq_ignore_ascii_case(text.trim())) {
        return Ok(linear(*srgb));
    }
    // By way of f64, as numbers of other programs are rounded.
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    let color = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok()).map(|color| color.map(|c| c as f32));
    color.filter(|color| color.iter().all(|c| c.is_finite() && *c >= 0.0)).ok_or_else(|| {
        let names = COLORS_DATA.iter().map(|(name, _)| name.to_ascii_lowercase());
        let nearest = nearest(text, names).map_or(String::new(), |name| format!("{name}, "));
        let mend = format!("use {nearest}a CSS name such as red, #rrggbb (sRGB), or r,g,b (linear, 0 or more)");
        Error::settings(format!("{} is not a colour", quote(text)), mend)
    })
}

/// The number of `rrggbb`, or of `rgb` with each digit doubled.
pub fn hex(digits: &str) -> Option<u32> {
    let digits = match digits.len() {
        3 => digits.chars().flat_map(|digit| [digit, digit]).collect(),
        _ => digits.to_owned(),
    };
    // A sign is not a digit.
    let is_hex = digits.len() == 6 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    is_hex.then(|| u32::from_str_radix(&digits, 16).ok()).flatten()
}

pub fn of_hex(rgb: u32) -> [f32; 3] {
    let [_, red, green, blue] = rgb.to_be_bytes();
    linear([red, green, blue])
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline_ground::srgb;

    #[test]
    fn colours_are_read() {
        assert_eq!(color("#ffffff").expect("white"), [1.0; 3]);
        assert_eq!(color("0.5, 0,2").expect("linear"), [0.5, 0.0, 2.0]);
        assert!((color("#808080").expect("gray")[0] - 0.2158605).abs() < 1e-6, "IEC 61966-2-1 of 128/255");
        assert_eq!(color("#f80").expect("doubled digits"), color("#ff8800").expect("orange"));
        for bad in ["", "#12", "#12345g", "#+12345", "#ßa", "#1234", "#11223344", "1,2", "1,2,-3", "rde", "nan,0,0"] {
            color(bad).expect_err(bad);
        }
    }

    #[test]
    fn levels_of_linear_colours_are_those_that_were_read() {
        for level in 0..=u8::MAX {
            assert_eq!(linear([level, 0, 255]).map(srgb::level), [level, 0, 255]);
        }
    }

    /// Colours of CSS Color Module Level 4, section 6.1.
    #[test]
    fn names_are_those_of_css() {
        for (name, rgb) in [
            ("red", 0xff0000),
            ("White", 0xffffff),
            (" REBECCAPURPLE ", 0x663399),
            ("gray", 0x808080),
            ("grey", 0x808080),
            ("aliceblue", 0xf0f8ff),
            ("yellowgreen", 0x9acd32),
            ("green", 0x008000),
        ] {
            assert_eq!(color(name).expect(name), of_hex(rgb), "{name}");
        }
        assert_eq!(COLORS_DATA.len(), 148);
        let names: std::collections::HashSet<_> = COLORS_DATA.iter().map(|(name, _)| name.to_lowercase()).collect();
        assert_eq!(names.len(), 148, "all differ");
    }

    #[test]
    fn the_nearest_name_is_suggested() {
        for (typed, name) in
            [("rde", "red"), ("lightgrene", "lightgreen"), ("orang", "orange"), ("Rebbecapurple", "rebeccapurple")]
        {
            let error = color(typed).expect_err(typed).to_string();
            assert!(error.contains(&format!("; use {name}, ")), "{error}");
        }
        for typed in ["", "r", "#12", "x".repeat(1 << 20).as_str(), "transparent"] {
            let error = color(typed).expect_err("no colour").to_string();
            assert!(error.contains("; use a CSS name") && error.len() < 500, "{}", error.len());
        }
    }
}
