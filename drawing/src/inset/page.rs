//! The panels of a picture: their sizes and what is drawn on them.

use super::sheet::{Halo, Shape, Sheet};
use crate::canvas::{plain, shortened};
use crate::raster::{letters, letters_width};
use halfline::error::{Error, Result};
use halfline::frame::legend::{Category, Legend, Tick};
use halfline::quote::setting::SIZE;
use std::fmt::Write;

/// The longest label of a category, in letters, as in the legend's own file.
const LETTERS: usize = 41;

/// The share of the shorter side of the picture that a line of text is high, and its least height in pixels: smaller letters of
/// the font are not readable.
const SHARE: f32 = 1.0 / 32.0;
const LEAST: f32 = 9.0;

pub(super) const INK: [u8; 3] = [0x16, 0x16, 0x16];
pub(super) const PAPER: [u8; 3] = [0xff; 3];
const LINE: [u8; 3] = [0x80, 0x80, 0x80];

/// A drawing at a place of the picture: column and row of its top left pixel.
#[derive(Debug, Clone)]
pub(super) struct Panel {
    pub(super) at: [usize; 2],
    pub(super) sheet: Sheet,
}

/// The picture that panels are for; lengths are pixels.
pub(super) struct Page {
    pub(super) width: f32,
    pub(super) height: f32,
    /// The height of a line of text.
    pub(super) size: f32,
    /// The distance of panels from the picture's edges, and of their content from theirs.
    pub(super) margin: f32,
}

impl Page {
    pub(super) fn new(width: u32, height: u32) -> Self {
        let size = (width.min(height) as f32 * SHARE).max(LEAST);
        Self { width: width as f32, height: height as f32, size, margin: (0.6 * size).round() }
    }

    pub(super) fn too_small(&self, what: &str) -> Error {
        let problem = format!("a picture of {} x {} pixels is too small for {what}", self.width, self.height);
        Error::settings(problem, format!("use a larger {SIZE}"))
    }

    /// An empty panel for content of this size.
    fn panel(&self, width: f32, height: f32, what: &str) -> Result<Sheet> {
        let [width, height] = [width, height].map(|side| (side + 2.0 * self.margin).ceil());
        if width > self.width - 2.0 * self.margin || height > self.height - 2.0 * self.margin {
            return Err(self.too_small(what));
        }
        Sheet::new([width, height], true).ok_or_else(|| self.too_small(what))
    }

    /// As much of the text as fits.
    fn fitting(&self, text: &str, bold: bool, width: f32) -> String {
        let mut letters = text.chars().count();
        let mut cut = text.to_owned();
        while letters > 1 && letters_width(&cut, bold, self.size) > width {
            letters -= 1;
            cut = shortened(text, letters);
        }
        cut
    }

    pub(super) fn label(&self, label: &str, free: f32) -> Result<Sheet> {
        let text = self.fitting(label, false, free - 2.0 * self.margin);
        if letters_width(&text, false, self.size) > free - 2.0 * self.margin {
            return Err(self.too_small("the label"));
        }
        let mut sheet = self.panel(letters_width(&text, false, self.size), self.size, "the label")?;
        self.write(&mut sheet, &text, false, [self.margin, self.margin]);
        Ok(sheet)
    }

    /// A bar of the longest round length within a quarter of the picture, and its label.
    pub(super) fn scale_bar(&self, per_pixel: f64, unit: &str, free: f32) -> Result<(Sheet, String)> {
        let longest = per_pixel * f64::from((0.25 * self.width).min(free - 2.0 * self.margin));
        let length = round_length(longest).ok_or_else(|| self.too_small("the scale bar"))?;
        let long = (length / per_pixel) as f32;
        let number = if (1e-4..1e6).contains(&length) { length.to_string() } else { format!("{length:e}") };
        let text = match plain(unit).trim() {
            "" => number,
            unit => format!("{number} {}", shortened(unit, LETTERS)),
        };
        if letters_width(&text, false, self.size) > free - 2.0 * self.margin {
            return Err(self.too_small("the scale bar"));
        }
        let (wide, thick) = (long.max(letters_width(&text, false, self.size)), (0.25 * self.size).max(2.0).round());
        let mut sheet = self.panel(wide, self.size + self.margin / 2.0 + thick, "the scale bar")?;
        let middle = self.margin + (wide - letters_width(&text, false, self.size)) / 2.0;
        self.write(&mut sheet, &text, false, [middle, self.margin]);
        let (left, top) = (self.margin + (wide - long) / 2.0, (self.margin * 1.5 + self.size).round());
        fill(&mut sheet, [left, top, left + long, top + thick], INK);
        Ok((sheet, text))
    }

