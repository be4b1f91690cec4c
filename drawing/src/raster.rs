//! The plotters backend of every drawing: each element is written as SVG and filled as pixels. Text is drawn from the outlines
//! of DejaVu Sans, so that no PNG depends on the fonts of the machine.

use super::cells::Cells;
use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, Point};
use halfline::quote::list;
use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters_backend::DrawingErrorKind;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendStyle, BackendTextStyle, FontStyle, FontTransform};
use std::collections::BTreeSet;
use std::io;
use std::sync::LazyLock;
use tiny_skia::{Color, FillRule, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

type Outcome = Result<(), DrawingErrorKind<io::Error>>;

/// Draws to an SVG and to pixels of the same size.
pub struct SvgAndPixels<'a> {
    svg: SVGBackend<'a>,
    pixels: &'a mut Pixmap,
}

impl<'a> SvgAndPixels<'a> {
    pub(super) fn new(svg: &'a mut String, pixels: &'a mut Pixmap) -> Self {
        Self { svg: SVGBackend::with_string(svg, (pixels.width(), pixels.height())), pixels }
    }

    fn fill(&mut self, path: Option<Path>, color: BackendColor, transform: Transform) {
        if let Some(path) = path {
            self.pixels.fill_path(&path, &paint(color), FillRule::Winding, transform, None);
        }
    }

    fn fill_or_stroke<S: BackendStyle>(&mut self, path: Option<Path>, style: &S, filled: bool) {
        if filled {
            self.fill(path, style.color(), Transform::identity());
        } else if let Some(path) = path {
            // Butt caps and mitred joins, as in SVG.
            let stroke = Stroke { width: style.stroke_width() as f32, ..Stroke::default() };
            self.pixels.stroke_path(&path, &paint(style.color()), &stroke, Transform::identity(), None);
        }
    }
}

