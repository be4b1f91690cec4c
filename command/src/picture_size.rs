//! The size of a picture by `--size`: in pixels, or in millimetres of paper; the height may be left to the spheres that are framed.

use halfline::error::Error;
use halfline::scene::MAX_SIDE;
use halfline_files::write::format::Dpi;
use std::str::FromStr;

/// Width and height of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PictureSize {
    width: Length,
    /// `None` for the height that the framed spheres fill.
    height: Option<Length>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Length {
    Pixels(u32),
    Millimetres(f64),
}

/// The largest side in millimetres.
const LONGEST: f64 = 10_000.0;

impl PictureSize {
    /// Whether a side is in millimetres.
    pub(super) fn is_printed(self) -> bool {
        [Some(self.width), self.height].into_iter().flatten().any(|side| matches!(side, Length::Millimetres(_)))
    }

    /// Columns, and rows where they are given; `dpi` are the pixels per inch of 25.4 mm.
    pub(super) fn pixels(self, dpi: Dpi) -> (u32, Option<u32>) {
        let pixels = |side| match side {
            Length::Pixels(pixels) => pixels,
            Length::Millimetres(length) => (length / 25.4 * f64::from(dpi.per_inch())).round().max(1.0) as u32,
        };
        (pixels(self.width), self.height.map(pixels))
    }
}

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORMS: &str = "expected WxH, such as 1920x1080, Wxauto for the height of what is framed, or millimetres of paper, \
                             such as 85mm or 85x60mm";
        let lower = text.to_ascii_lowercase();
        let is_printed = lower.ends_with("mm");
        let (width, height) = lower.split_once('x').or(is_printed.then_some((&lower, "auto"))).ok_or(FORMS)?;
        if !is_printed && !width.ends_with("mm") && height != "auto" {
            return scene_size(text)
                .map(|(w, h)| Self { width: Length::Pixels(w), height: Some(Length::Pixels(h)) })
                .map_err(|why| if why.starts_with("expected") { FORMS.to_owned() } else { why });
        }
        let side = |side: &str| match side.strip_suffix("mm").or(is_printed.then_some(side)) {
            Some(length) => {
                let length = length.parse().ok().filter(|length| (1.0..=LONGEST).contains(length));
                length.map(Length::Millimetres).ok_or(format!("a side of paper has 1 to {LONGEST} mm"))
            }
            None => {
                let pixels = side.parse().ok().filter(|side| (1..=MAX_SIDE).contains(&i64::from(*side)));
                pixels.map(Length::Pixels).ok_or(FORMS.to_owned())
            }
        };
        let height = if height == "auto" { None } else { Some(side(height)?) };
        Ok(Self { width: side(width)?, height })
    }
}

/// Columns and rows of a size in pixels.
pub(super) fn scene_size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let sides = sides.ok_or("expected WxH, such as 1920x1080")?;
    halfline::scene::check_size(sides, || "--size".into()).map_err(|e| match e {
        // The message already names the option.
        Error::Scene { problem, mend, .. } => format!("{problem}; {mend}"),
        other => other.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_pixels_by_the_resolution() {
        for (text, dpi, pixels) in [
            ("1920x1080", "300", (1920, Some(1080))),
            ("1920X1080", "72", (1920, Some(1080))),
            ("1200xauto", "300", (1200, None)),
            // 85 / 25.4 * 300 = 1003.9.
            ("85mm", "300", (1004, None)),
            ("85mmxAUTO", "600", (2008, None)),
            ("85x60mm", "300", (1004, Some(709))),
            ("85mmx60mm", "300", (1004, Some(709))),
            ("85mmx700", "300", (1004, Some(700))),
            ("1mm", "1", (1, None)),
        ] {
            let size: PictureSize = text.parse().expect(text);
            assert_eq!(size.pixels(dpi.parse().expect("a resolution")), pixels, "{text}");
        }
        for text in ["", "85", "x", "mm", "85cm", "0mm", "-5mm", "nanmm", "infmm", "1e5mm", "0xauto", "autox5", "5x5x5"]
        {
            text.parse::<PictureSize>().expect_err(text);
        }
    }
}