    /// The legend in a column, its title, and what it shows besides: a bar with the largest number at the top, a swatch for
    /// each category and each selection with a colour of its own.
    pub(super) fn legend(&self, legend: &Legend) -> Result<(Sheet, [String; 2])> {
        let (size, margin) = (self.size, self.margin);
        let widest = 0.4 * self.width;
        let title = self.fitting(&plain(&legend.heading()), true, widest);
        let below = (size + margin).round();
        // From the top of a row to the top of the next.
        let row = (1.5 * size).round();
        let free = self.height - 4.0 * margin - below;
        let bar = legend.is_scale();
        let swatches: Vec<&Category> = legend.swatches().collect();
        // A bar leaves up to half of its panel to the swatches of selections.
        let under = if bar { (row * swatches.len() as f32).min(free / 2.0) } else { free };
        let rows = ((under / row).max(0.0) as usize).min(swatches.len());
        let long = (0.5 * self.height).min(14.0 * size).min(free - size - row * rows as f32).round();
        // The last row counts what does not fit.
        let shown = if rows < swatches.len() { rows.saturating_sub(1) } else { rows };
        let ticks: Vec<Tick> = if bar { legend.ticks().into_iter().rev().collect() } else { Vec::new() };
        let numbers = || ticks.iter().map(|tick| &tick.label);
        let labels = swatches[..shown].iter().map(|swatch| shortened(&plain(&swatch.label), LETTERS));
        let labels: Vec<String> = labels.map(|label| self.fitting(&label, false, widest - row)).collect();
        let more = swatches.len() - shown;
        let more = if more > 0 { format!("and {more} more") } else { String::new() };
        let mut words = String::new();
        for label in numbers().chain(&labels).chain([&more]).filter(|label| !label.is_empty()) {
            // Writing to a String does not fail.
            let _ = write!(words, ", {label}");
        }
        let width = |text: &String| letters_width(text, false, size);
        let indent = (1.4 * size).round() + margin;
        let wide = indent + numbers().chain(&labels).map(width).fold(0.0, f32::max);
        let wide = wide.max(width(&more)).max(letters_width(&title, true, size));
        let bar_high = if bar { long + size } else { 0.0 };
        if (bar && long < 5.0 * size) || (!swatches.is_empty() && rows == 0) {
            return Err(self.too_small("the legend"));
        }
        let mut sheet = self.panel(wide, below + bar_high + row * rows as f32, "the legend")?;
        self.write(&mut sheet, &title, true, [margin, margin]);
        let top = margin + below;
        if bar {
            words += &format!(", {:?}, range {:?}", legend.map, legend.range);
            let (first, strips) = ((top + size / 2.0).round(), long as u32);
            let right = margin + (1.4 * size).round();
            for strip in 0..strips {
                let color = legend.map.srgb(1.0 - f64::from(strip) / f64::from(strips - 1));
                let y = first + strip as f32;
                fill(&mut sheet, [margin, y, right, y + 1.0], color);
            }
            for Tick { place, label } in &ticks {
                let y = first + (long - 1.0) * (1.0 - *place as f32);
                fill(
                    &mut sheet,
                    [right, y.round(), right + margin / 2.0, y.round() + (size / 14.0).max(1.0).round()],
                    INK,
                );
                self.write(&mut sheet, label, false, [margin + indent, y - size / 2.0]);
            }
        }
        let (top, side) = (top + bar_high, size.round());
        for (n, (label, swatch)) in labels.iter().zip(&swatches).enumerate() {
            let _ = write!(words, " {:?}", swatch.color);
            let y = (top + row * n as f32 + (row - side) / 2.0).round();
            fill(&mut sheet, [margin, y, margin + side, y + side], LINE);
            fill(&mut sheet, [margin + 1.0, y + 1.0, margin + side - 1.0, y + side - 1.0], swatch.color);
            self.write(&mut sheet, label, false, [margin + indent, y]);
        }
        self.write(&mut sheet, &more, false, [margin, top + row * shown as f32 + (row - side) / 2.0]);
        Ok((sheet, [title, words]))
    }