impl DrawingBackend for SvgAndPixels<'_> {
    type ErrorType = io::Error;

    fn get_size(&self) -> (u32, u32) {
        self.svg.get_size()
    }

    fn ensure_prepared(&mut self) -> Outcome {
        self.svg.ensure_prepared()
    }

    fn present(&mut self) -> Outcome {
        self.svg.present()
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Outcome {
        self.svg.draw_pixel((x, y), color)?;
        self.fill(rectangle((x, y), (x + 1, y + 1)), color, Transform::identity());
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Outcome {
        self.svg.draw_line(from, to, style)?;
        self.fill_or_stroke(polyline(&[from, to], false), style, false);
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(&mut self, a: BackendCoord, b: BackendCoord, style: &S, filled: bool) -> Outcome {
        self.svg.draw_rect(a, b, style, filled)?;
        self.fill_or_stroke(rectangle(a, b), style, filled);
        Ok(())
    }

    fn draw_path<S, I>(&mut self, points: I, style: &S) -> Outcome
    where
        S: BackendStyle,
        I: IntoIterator<Item = BackendCoord>,
    {
        let points: Vec<_> = points.into_iter().collect();
        self.svg.draw_path(points.iter().copied(), style)?;
        self.fill_or_stroke(polyline(&points, false), style, false);
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(&mut self, at: BackendCoord, radius: u32, style: &S, filled: bool) -> Outcome {
        self.svg.draw_circle(at, radius, style, filled)?;
        self.fill_or_stroke(PathBuilder::from_circle(at.0 as f32, at.1 as f32, radius as f32), style, filled);
        Ok(())
    }

    fn fill_polygon<S, I>(&mut self, points: I, style: &S) -> Outcome
    where
        S: BackendStyle,
        I: IntoIterator<Item = BackendCoord>,
    {
        let points: Vec<_> = points.into_iter().collect();
        self.svg.fill_polygon(points.iter().copied(), style)?;
        self.fill_or_stroke(polyline(&points, true), style, true);
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Outcome {
        self.svg.draw_text(text, style, at)?;
        let face = face(matches!(style.style(), FontStyle::Bold));
        let (x, y) = (at.0 as f32, at.1 as f32);
        // plotters writes a size divided by 1.24 into the SVG.
        let size = (style.size() / 1.24) as f32;
        let ex = face.ex(size);
        // The offsets that plotters writes into the SVG.
        let baseline = match style.anchor().v_pos {
            VPos::Top => y + 0.76 * size,
            VPos::Center => y + 0.5 * ex,
            VPos::Bottom => y - 0.5 * ex,
        };
        let left = match style.anchor().h_pos {
            HPos::Left => x,
            HPos::Center => x - 0.5 * face.width(text, size),
            HPos::Right => x - face.width(text, size),
        };
        let degrees = match style.transform() {
            FontTransform::None => 0.0,
            FontTransform::Rotate90 => 90.0,
            FontTransform::Rotate180 => 180.0,
            FontTransform::Rotate270 => 270.0,
        };
        let path = face.outlines(text, size, (left, baseline));
        self.fill(path, style.color(), Transform::from_rotate_at(degrees, x, y));
        Ok(())
    }
}

/// Fills square cells. Their edges are rounded to whole pixels, as with `shape-rendering="crispEdges"` in SVG.
pub(super) fn fill_cells(pixels: &mut Pixmap, cells: &Cells) {
    let edge = |start: i32, index: usize| (f64::from(start) + cells.side * index as f64).round() as f32;
    for (index, [r, g, b]) in cells.colors.iter().enumerate() {
        let (column, row) = (index % cells.size[0], index / cells.size[0]);
        let [left, right] = [column, column + 1].map(|column| edge(cells.at.0, column));
        let [top, bottom] = [row, row + 1].map(|row| edge(cells.at.1, row));
        // A cell narrower than a pixel may have no width.
        if let Some(rect) = Rect::from_ltrb(left, top, right, bottom) {
            let color = BackendColor { alpha: 1.0, rgb: (*r, *g, *b) };
            pixels.fill_rect(rect, &paint(color), Transform::identity(), None);
        }
    }
}

fn paint(color: BackendColor) -> Paint<'static> {
    let (r, g, b) = color.rgb;
    let mut paint = Paint::default();
    paint.set_color(Color::from_rgba8(r, g, b, (color.alpha * 255.0).round() as u8));
    paint
}

fn rectangle(a: BackendCoord, b: BackendCoord) -> Option<Path> {
    Rect::from_ltrb(a.0 as f32, a.1 as f32, b.0 as f32, b.1 as f32).map(PathBuilder::from_rect)
}

fn polyline(points: &[BackendCoord], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (index, (x, y)) in points.iter().map(|(x, y)| (*x as f32, *y as f32)).enumerate() {
        if index == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if closed {
        path.close();
    }
    path.finish()
}

/// The fonts of a page, loaded by each reader, have the letters of Europe and the signs of physics: fonts/make.
#[cfg(target_arch = "wasm32")]
mod sans {
    pub(super) fn regular() -> &'static [u8] {
        include_bytes!("../fonts/DejaVuSans.ttf")
    }

    pub(super) fn bold() -> &'static [u8] {
        include_bytes!("../fonts/DejaVuSans-Bold.ttf")
    }
}

#[cfg(not(target_arch = "wasm32"))]
use dejavu::sans;

struct Faces {
    regular: Face,
    bold: Face,
}

static FACES: LazyLock<Faces> =
    LazyLock::new(|| Faces { regular: Face::new(sans::regular()), bold: Face::new(sans::bold()) });

/// The outlines of a text that begins at a point of its baseline; `None` for blanks.
pub(super) fn letters(text: &str, bold: bool, size: f32, at: (f32, f32)) -> Option<Path> {
    face(bold).outlines(text, size, at)
}

/// The width of a text.
pub(super) fn letters_width(text: &str, bold: bool, size: f32) -> f32 {
    face(bold).width(text, size)
}

/// The bytes of the font.
pub(super) fn bytes(bold: bool) -> &'static [u8] {
    if bold { sans::bold() } else { sans::regular() }
}

/// The highest and the lowest point of its letters, in ems above the baseline.
pub(super) fn metrics(bold: bool) -> [f32; 2] {
    let Face { font, em } = face(bold);
    [font.ascent_unscaled() / em, font.descent_unscaled() / em]
}

/// A letter of a text in the font.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glyph {
    /// The number of its outline in the font.
    pub(super) id: u16,
    pub(super) letter: char,
    /// Its width, in ems.
    pub(super) width: f32,
    /// The kerning between it and the next letter, in ems.
    pub(super) kern: f32,
}

/// The glyphs of a text.
pub(super) fn glyphs(text: &str, bold: bool) -> Vec<Glyph> {
    let face = face(bold);
    let (placed, end) = face.laid_out(text);
    let ends = placed.iter().skip(1).map(|(_, start)| *start).chain([end]);
    let glyph = |((letter, (id, start)), end): ((char, &(GlyphId, f32)), f32)| {
        let width = face.font.h_advance_unscaled(*id);
        Glyph { id: id.0, letter, width: width / face.em, kern: (end - start - width) / face.em }
    };
    text.chars().zip(&placed).zip(ends).map(glyph).collect()
}

