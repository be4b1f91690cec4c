//! Parts that every plot has on its page: header, marks, lines, frames of cells.

use super::look::{FAINT, Look, Mark, QUIET};
use crate::record::Record;
use halfline_drawing::canvas::{Area, Drawn, bold, font, shortened, text};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// Columns of every plot.
pub(super) const WIDTH: i32 = 2000;

/// Distance from the edge of the page.
pub(super) const MARGIN: i32 = 40;

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

/// An empty frame for cells.
pub(super) fn frame(area: &Area<'_>, (x, y): (i32, i32), (width, height): (i32, i32)) -> Drawn {
    Ok(area.draw(&Rectangle::new([(x, y), (x + width, y + height)], FAINT.filled()))?)
}
