//! Insets of a picture: the legend of its colours, a label, a scale bar. Each is dark on a translucent white panel,
//! which is readable on dark and on light backgrounds. The size of the letters follows the picture's.

mod label;
mod line;
mod mark;
mod page;
mod scale;
pub(crate) mod sheet;

use super::canvas::plain;
use super::raster::{missing, missing_letters};
use glam::DVec2;
use halfline::error::{Result, named};
use halfline::frame::legend::Legend;
use halfline::frame::srgb::linear;
use halfline::frame::{Aov, Buffer, Data, Frame};
use line::Line;
use page::{Page, Panel};
use sheet::Sheet;
use std::collections::BTreeSet;

pub use label::{Label, LabelValues};
pub use mark::Thing;

/// The place of the legend in the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Corner {
    /// In the middle of the right side.
    #[default]
    Right,
    /// At the top left, below the label.
    TopLeft,
    /// At the top right.
    TopRight,
    /// At the bottom left, above the scale bar.
    BottomLeft,
    /// At the bottom right.
    BottomRight,
}

named! {
    Corner, "corner",
    Right "right" TopLeft "top-left" TopRight "top-right" BottomLeft "bottom-left" BottomRight "bottom-right"
}

/// A bar of a known length.
#[derive(Debug, Clone, PartialEq)]
pub struct ScaleBar {
    /// Scene units in a pixel.
    pub per_pixel: f64,
    /// The unit in its label; empty for none.
    pub unit: String,
}

/// The insets of one picture: legend, label, scale bar.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Insets {
    /// The legend, and where it is.
    pub legend: Option<(Legend, Corner)>,
    /// Text at the top left.
    pub label: Option<String>,
    /// A scale bar at the bottom left.
    pub scale_bar: Option<ScaleBar>,
}

/// Drawn panels at their places in the picture.
#[derive(Debug, Clone, Default)]
pub struct Panels {
    panels: Vec<Panel>,
    /// Lines from things to their marks, below the panels.
    lines: Vec<(Line, Panel)>,
    words: String,
    /// Letters of the texts that the font lacks.
    unknown: BTreeSet<char>,
}

/// The part of a frame's colour and alpha that panels cover.
#[derive(Debug)]
pub struct Covered(Vec<(Aov, usize, Vec<f32>)>);

/// The largest share of the picture's width that a legend takes from what is framed beside it.
const WIDEST: f64 = 0.8;

/// The most letters of a label.
pub const MOST_LETTERS: usize = 1000;

impl Insets {
    /// Whether nothing is drawn.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The shares of the picture's width that the legend takes at its left and right side, with its distance from them.
    ///
    /// # Errors
    /// [`Error::Settings`](halfline::Error::Settings) if the picture is too small for the legend.
    pub fn legend_shares(&self, width: u32, height: u32) -> Result<[f64; 2]> {
        let Some((legend, corner)) = &self.legend else { return Ok([0.0; 2]) };
        let page = Page::new(width, height);
        let (sheet, _) = page.legend(legend)?;
        let share = (f64::from(page.margin) + f64::from(sheet.width())) / f64::from(width);
        if share > WIDEST {
            return Err(page.too_small("the legend beside the spheres"));
        }
        Ok(match corner {
            Corner::TopLeft | Corner::BottomLeft => [share, 0.0],
            Corner::Right | Corner::TopRight | Corner::BottomRight => [0.0, share],
        })
    }

    /// The panels for a picture of `width` x `height` pixels. Texts that do not fit are cut.
    ///
    /// # Errors
    /// [`Error::Settings`](halfline::Error::Settings) if the picture is too small for one of them, or a scale bar has no length.
    pub fn panels(&self, width: u32, height: u32) -> Result<Panels> {
        let page = Page::new(width, height);
        let (mut words, mut unknown) = (Vec::new(), BTreeSet::new());
        let legend = match &self.legend {
            Some((legend, corner)) => {
                let (sheet, [title, text]) = page.legend(legend)?;
                unknown.extend(missing(&title, true).chain(missing(&text, false)));
                words.push(format!("legend {}: {title}{text}", corner.name()));
                Some((sheet, *corner))
            }
            None => None,
        };
        let on_the_right =
            legend.as_ref().filter(|(_, corner)| !matches!(corner, Corner::TopLeft | Corner::BottomLeft));
        let taken = on_the_right.map_or(0.0, |(sheet, _)| sheet.width() as f32 + page.margin);
        let free = page.width - 2.0 * page.margin - taken;
        let label = self.label.as_deref().map(plain).filter(|label| !label.trim().is_empty());
        let label = label.map(|label| page.label(&label, free).map(|sheet| (sheet, label))).transpose()?;
        let bar = self.scale_bar.as_ref().map(|bar| page.scale_bar(bar.per_pixel, &bar.unit, free)).transpose()?;
        if let Some((_, label)) = &label {
            unknown.extend(missing(label, false));
            words.push(format!("label: {label}"));
        }
        if let Some((_, text)) = &bar {
            unknown.extend(missing(text, false));
            words.push(format!("scale bar: {text}"));
        }
        let mut panels = Vec::new();
        let (mut top, mut bottom) = (page.margin, page.height - page.margin);
        if let Some((sheet, _)) = label {
            let panel = Panel { at: [page.margin as usize, top as usize], sheet };
            if legend.as_ref().is_some_and(|(_, corner)| *corner == Corner::TopLeft) {
                top += panel.sheet.height() as f32 + page.margin;
            }
            panels.push(panel);
        }
        if let Some((sheet, _)) = bar {
            let row = bottom - sheet.height() as f32;
            if legend.as_ref().is_some_and(|(_, corner)| *corner == Corner::BottomLeft) {
                bottom = row - page.margin;
            }
            panels.push(Panel { at: [page.margin as usize, row.max(0.0) as usize], sheet });
        }
        if let Some((sheet, corner)) = legend {
            let [wide, high] = [sheet.width() as f32, sheet.height() as f32];
            if high > bottom - top {
                return Err(page.too_small("the legend"));
            }
            let left = match corner {
                Corner::TopLeft | Corner::BottomLeft => page.margin,
                _ => page.width - page.margin - wide,
            };
            let row = match corner {
                Corner::TopLeft | Corner::TopRight => top,
                Corner::BottomLeft | Corner::BottomRight => bottom - high,
                Corner::Right => ((page.height - high) / 2.0).floor(),
            };
            panels.push(Panel { at: [left.max(0.0) as usize, row.max(0.0) as usize], sheet });
        }
        Ok(Panels { panels, lines: Vec::new(), words: words.join("; "), unknown })
    }
}