/// The letters of a text that the font has no outline for, which are drawn as empty boxes.
pub(super) fn missing(text: &str, bold: bool) -> impl Iterator<Item = char> {
    // Glyph 0 stands for every unknown letter.
    text.chars().filter(move |letter| face(bold).font.glyph_id(*letter) == GlyphId(0))
}

/// A warning that the font lacks these letters, in a whole sentence; `None` for no letters.
pub(super) fn missing_letters(letters: &BTreeSet<char>) -> Option<String> {
    let named = |letter: &char| format!("{} (U+{:04X})", letter.escape_debug(), u32::from(*letter));
    let names = list(letters.iter().map(named));
    (!letters.is_empty()).then(|| format!("the font of labels and legends lacks {names}: boxes are drawn instead"))
}

fn face(bold: bool) -> &'static Face {
    if bold { &FACES.bold } else { &FACES.regular }
}

/// A font; lengths are in units of its em.
struct Face {
    font: FontRef<'static>,
    em: f32,
}

impl Face {
    fn new(bytes: &'static [u8]) -> Self {
        let font = FontRef::try_from_slice(bytes).expect("the font of the program is whole");
        let em = font.units_per_em().unwrap_or(1000.0);
        Self { font, em }
    }

    /// The height of a lower-case x at that size.
    fn ex(&self, size: f32) -> f32 {
        self.font
            .outline(self.font.glyph_id('x'))
            .map_or(0.5, |outline| outline.bounds.min.y.max(outline.bounds.max.y) / self.em)
            * size
    }

    /// The glyph of each letter and its offset from the first, in units of the font; then the end of the last.
    fn laid_out(&self, text: &str) -> (Vec<(GlyphId, f32)>, f32) {
        let (mut glyphs, mut end, mut last) = (Vec::new(), 0.0, None);
        for glyph in text.chars().map(|letter| self.font.glyph_id(letter)) {
            end += last.map_or(0.0, |last| self.font.kern_unscaled(last, glyph));
            glyphs.push((glyph, end));
            end += self.font.h_advance_unscaled(glyph);
            last = Some(glyph);
        }
        (glyphs, end)
    }

    fn width(&self, text: &str, size: f32) -> f32 {
        self.laid_out(text).1 / self.em * size
    }

    /// The outlines of a text that begins at a point of the baseline; `None` for blanks.
    fn outlines(&self, text: &str, size: f32, (left, baseline): (f32, f32)) -> Option<Path> {
        let mut path = PathBuilder::new();
        let scale = size / self.em;
        for (glyph, start) in self.laid_out(text).0 {
            let Some(outline) = self.font.outline(glyph) else { continue };
            // A font's y axis points up.
            let on_page = |p: Point| (left + (start + p.x) * scale, baseline - p.y * scale);
            let mut pen = None;
            for curve in outline.curves {
                let (OutlineCurve::Line(from, to)
                | OutlineCurve::Quad(from, _, to)
                | OutlineCurve::Cubic(from, .., to)) = curve;
                if pen != Some(from) {
                    let (x, y) = on_page(from);
                    path.move_to(x, y);
                }
                let (x, y) = on_page(to);
                match curve {
                    OutlineCurve::Line(..) => path.line_to(x, y),
                    OutlineCurve::Quad(_, a, _) => path.quad_to(on_page(a).0, on_page(a).1, x, y),
                    OutlineCurve::Cubic(_, a, b, _) => {
                        path.cubic_to(on_page(a).0, on_page(a).1, on_page(b).0, on_page(b).1, x, y);
                    }
                }
                pen = Some(to);
            }
        }
        path.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_letters_are_kerned() {
        for bold in [false, true] {
            let width = |text: &str| face(bold).width(text, 100.0);
            for pair in ["AV", "To", "LT"] {
                let apart: f32 = pair.chars().map(|letter| width(&letter.to_string())).sum();
                // By 2 % of an em or more, which no rounding does.
                assert!(width(pair) < apart - 2.0, "{pair}: {} of {apart}", width(pair));
            }
            assert_eq!(width("HH"), 2.0 * width("H"), "straight letters are not");
        }
    }
}
