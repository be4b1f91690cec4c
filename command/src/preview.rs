//! Shows the picture in the terminal with half blocks in 24-bit colours, two pixels per character. Crates for this also
//! contain decoders and protocols that are not needed here.

use super::note;
use console::Term;
use halfline::frame::srgb::level;
use halfline::frame::{Aov, Frame};
use std::fmt::Write as _;
use std::io::{self, Write as _};
use std::str::FromStr;

/// When the picture is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Preview {
    /// Only on a terminal with colours.
    Auto,
    /// Always, on standard error.
    Blocks,
}

impl FromStr for Preview {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "auto" => Ok(Self::Auto),
            "blocks" => Ok(Self::Blocks),
            _ => Err("use auto or blocks"),
        }
    }
}

impl Preview {
    /// Shows the picture of `frame`, with its tone, on standard error, at most as wide as the terminal or the frame.
    pub(super) fn show(self, frame: &Frame) {
        let terminal = Term::stderr();
        if self == Self::Auto && (!terminal.is_term() || std::env::var_os("NO_COLOR").is_some()) {
            return note(format_args!(
                "no preview, because standard error is not a terminal with colours; use --preview=blocks to show it anyway"
            ));
        }
        // Two rows are left for the prompt and messages.
        let (rows, columns) = terminal.size_checked().unwrap_or((26, 80));
        if let Some(color) = frame.f32(Aov::Color) {
            let size = [frame.width as usize, frame.height as usize];
            let rows = 2 * usize::from(rows.saturating_sub(2).max(1));
            let _ = io::stderr().write_all(blocks(&frame.toning().all(color), size, [columns.into(), rows]).as_bytes());
        }
    }
}

/// The picture in at most `columns` x `rows` half blocks; each shows the mean of its linear colours.
fn blocks(color: &[f32], [width, height]: [usize; 2], [columns, rows]: [usize; 2]) -> String {
    let shrink = (width as f64 / columns as f64).max(height as f64 / rows as f64).max(1.0);
    let [w, h] = [width, height].map(|side| ((side as f64 / shrink) as usize).max(1));
    let cut = |n: usize, parts: usize, side: usize| n * side / parts;
    let mean = |x: usize, y: usize, channel: usize| {
        let (xs, ys) = (cut(x, w, width)..cut(x + 1, w, width), cut(y, h, height)..cut(y + 1, h, height));
        let count = (xs.len() * ys.len()) as f32;
        let values = ys.flat_map(|i| xs.clone().map(move |j| color[3 * (i * width + j) + channel]));
        level(values.sum::<f32>() / count)
    };
    let mut out = String::new();
    for y in (0..h).step_by(2) {
        for x in 0..w {
            let rgb = |y: usize| [0, 1, 2].map(|channel| mean(x, y, channel).to_string()).join(";");
            // Upper halves are the foreground; below the last row there is no background. Writing to a String does not
            // fail.
            let below = if y + 1 < h { format!("48;2;{}", rgb(y + 1)) } else { "49".into() };
            _ = write!(out, "\x1b[38;2;{};{below}m\u{2580}", rgb(y));
        }
        out += "\x1b[0m\n";
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pixels_are_one_character() {
        let color = [[1.0f32, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].concat();
        let expected = "\x1b[38;2;255;0;0;48;2;0;255;0m▀\x1b[0m\n\x1b[38;2;0;0;255;49m▀\x1b[0m\n";
        assert_eq!(blocks(&color, [1, 3], [80, 48]), expected);
    }

    #[test]
    fn a_large_picture_is_shrunk_to_its_means() {
        let color: Vec<f32> = (0..400 * 200).flat_map(|pixel| [(pixel % 2) as f32, 0.0, 1.0]).collect();
        let shown = blocks(&color, [400, 200], [40, 48]);
        assert_eq!((shown.lines().count(), shown.matches('▀').count()), (10, 400));
        assert!(shown.starts_with("\x1b[38;2;188;0;255;48;2;188;0;255m▀"), "half of the light is level 188: {shown:?}");
    }
}
