//! Sheets: what is drawn on a panel, as shapes and texts, and their pixels.

use crate::raster::letters;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Rect, Stroke, Transform};

/// Opacity of paper: text on it has a contrast of at least 9 on black, where it is grey, by the formula of WCAG 2.
pub(crate) const OPACITY: f32 = 0.8;

/// A drawing, of shapes from back to front; lengths are pixels of the picture, colours sRGB.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sheet {
    /// Width and height.
    pub(crate) size: [u32; 2],
    /// Whether it is white, of [`OPACITY`], below its shapes.
    pub(crate) has_paper: bool,
    pub(crate) shapes: Vec<Shape>,
}

/// A shape on a sheet.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    /// A rectangle from left, top to right, bottom.
    Rectangle { corners: [f32; 4], color: [u8; 3] },
    /// A text that begins at a point of its baseline.
    Text { text: String, bold: bool, size: f32, at: [f32; 2], color: [u8; 3], halo: Option<Halo> },
    /// A line with round ends.
    Line { ends: [[f32; 2]; 2], width: f32, color: [u8; 3] },
    /// A disc.
    Disc { at: [f32; 2], radius: f32, color: [u8; 3] },
}

/// A line around the letters of a text, below them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Halo {
    pub(crate) width: f32,
    pub(crate) color: [u8; 3],
}

impl Sheet {
    /// An empty sheet; `None` for one without area.
    pub(super) fn new(size: [f32; 2], has_paper: bool) -> Option<Self> {
        let size = size.map(|side| side as u32);
        (!size.contains(&0)).then_some(Self { size, has_paper, shapes: Vec::new() })
    }

    pub(super) fn width(&self) -> u32 {
        self.size[0]
    }

    pub(super) fn height(&self) -> u32 {
        self.size[1]
    }

    /// Its pixels; `None` where memory has no room for them.
    pub(super) fn pixels(&self) -> Option<Pixmap> {
        let mut pixels = Pixmap::new(self.size[0], self.size[1])?;
        if self.has_paper {
            pixels.fill(Color::from_rgba(1.0, 1.0, 1.0, OPACITY).unwrap_or(Color::WHITE));
        }
        self.shapes.iter().for_each(|shape| shape.draw(&mut pixels));
        Some(pixels)
    }
}

impl Shape {
    fn draw(&self, pixels: &mut Pixmap) {
        let here = Transform::identity();
        match self {
            Self::Rectangle { corners: [left, top, right, bottom], color } => {
                if let Some(rect) = Rect::from_ltrb(*left, *top, *right, *bottom) {
                    pixels.fill_rect(rect, &paint(*color), here, None);
                }
            }
            Self::Text { text, bold, size, at, color, halo } => {
                let Some(path) = letters(text, *bold, *size, (at[0], at[1])) else { return };
                if let Some(Halo { width, color }) = halo {
                    let stroke = Stroke { width: *width, line_join: LineJoin::Round, ..Stroke::default() };
                    pixels.stroke_path(&path, &paint(*color), &stroke, here, None);
                }
                pixels.fill_path(&path, &paint(*color), FillRule::Winding, here, None);
            }
            Self::Line { ends: [from, to], width, color } => {
                let mut path = PathBuilder::new();
                path.move_to(from[0], from[1]);
                path.line_to(to[0], to[1]);
                let stroke = Stroke { width: *width, line_cap: LineCap::Round, ..Stroke::default() };
                if let Some(path) = path.finish() {
                    pixels.stroke_path(&path, &paint(*color), &stroke, here, None);
                }
            }
            Self::Disc { at, radius, color } => {
                if let Some(path) = PathBuilder::from_circle(at[0], at[1], *radius) {
                    pixels.fill_path(&path, &paint(*color), FillRule::Winding, here, None);
                }
            }
        }
    }
}

fn paint([red, green, blue]: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}