    /// A line of text with a halo, light on dark or dark on light; `None` for blanks.
    pub(super) fn haloed(&self, text: &str, is_light: bool) -> Option<Sheet> {
        let (ink, halo_ink) = if is_light { (PAPER, INK) } else { (INK, PAPER) };
        let margin = (0.22 * self.size).max(2.0);
        let [wide, high] = [letters_width(text, false, self.size), self.size].map(|side| (side + 2.0 * margin).ceil());
        // Blanks have no letters.
        letters(text, false, self.size, (0.0, 0.0))?;
        let mut sheet = Sheet::new([wide, high], false)?;
        let halo = Some(Halo { width: margin, color: halo_ink });
        self.add(&mut sheet, text, false, [margin; 2], ink, halo);
        Some(sheet)
    }

    /// Writes a line of text whose top left is at a point.
    fn write(&self, sheet: &mut Sheet, text: &str, bold: bool, at: [f32; 2]) {
        self.add(sheet, text, bold, at, INK, None);
    }

    fn add(&self, sheet: &mut Sheet, text: &str, bold: bool, at: [f32; 2], color: [u8; 3], halo: Option<Halo>) {
        // The capitals of DejaVu Sans are 0.73 of its size high; a line is centred on them.
        let at = [at[0], at[1] + 0.5 * (1.0 + 0.73) * self.size];
        sheet.shapes.push(Shape::Text { text: text.to_owned(), bold, size: self.size, at, color, halo });
    }
}

/// Fills the rectangle from left, top to right, bottom.
fn fill(sheet: &mut Sheet, corners: [f32; 4], color: [u8; 3]) {
    sheet.shapes.push(Shape::Rectangle { corners, color });
}

/// The largest 1, 2 or 5 times a power of ten that is at most `longest`; `None` if that is not a positive finite number.
fn round_length(longest: f64) -> Option<f64> {
    if !(longest > 0.0 && longest.is_finite()) {
        return None;
    }
    let decade = longest.log10().floor() as i32;
    // As text, so that it is the number nearest to the decimal one.
    let round = |decade: i32| [5, 2, 1].map(|digit| format!("{digit}e{decade}").parse::<f64>().unwrap_or(0.0));
    [decade + 1, decade, decade - 1].map(round).into_iter().flatten().find(|length| *length <= longest && *length > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round() {
        for (longest, length) in
            [(1.0, 1.0), (1.99, 1.0), (4.999, 2.0), (5.0, 5.0), (9.9, 5.0), (0.3, 0.2), (7e-9, 5e-9), (3e200, 2e200)]
        {
            assert_eq!(round_length(longest), Some(length), "{longest}");
        }
        for none in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(round_length(none), None, "{none}");
        }
    }

    #[test]
    fn texts_are_cut_where_they_do_not_fit() {
        let page = Page::new(640, 480);
        assert_eq!(page.fitting("short", false, 200.0), "short");
        let cut = page.fitting(&"long ".repeat(200), false, 200.0);
        assert!(cut.starts_with("long long") && cut.ends_with('\u{2026}'), "{cut}");
        assert!(letters_width(&cut, false, page.size) <= 200.0);
    }
}