impl Panels {
    /// The texts of the panels and the place of the legend, for provenance; marks are among them if [`Panels::also_drawn`] adds
    /// them. The panels depend on nothing else but the picture's size.
    #[must_use]
    pub fn words(&self) -> &str {
        &self.words
    }

    /// Adds what else is drawn, such as marks, to the words for provenance.
    pub fn also_drawn(&mut self, words: &str) {
        self.words += if self.words.is_empty() { "" } else { "; " };
        self.words += words;
    }

    /// All that is drawn, from back to front, with the places of the top left corners.
    pub(crate) fn sheets(&self) -> impl Iterator<Item = (DVec2, &Sheet)> {
        let panels = self.lines.iter().map(|(_, panel)| panel).chain(&self.panels);
        panels.map(|Panel { at, sheet }| (DVec2::from(at.map(|x| x as f64)), sheet))
    }

    /// A warning about letters that the font lacks, in a whole sentence; `None` if it lacks none.
    #[must_use]
    pub fn warning(&self) -> Option<String> {
        missing_letters(&self.unknown)
    }

    /// Whether panels cover pixels of spheres of a whole frame, by the `ids` of its pixels. Marks are added after that.
    #[must_use]
    pub fn cover_spheres(&self, ids: &[i32], width: u32) -> bool {
        let width = width as usize;
        self.panels.iter().any(|Panel { at: [left, top], sheet }| {
            let [wide, high] = [sheet.width(), sheet.height()].map(|side| side as usize);
            let (first, end) = ((*left).min(width), (left + wide).min(width));
            let mut rows = ids.chunks(width.max(1)).skip(*top).take(high);
            rows.any(|row| row.get(first..end).is_some_and(|ids| ids.iter().any(|id| *id >= 0)))
        })
    }

    /// Draws the panels on the colour of a whole frame, and in its alpha if the background is transparent; returns what they cover.
    pub fn draw(&self, frame: &mut Frame, transparent: bool) -> Covered {
        let mut covered = Vec::new();
        let columns = frame.width as usize;
        let lines = self.lines.iter().map(|(_, panel)| panel);
        for Panel { at: [left, top], sheet } in lines.chain(&self.panels) {
            let Some(pixels) = sheet.pixels() else { continue };
            for (row, line) in pixels.pixels().chunks(sheet.width() as usize).enumerate() {
                let line = &line[..line.len().min(columns.saturating_sub(*left))];
                for buffer in &mut frame.buffers {
                    let channels = buffer.channels();
                    let Some(values) = values(buffer, transparent) else { continue };
                    let start = channels * ((top + row) * columns + left);
                    let Some(values) = values.get_mut(start..start + channels * line.len()) else { continue };
                    covered.push((if channels == 3 { Aov::Color } else { Aov::Alpha }, start, values.to_vec()));
                    for (values, pixel) in values.chunks_exact_mut(channels).zip(line) {
                        let (alpha, own) = (f32::from(pixel.alpha()) / 255.0, pixel.demultiply());
                        let own = linear([own.red(), own.green(), own.blue()]);
                        for (channel, value) in values.iter_mut().enumerate() {
                            // Over: colour is premultiplied by alpha where that is written.
                            let above = if channels == 3 { own[channel] } else { 1.0 };
                            *value = alpha * above + (1.0 - alpha) * *value;
                        }
                    }
                }
            }
        }
        Covered(covered)
    }
}

impl Covered {
    /// Puts back what the panels cover.
    pub fn restore(self, frame: &mut Frame) {
        // The last drawn first, where panels overlap.
        for (aov, start, old) in self.0.into_iter().rev() {
            let buffer = frame.buffers.iter_mut().find(|buffer| buffer.aov == aov);
            if let Some(values) = buffer.and_then(|buffer| values(buffer, true)) {
                values[start..start + old.len()].copy_from_slice(&old);
            }
        }
    }
}

/// The values of a buffer that panels change.
fn values(buffer: &mut Buffer, transparent: bool) -> Option<&mut [f32]> {
    match (buffer.aov, &mut buffer.data) {
        (Aov::Color, Data::F32(values)) => Some(values),
        (Aov::Alpha, Data::F32(values)) if transparent => Some(values),
        _ => None,
    }
}
