//! The page that a plot is drawn on: header, marks, lines, and cells of colour.

use super::cells::Cells;
use super::look::{Drawn, FAINT, Look, Mark, QUIET, bold, font};
use super::raster::{self, SvgAndPixels};
use crate::record::Record;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use tiny_skia::Pixmap;

/// plotters' area of a whole plot; its units are pixels of the PNG and halves of a CSS pixel of the SVG.
pub(super) type Area<'a> = DrawingArea<SvgAndPixels<'a>, Shift>;

/// A plot as an SVG and as a PNG file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Drawing {
    pub(super) svg: String,
    pub(super) png: Vec<u8>,
}

/// Columns of every plot.
pub(super) const WIDTH: i32 = 2000;

/// Distance from the edge of the page.
pub(super) const MARGIN: i32 = 40;

/// The picture that `draw` draws on white; the cells that it returns are drawn on top.
pub(super) fn drawing([width, height]: [i32; 2], draw: impl FnOnce(&Area<'_>) -> Drawn<Vec<Cells>>) -> Drawn<Drawing> {
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
    let (doubled, size) = (size(width, height), size(width / 2, height / 2));
    if !svg.contains(&doubled) {
        return Err("the SVG has no size".into());
    }
    Ok(Drawing { svg: tidied(&svg.replacen(&doubled, &size, 1)), png: raster::png(&pixels)? })
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
pub(super) fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// Writes text; see [`plain`].
pub(super) fn text(area: &Area<'_>, text: &str, style: &TextStyle<'_>, at: (i32, i32)) -> Drawn {
    Ok(area.draw_text(&plain(text), style, at)?)
}

/// The height of [`header`] for these places.
pub(super) fn header_height(places: &[usize]) -> i32 {
    MARGIN + 60 + 38 * places.len() as i32
}

/// The row of a place in the [`header`].
pub(super) fn header_row(place: usize) -> i32 {
    MARGIN + 66 + 38 * place as i32
}

/// The title and the places; `marks` are drawn before the places to identify them.
pub(super) fn header(area: &Area<'_>, record: &Record, title: &str, places: &[usize], marks: bool) -> Drawn {
    text(area, &format!("{title}: {}", record.subject), &bold(38), (MARGIN, MARGIN + 14))?;
    for (line, place) in places.iter().filter_map(|place| record.places.get(*place)).enumerate() {
        let y = header_row(line);
        let (name, adapter) = (place.backend.to_uppercase(), &place.adapter);
        let same = *adapter == place.backend;
        let words =
            if same { format!("{name}: {}", place.driver) } else { format!("{name}: {adapter}, {}", place.driver) };
        let mut x = MARGIN;
        if marks {
            let look = Look { color: QUIET, mark: Mark::Circle, dash: None };
            mark(area, &look, (x + 10, y), 9, place.backend != "cpu")?;
            x += 32;
        }
        text(area, &shortened(&words, 100), &font(25).color(&QUIET), (x, y))?;
    }
    Ok(())
}

/// At most `letters` letters.
pub(super) fn shortened(words: &str, letters: usize) -> String {
    if words.chars().count() <= letters {
        return words.into();
    }
    words.chars().take(letters - 1).chain(['\u{2026}']).collect()
}

/// The mark of a method, filled or hollow.
pub(super) fn mark(area: &Area<'_>, look: &Look, (x, y): (i32, i32), size: i32, filled: bool) -> Drawn {
    let outline = look.color.stroke_width(4);
    if look.mark == Mark::Circle {
        if filled {
            area.draw(&Circle::new((x, y), size, look.color.filled()))?;
        } else {
            area.draw(&Circle::new((x, y), size, WHITE.filled()))?;
            area.draw(&Circle::new((x, y), size, outline))?;
        }
        return Ok(());
    }
    let mut corners: Vec<(i32, i32)> = corners(look.mark)
        .into_iter()
        .map(|(angle, radius)| {
            let (sin, cos) = angle.to_radians().sin_cos();
            let radius = radius * f64::from(size);
            (x + (radius * cos).round() as i32, y - (radius * sin).round() as i32)
        })
        .collect();
    area.draw(&Polygon::new(corners.clone(), if filled { look.color.filled() } else { WHITE.filled() }))?;
    if !filled {
        corners.push(corners[0]);
        corners.push(corners[1]);
        area.draw(&PathElement::new(corners, outline))?;
    }
    Ok(())
}

/// Corners by angle and radius, chosen so that all marks appear equally large.
fn corners(mark: Mark) -> Vec<(f64, f64)> {
    let regular = |n: u32, first: f64, radius: f64| -> Vec<(f64, f64)> {
        (0..n).map(|i| (first + 360.0 * f64::from(i) / f64::from(n), radius)).collect()
    };
    match mark {
        Mark::Circle => regular(32, 0.0, 1.0),
        Mark::Square => regular(4, 45.0, 1.25),
        Mark::Diamond => regular(4, 0.0, 1.35),
        Mark::Up => regular(3, 90.0, 1.45),
        Mark::Down => regular(3, 270.0, 1.45),
        Mark::Hexagon => regular(6, 0.0, 1.15),
        Mark::Star => (0..10).map(|i| (90.0 + 36.0 * f64::from(i), if i % 2 == 0 { 1.6 } else { 0.75 })).collect(),
        Mark::Cross => {
            let arm = |turn: f64| [(turn - 15.0, 1.45), (turn + 15.0, 1.45), (turn + 45.0, 0.55)];
            [45.0, 135.0, 225.0, 315.0].into_iter().flat_map(arm).collect()
        }
    }
}

/// A line through points, dashed as in the look.
pub(super) fn line(area: &Area<'_>, look: &Look, points: &[(i32, i32)], width: u32) -> Drawn {
    let style = look.color.stroke_width(width);
    match look.dash {
        _ if points.len() < 2 => {}
        None => area.draw(&PathElement::new(points.to_vec(), style))?,
        Some((on, off)) => area.draw(&DashedPathElement::new(points.iter().copied(), on, off, style))?,
    }
    Ok(())
}

/// An empty frame for [`cells`].
pub(super) fn frame(area: &Area<'_>, (x, y): (i32, i32), (width, height): (i32, i32)) -> Drawn {
    Ok(area.draw(&Rectangle::new([(x, y), (x + width, y + height)], FAINT.filled()))?)
}
