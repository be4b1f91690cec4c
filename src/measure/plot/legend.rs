//! The legend of colours: a bar from the least to the largest number, or a swatch for every category, with what they show above
//! them.

use super::Plot;
use super::canvas::plain;
use super::look::FONT;
use crate::scene::style::Legend;
use std::fmt::Write;

/// Size of the picture, and of the bar in it: left, top, width, height.
const SIZE: [u32; 2] = [480, 84];
const BAR: [f64; 4] = [24.0, 30.0, 432.0, 22.0];

/// Strips that the bar is drawn in, and numbers under it.
const STRIPS: usize = 216;
const TICKS: usize = 5;

/// Side of a swatch, height of a row of them, and what stands between a swatch, its label and the next.
const SWATCH: f64 = 14.0;
const ROW: f64 = 22.0;
const GAPS: [f64; 2] = [6.0, 18.0];

/// Width of a letter of a label at most, but for few; letters of a label, and labels, that are shown.
const LETTER: f64 = 8.0;
const LETTERS: usize = 40;
const LABELS: usize = 120;

impl Legend {
    /// The number at a part of the bar.
    fn at(&self, part: f64) -> f64 {
        let [low, high] = self.range;
        if self.log { (low.ln() + part * (high.ln() - low.ln())).exp() } else { low + part * (high - low) }
    }

    /// The drawn legend.
    #[must_use]
    pub fn plot(&self) -> Plot {
        let svg = if self.categories.is_empty() { self.bar() } else { self.swatches() };
        Plot { name: "legend", caption: "What the colours stand for.", svg }
    }

    /// The beginning of the picture, up to its title.
    fn begin(&self, height: u32) -> String {
        let width = SIZE[0];
        let left = BAR[0];
        let title = escaped(&self.name);
        let log = if self.log { " (logarithmic)" } else { "" };
        format!(
            "<svg width=\"{width}\" height=\"{height}\" xmlns=\"http://www.w3.org/2000/svg\" font-family=\"{FONT}\">\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\
             <text x=\"{left}\" y=\"20\" font-size=\"14\" font-weight=\"bold\">{title}{log}</text>"
        )
    }

    /// A swatch and a label for every category, in columns that fit the longest.
    fn swatches(&self) -> String {
        let [left, top, wide, _] = BAR;
        let labels: Vec<String> =
            self.categories.iter().take(LABELS).map(|category| short_label(&category.label)).collect();
        let longest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
        let column = SWATCH + GAPS[0] + LETTER * longest as f64 + GAPS[1];
        let columns = ((wide + GAPS[1]) / column).floor().max(1.0) as usize;
        let rows = labels.len().div_ceil(columns);
        let more = self.categories.len() - labels.len();
        let height = top + ROW * (rows + usize::from(more > 0)) as f64 + 8.0;
        let mut svg = self.begin(height as u32);
        for (n, (label, category)) in labels.iter().zip(&self.categories).enumerate() {
            let (x, y) = (left + column * (n % columns) as f64, top + ROW * (n / columns) as f64);
            let [red, green, blue] = category.color;
            let (at, base, label) = (x + SWATCH + GAPS[0], y + 11.5, escaped(label));
            // An outline, for white on white.
            svg += &format!(
                "<rect x=\"{x}\" y=\"{y}\" width=\"{SWATCH}\" height=\"{SWATCH}\" \
                 fill=\"#{red:02x}{green:02x}{blue:02x}\" stroke=\"#808080\"/>\
                 <text x=\"{at}\" y=\"{base}\" font-size=\"12\">{label}</text>"
            );
        }
        if more > 0 {
            let y = top + ROW * rows as f64 + 11.5;
            svg += &format!("<text x=\"{left}\" y=\"{y}\" font-size=\"12\">and {more} more</text>");
        }
        svg + "</svg>"
    }

    /// The map from one end to the other, with numbers under it.
    fn bar(&self) -> String {
        let [left, top, wide, high] = BAR;
        let mut svg = self.begin(SIZE[1]);
        let mut add = |text: std::fmt::Arguments<'_>| {
            // A string takes whatever is written.
            let _ = svg.write_fmt(text);
        };
        for strip in 0..STRIPS {
            let part = strip as f64 / (STRIPS - 1) as f64;
            let [red, green, blue] = self.map.srgb(part);
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
        svg + "</svg>"
    }
}

/// Text between tags of XML.
fn escaped(text: &str) -> String {
    plain(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A label that fits a row.
fn short_label(label: &str) -> String {
    match label.char_indices().nth(LETTERS) {
        Some((end, _)) => format!("{}\u{2026}", &label[..end]),
        None => label.to_owned(),
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
    use crate::scene::style::{Category, ColorMap};

    #[test]
    fn categories_have_swatches_with_bare_labels() {
        let label = |n: usize| ["A", "B<&", "(blank)", &"long ".repeat(20)][n % 4].to_owned();
        let legend = |count: usize| Legend {
            name: "chain".into(),
            map: ColorMap::Category,
            range: [0.0, 3.0],
            log: false,
            categories: (0..count)
                .map(|n| Category { label: label(n), color: [n as u8, 0x80, 0xff], count: 1 })
                .collect(),
        };
        let plot = legend(3).plot();
        for part in [">chain<", ">A<", ">B&lt;&amp;<", ">(blank)<", "#0080ff", "#0180ff", "#0280ff"] {
            assert!(plot.svg.contains(part), "{part} in {}", plot.svg);
        }
        assert!(!plot.svg.contains(">0<") && !plot.svg.contains("<path"), "no bar, no ticks: {}", plot.svg);
        let picture = |count| {
            let bytes = legend(count).plot().png().expect("a picture");
            image::load_from_memory(&bytes).expect("a PNG").to_rgb8()
        };
        // A row of one swatch, in a picture of twice the size: its middle has its colour.
        let one = picture(1);
        let middle = 2.0 * (SWATCH / 2.0);
        assert_eq!(one.get_pixel((2.0 * BAR[0] + middle) as u32, (2.0 * BAR[1] + middle) as u32).0, [0, 0x80, 0xff]);
        assert!(picture(4).height() > one.height(), "long labels take a row each");
        let many = legend(200).plot().svg;
        assert!(many.contains(">and 80 more<") && many.contains("long long") && many.contains('\u{2026}'), "{many}");
    }

    #[test]
    fn a_legend_names_its_ends_and_is_drawn() {
        let legend =
            Legend { name: "a<b".into(), map: ColorMap::Viridis, range: [1.0, 100.0], log: true, categories: vec![] };
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
