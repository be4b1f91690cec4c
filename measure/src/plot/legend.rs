//! The legend of colours: a bar from the minimum to the maximum, or a swatch for every category, under the name of the
//! coloured quantity.

use super::Plot;
use super::canvas::{Area, Drawing, drawing, plain, shortened, text};
use super::look::{Drawn, INK, bold, centered, font};
use super::raster::{missing, warning};
use halfline::error::{Error, Result};
use halfline_files::read::style::Legend;
use halfline_files::write::file::write_atomically;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::io;
use std::path::Path;

/// Width of the picture; left, top, width and height of the bar in it.
const WIDTH: i32 = 960;
const BAR: [i32; 4] = [48, 60, 864, 44];

/// The number of strips of the bar, each of whole pixels, and of the numbers under it.
const STRIPS: i32 = 216;
pub(super) const TICKS: i32 = 5;

/// Side of a swatch, height of a row, distance between a swatch and its label, and between a label and the next swatch.
const SWATCH: i32 = 28;
const ROW: i32 = 44;
const GAPS: [i32; 2] = [12, 36];

/// The width of most letters of a label at most; the most letters of a label, and the most labels.
const LETTER: i32 = 16;
const LETTERS: usize = 41;
const LABELS: usize = 120;

/// Height of a label.
const SIZE: i32 = 24;

/// Whether a file name has this extension.
fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// A legend as a picture.
#[derive(Debug)]
pub struct DrawnLegend<'a>(pub &'a Legend);

impl std::ops::Deref for DrawnLegend<'_> {
    type Target = Legend;

    fn deref(&self) -> &Legend {
        self.0
    }
}

impl DrawnLegend<'_> {
    /// The number at a fraction of the bar.
    pub(super) fn at(&self, part: f64) -> f64 {
        let [low, high] = self.range;
        if self.log { (low.ln() + part * (high.ln() - low.ln())).exp() } else { low + part * (high - low) }
    }

    /// The numbers of the bar from its lower end to the upper one, to four digits. On a linear scale a number that is less
    /// than half of the fourth digit of the end that is farther from 0 is written as 0.
    pub(super) fn ticks(&self) -> Vec<String> {
        let digits = |x: f64| if x == 0.0 || !x.is_finite() { 0 } else { x.abs().log10().floor() as i32 };
        let largest = self.range.iter().fold(0.0, |largest: f64, end| largest.max(end.abs()));
        let tick = |tick: i32| {
            let value = self.at(f64::from(tick) / f64::from(TICKS - 1));
            let is_nothing = !self.log && value.abs() < 0.5 * 10f64.powi(digits(largest) - 3);
            short(if is_nothing { 0.0 } else { value })
        };
        (0..TICKS).map(tick).collect()
    }

    /// The legend as a picture.
    ///
    /// # Errors
    /// [`Error::Io`] at the plot's name if drawing fails.
    pub fn plot(&self) -> Result<Plot> {
        let name = "legend";
        let drawn = if self.is_scale() { self.bar() } else { self.rows() };
        let Drawing { svg, png } = drawn.map_err(|error| Error::write(name, io::Error::other(error)))?;
        Ok(Plot { name, caption: "The numbers or categories that the colours show.", svg, png })
    }

    /// What the PNG of [`Legend::plot`] does not show as it is written, in a whole sentence: letters that the font lacks.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        let labels = self.labels().into_iter().flat_map(|label| missing(&plain(&label), false).collect::<Vec<_>>());
        warning(&missing(&plain(&self.name), true).chain(labels).collect())
    }

    /// Checks that the name of a file is one of a legend, for use before the work begins.
    ///
    /// # Errors
    /// [`Error::Settings`] for an extension other than .svg and .png.
    pub fn check_file(path: &Path) -> Result<()> {
        if !ends_in(path, "png") && !ends_in(path, "svg") {
            let problem = format!("a legend cannot be written to {}", path.display());
            return Err(Error::settings(problem, "use the file name extension .svg or .png"));
        }
        Ok(())
    }

    /// Writes the legend to a file, completely or not at all, in the format of its extension.
    ///
    /// # Errors
    /// Those of [`Legend::plot`] and of writing.
    pub fn write(&self, path: &Path) -> Result<()> {
        let plot = self.plot()?;
        let bytes = if ends_in(path, "png") { plot.png } else { plot.svg.into_bytes() };
        write_atomically(path, |out| out.write_all(&bytes))
    }

    fn title(&self, area: &Area<'_>) -> Drawn {
        let log = if self.log { " (logarithmic)" } else { "" };
        text(area, &format!("{}{log}", self.name), &bold(28), (BAR[0], 30))
    }

    /// The labels of the first categories.
    fn labels(&self) -> Vec<String> {
        self.swatches().take(LABELS).map(|category| shortened(&category.label, LETTERS)).collect()
    }

    /// A swatch and a label for every category, in columns that fit the longest.
    fn rows(&self) -> Drawn<Drawing> {
        let top = BAR[1];
        drawing([WIDTH, top + self.height_of_swatches() + 16], |area| {
            self.title(area)?;
            self.draw_swatches(area, top)?;
            Ok(Vec::new())
        })
    }

    /// The number of columns of swatches and the width of one; the rows.
    fn columns(&self) -> ([i32; 2], i32) {
        let labels = self.labels();
        let longest = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0);
        let column = SWATCH + GAPS[0] + LETTER * longest as i32 + GAPS[1];
        let columns = ((BAR[2] + GAPS[1]) / column).max(1);
        ([columns, column], labels.len().div_ceil(columns as usize) as i32)
    }

    fn height_of_swatches(&self) -> i32 {
        let is_cut = self.swatches().count() > LABELS;
        ROW * (self.columns().1 + i32::from(is_cut))
    }

    /// Draws the swatches below a row of pixels.
    fn draw_swatches(&self, area: &Area<'_>, top: i32) -> Drawn {
        let (left, labels, ([columns, column], rows)) = (BAR[0], self.labels(), self.columns());
        for (n, (label, category)) in (0..).zip(labels.iter().zip(self.swatches())) {
            let (x, y) = (left + column * (n % columns), top + ROW * (n / columns));
            let [red, green, blue] = category.color;
            let (right, bottom) = (x + SWATCH, y + SWATCH);
            area.draw(&Rectangle::new([(x, y), (right, bottom)], RGBColor(red, green, blue).filled()))?;
            // An outline, so that white is visible on white.
            let outline = vec![(x, y), (right, y), (right, bottom), (x, bottom), (x, y), (right, y)];
            area.draw(&PathElement::new(outline, RGBColor(0x80, 0x80, 0x80).stroke_width(2)))?;
            text(area, label, &font(SIZE), (right + GAPS[0], y + SWATCH / 2))?;
        }
        let more = self.swatches().count() - labels.len();
        if more > 0 {
            text(area, &format!("and {more} more"), &font(SIZE), (left, top + ROW * rows + SWATCH / 2))?;
        }
        Ok(())
    }

    /// The colour map from one end to the other, with numbers under it, and swatches of selections below.
    fn bar(&self) -> Drawn<Drawing> {
        let [left, top, wide, high] = BAR;
        const BELOW: i32 = 168;
        drawing([WIDTH, BELOW + self.height_of_swatches()], |area| {
            self.title(area)?;
            for strip in 0..STRIPS {
                let [red, green, blue] = self.map.srgb(f64::from(strip) / f64::from(STRIPS - 1));
                let edge = |strip| left + wide * strip / STRIPS;
                let corners = [(edge(strip), top), (edge(strip + 1), top + high)];
                area.draw(&Rectangle::new(corners, RGBColor(red, green, blue).filled()))?;
            }
            for (tick, number) in (0..).zip(self.ticks()) {
                let (x, y) = (left + wide * tick / (TICKS - 1), top + high);
                area.draw(&PathElement::new(vec![(x, y), (x, y + 8)], INK.stroke_width(2)))?;
                let style = match tick {
                    0 => font(SIZE),
                    _ if tick + 1 == TICKS => font(SIZE).pos(Pos::new(HPos::Right, VPos::Center)),
                    _ => centered(&font(SIZE)),
                };
                text(area, &number, &style, (x, y + 30))?;
            }
            self.draw_swatches(area, BELOW)?;
            Ok(Vec::new())
        })
    }
}

