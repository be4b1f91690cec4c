//! The sheet that a plot is drawn on: header, marks, lines, and cells of pixels.

use super::look::{FAINT, Look, Mark, QUIET, bold, font};
use crate::error::Source;
use crate::measure::record::Record;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write;

/// plotters' area of a whole plot; its units are halves of a CSS pixel, since it rounds to whole ones.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Drawing fails only where the text grows out of memory, or by a mistake.
pub(super) type Drawn<T = ()> = Result<T, Source>;

/// Columns of every plot.
pub(super) const WIDTH: i32 = 2000;

/// From the edge of the sheet to anything on it.
pub(super) const MARGIN: i32 = 40;

/// The SVG of what `draw` draws on white; the text it returns lies on top, as SVG.
pub(super) fn svg(height: i32, draw: impl FnOnce(&Area<'_>) -> Drawn<String>) -> Drawn<String> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (WIDTH as u32, height as u32)).into_drawing_area();
    area.fill(&WHITE)?;
    let over = draw(&area)?;
    area.present()?;
    drop(area);
    let end = svg.rfind("</svg>").ok_or("the SVG has no end")?;
    svg.insert_str(end, &over);
    let (doubled, size) = (size(WIDTH, height), size(WIDTH / 2, height / 2));
    if !svg.contains(&doubled) {
        return Err("the SVG has no size".into());
    }
    Ok(svg.replacen(&doubled, &size, 1))
}

fn size(width: i32, height: i32) -> String {
    format!("<svg width=\"{width}\" height=\"{height}\" ")
}

/// Text that XML can hold: it knows no control characters and no noncharacters.
pub(super) fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// Writes text; see [`plain`].
pub(super) fn text(area: &Area<'_>, text: &str, style: &TextStyle<'_>, at: (i32, i32)) -> Drawn {
    Ok(area.draw_text(&plain(text), style, at)?)
}

/// How high [`header`] is with so many places.
pub(super) fn header_height(places: &[usize]) -> i32 {
    MARGIN + 60 + 38 * places.len() as i32
}

/// The row of a place in the [`header`].
pub(super) fn header_row(place: usize) -> i32 {
    MARGIN + 66 + 38 * place as i32
}

/// What is plotted, and what ran where; `marks` are drawn before the places to say which is which.
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

/// At most so many letters.
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

/// Corners by angle and radius, chosen so that the marks look equally large.
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

/// A line through points, dashed as the look says.
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

/// Square cells of colour as SVG: the runs of a row in one path a colour, since a rectangle a cell would be megabytes.
pub(super) fn cells(
    at: (i32, i32),
    side: f64,
    [columns, rows]: [usize; 2],
    color: impl Fn(usize) -> [u8; 3],
) -> String {
    let mut paths: BTreeMap<[u8; 3], (usize, String)> = BTreeMap::new();
    for row in 0..rows {
        let mut first = 0;
        while first < columns {
            let this = color(row * columns + first);
            let run = (first..columns).take_while(|column| color(row * columns + column) == this).count();
            let (covered, path) = paths.entry(this).or_default();
            *covered += run;
            // Writing to a String cannot fail.
            let _ = write!(path, "M{first} {row}h{run}v1h-{run}z");
            first += run;
        }
    }
    let mut svg =
        format!("<g transform=\"translate({} {}) scale({side:.5})\" shape-rendering=\"crispEdges\">\n", at.0, at.1);
    // The commonest colour lies under all the others, so that its path need not be written.
    let ground = paths.iter().max_by_key(|(_, (covered, _))| *covered).map(|(color, _)| *color);
    let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    if let Some(ground) = ground {
        let _ = writeln!(svg, "<path fill=\"{}\" d=\"M0 0h{columns}v{rows}h-{columns}z\"/>", hex(ground));
    }
    for (color, (_, path)) in paths.iter().filter(|(color, _)| Some(**color) != ground) {
        let _ = writeln!(svg, "<path fill=\"{}\" d=\"{path}\"/>", hex(*color));
    }
    svg + "</g>\n"
}
