//! Drawings on a white page, as SVG and as pixels: the page, text on it.

use super::cells::Cells;
use super::raster;
use halfline::error::Source;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use tiny_skia::Pixmap;

pub use super::raster::SvgAndPixels;

/// Drawing fails only if memory is short, or by a bug.
pub type Drawn<T = ()> = Result<T, Source>;

/// The pixels use DejaVu Sans; a browser without it uses the next font.
pub(crate) const FONT: &str = "DejaVu Sans, Verdana, sans-serif";

/// The colour of text.
pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);

/// plotters' area of a whole picture; its units are pixels, and halves of a CSS pixel of the SVG.
pub type Area<'a> = DrawingArea<SvgAndPixels<'a>, Shift>;

/// A picture as an SVG file and as pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawing {
    /// The SVG file.
    pub svg: String,
    /// Columns and rows of pixels.
    pub size: [usize; 2],
    /// Red, green and blue of each pixel, 8-bit sRGB, row by row.
    pub levels: Vec<u8>,
}

/// The picture that `draw` draws on white; the cells that it returns are drawn on top.
///
/// # Errors
/// Errors of `draw` and of drawing; an error for a picture that is too large for the memory.
pub fn drawing([width, height]: [i32; 2], draw: impl FnOnce(&Area<'_>) -> Drawn<Vec<Cells>>) -> Drawn<Drawing> {
    let mut svg = String::new();
    let mut pixels = Pixmap::new(width as u32, height as u32).ok_or("the plot is too large")?;
    let area = SvgAndPixels::new(&mut svg, &mut pixels).into_drawing_area();
    area.fill(&WHITE)?;
    let over = draw(&area)?;
    area.present()?;
    drop(area);
    let end = svg.rfind("</svg>").ok_or("the SVG has no end")?;
    svg.insert_str(end, &over.iter().map(Cells::svg).collect::<String>());
    over.iter().for_each(|cells| raster::fill_cells(&mut pixels, cells));
    let (doubled, halved) = (size(width, height), size(width / 2, height / 2));
    if !svg.contains(&doubled) {
        return Err("the SVG has no size".into());
    }
    // Everything is opaque on white.
    let levels = pixels.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
    Ok(Drawing { svg: tidied(&svg.replacen(&doubled, &halved, 1)), size: [width as usize, height as usize], levels })
}

/// The SVG of plotters with each text on the line of its tags, colours in lower case, and no fraction that a search for a
/// number of the plot would find.
fn tidied(svg: &str) -> String {
    let svg = svg.replace(" dy=\"0.5ex\"", " dy=\".5ex\"");
    let mut tidied = String::with_capacity(svg.len());
    let mut lines = svg.lines();
    while let Some(line) = lines.next() {
        let mut parts = line.split("=\"#");
        tidied.extend(parts.next());
        for part in parts {
            let (color, rest) = part.split_at_checked(6).unwrap_or((part, ""));
            tidied.extend(["=\"#", &color.to_lowercase(), rest]);
        }
        if line.trim_start().starts_with("<text ") {
            tidied.extend(lines.next());
            tidied.extend(lines.next().map(str::trim_start));
        }
        tidied.push('\n');
    }
    tidied
}

fn size(width: i32, height: i32) -> String {
    format!("<svg width=\"{width}\" height=\"{height}\" ")
}

/// Text without control characters and noncharacters, which XML cannot hold.
#[must_use]
pub fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// Writes text; see [`plain`].
///
/// # Errors
/// Errors of drawing; see [`Drawn`].
pub fn text(area: &Area<'_>, text: &str, style: &TextStyle<'_>, at: (i32, i32)) -> Drawn {
    Ok(area.draw_text(&plain(text), style, at)?)
}

/// At most `letters` letters.
#[must_use]
pub fn shortened(words: &str, letters: usize) -> String {
    if words.chars().count() <= letters {
        return words.into();
    }
    words.chars().take(letters - 1).chain(['\u{2026}']).collect()
}

/// Text `size` units high, left-aligned on its middle.
#[must_use]
pub fn font(size: i32) -> TextStyle<'static> {
    styled(size, FontStyle::Normal)
}

/// The same in bold.
#[must_use]
pub fn bold(size: i32) -> TextStyle<'static> {
    styled(size, FontStyle::Bold)
}

fn styled(size: i32, style: FontStyle) -> TextStyle<'static> {
    // plotters writes a size divided by 1.24 into the SVG.
    TextStyle::from(FontDesc::new(FontFamily::Name(FONT), f64::from(size) * 1.24, style))
        .color(&INK)
        .pos(Pos::new(HPos::Left, VPos::Center))
}

/// `style` aligned by its middle.
#[must_use]
pub fn centered<'a>(style: &TextStyle<'a>) -> TextStyle<'a> {
    style.pos(Pos::new(HPos::Center, VPos::Center))
}