/// A number to four digits.
pub(super) fn short(value: f64) -> String {
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
    use halfline_files::read::style::{Category, ColorMap};

    fn texts(plot: &Plot) -> Vec<String> {
        let document = roxmltree::Document::parse(&plot.svg).expect("SVG");
        let texts = document.descendants().filter(|node| node.is_text()).filter_map(|node| node.text());
        texts.map(str::trim).filter(|text| !text.is_empty()).map(str::to_owned).collect()
    }

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
            names: Vec::new(),
            overrides: Vec::new(),
        };
        let plot = |count| DrawnLegend(&legend(count)).plot().expect("a picture");
        assert_eq!(texts(&plot(3)), ["chain", "A", "B<&", "(blank)"], "no numbers of a bar");
        for color in ["#0080ff", "#0180ff", "#0280ff"] {
            assert!(plot(3).svg.contains(color), "{color} in {}", plot(3).svg);
        }
        let picture = |count| image::load_from_memory(&plot(count).png).expect("a PNG").to_rgb8();
        let one = picture(1);
        let middle = SWATCH / 2;
        assert_eq!(one.get_pixel((BAR[0] + middle) as u32, (BAR[1] + middle) as u32).0, [0, 0x80, 0xff]);
        assert!(picture(4).height() > one.height(), "long labels take a row each");
        let many = texts(&plot(200));
        assert!(many.iter().any(|text| text == "and 80 more"), "{many:?}");
        assert!(many.iter().any(|text| text.starts_with("long long") && text.ends_with('\u{2026}')), "{many:?}");
    }

    #[test]
    fn a_legend_names_its_ends_and_is_drawn() {
        let legend = Legend {
            name: "a<b".into(),
            map: ColorMap::Viridis,
            range: [1.0, 100.0],
            log: true,
            categories: Vec::new(),
            names: Vec::new(),
            overrides: Vec::new(),
        };
        let plot = DrawnLegend(&legend).plot().expect("a picture");
        assert_eq!([0.0, 123.456, -0.5, 6.02e23, 99999.0].map(short), ["0", "123.5", "-0.5", "6.020e23", "99999"]);
        let texts = texts(&plot);
        assert_eq!(
            (&texts[..2], &texts[3..4], &texts[5..]),
            (&["a<b (logarithmic)".into(), "1".into()][..], &["10".into()][..], &["100".into()][..])
        );
        for color in ["#440154", "#fde725"] {
            assert!(plot.svg.contains(color), "{color} in {}", plot.svg);
        }
        // The numbers are drawn too: dark pixels under the bar's marks.
        let picture = image::load_from_memory(&plot.png).expect("a PNG").to_luma8();
        let below = (BAR[1] + BAR[3] + 12) as u32;
        let dark = picture.enumerate_pixels().filter(|(_, y, p)| *y >= below && p.0[0] < 64).count();
        assert!(dark > 50, "{dark} dark pixels in the numbers");
    }
}
