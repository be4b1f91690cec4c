//! The legend of a colour map: a bar from its least to its largest number, with what it shows above it.

use super::Plot;
use super::canvas::plain;
use super::look::FONT;
use crate::scene::style::{ColorMap, Legend};
use std::fmt::Write;

/// Size of the picture, and of the bar in it: left, top, width, height.
const SIZE: [u32; 2] = [480, 84];
const BAR: [f64; 4] = [24.0, 30.0, 432.0, 22.0];

/// Strips that the bar is drawn in, and numbers under it.
const STRIPS: usize = 216;
const TICKS: usize = 5;

impl Legend {
    /// The number at a part of the bar.
    fn at(&self, part: f64) -> f64 {
        let [low, high] = self.range;
        if self.log { (low.ln() + part * (high.ln() - low.ln())).exp() } else { low + part * (high - low) }
    }

    /// The drawn legend.
    #[must_use]
    pub fn plot(&self) -> Plot {
        let [width, height] = SIZE;
        let [left, top, wide, high] = BAR;
        let mut svg = format!(
            "<svg width=\"{width}\" height=\"{height}\" xmlns=\"http://www.w3.org/2000/svg\" font-family=\"{FONT}\">"
        );
        let mut add = |text: std::fmt::Arguments<'_>| {
            // A string takes whatever is written.
            let _ = svg.write_fmt(text);
        };
        add(format_args!("<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>"));
        let title = plain(&self.name).replace('&', "&amp;").replace('<', "&lt;");
        let log = if self.log { " (logarithmic)" } else { "" };
        add(format_args!("<text x=\"{left}\" y=\"20\" font-size=\"14\" font-weight=\"bold\">{title}{log}</text>"));
        for strip in 0..STRIPS {
            let part = strip as f64 / (STRIPS - 1) as f64;
            let shown = if self.map == ColorMap::Category { self.at(part).floor() } else { part };
            let [red, green, blue] = self.map.srgb(shown);
            let x = left + wide * strip as f64 / STRIPS as f64;
            // A little wider than its place, so that no seam shows between strips.
            let w = wide / STRIPS as f64 + if strip + 1 < STRIPS { 0.5 } else { 0.0 };
            add(format_args!(
                "<rect x=\"{x}\" y=\"{top}\" width=\"{w}\" height=\"{high}\" fill=\"#{red:02x}{green:02x}{blue:02x}\"/>"
            ));
        }
        for tick in 0..TICKS {
            let part = tick as f64 / (TICKS - 1) as f64;
            let x = left + part * wide;
            let anchor = match tick {
                0 => "start",
                _ if tick + 1 == TICKS => "end",
                _ => "middle",
            };
            let (y, number) = (top + high, short(self.at(part)));
            add(format_args!("<path d=\"M{x} {y}v4\" stroke=\"#000000\"/>"));
            let below = y + 19.0;
            add(format_args!(
                "<text x=\"{x}\" y=\"{below}\" font-size=\"12\" text-anchor=\"{anchor}\">{number}</text>"
            ));
        }
        svg.push_str("</svg>");
        Plot { name: "legend", caption: "What the colours stand for.", svg }
    }
}

/// A number to four digits.
fn short(value: f64) -> String {
    let decade = value.abs().log10().floor();
    if value == 0.0 || !(-3.0..5.0).contains(&decade) {
        return if value == 0.0 { "0".into() } else { format!("{value:.3e}") };
    }
    let text = format!("{value:.*}", (3.0 - decade).max(0.0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_legend_names_its_ends_and_is_drawn() {
        let legend = Legend { name: "a<b".into(), map: ColorMap::Viridis, range: [1.0, 100.0], log: true };
        let plot = legend.plot();
        assert_eq!([0.0, 123.456, -0.5, 6.02e23, 99999.0].map(short), ["0", "123.5", "-0.5", "6.020e23", "99999"]);
        for part in ["a&lt;b (logarithmic)", ">1<", ">10<", ">100<", "#440154", "#fde725"] {
            assert!(plot.svg.contains(part), "{part} in {}", plot.svg);
        }
        // Numbers are drawn too: dark pixels under the bar's marks, in a picture of twice the size.
        let picture = image::load_from_memory(&plot.png().expect("a picture")).expect("a PNG").to_luma8();
        let below = 2 * (BAR[1] + BAR[3] + 6.0) as u32;
        let dark = picture.enumerate_pixels().filter(|(_, y, p)| *y >= below && p.0[0] < 64).count();
        assert!(dark > 50, "{dark} dark pixels in the numbers");
    }
}
