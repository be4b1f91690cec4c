//! Errors against distance over radius: a line per method along a ladder, only marks for other sets of scenes.

use super::axis::{Axis, Chart, Unit, chart};
use super::canvas::{WIDTH, header, header_height, line, mark};
use super::look::{Look, QUIET, lane, look, width};
use crate::record::{Record, Run};
use crate::total::{main_place, methods};
use crate::verdict::is_ladder;
use halfline_drawing::canvas::{Area, Drawing, Drawn, INK, drawing, font, text};
use plotters::element::DottedPathElement;
use plotters::prelude::*;

/// The error that is plotted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Against {
    /// Share of misclassified pixels.
    Wrong,
    /// Largest relative error of a distance.
    Distance,
    /// The error of outlines.
    Outline,
}

impl Against {
    fn error_of(self, run: &Run) -> Option<f64> {
        match self {
            Self::Wrong => Some(run.errors.wrong_share()),
            Self::Distance => run.errors.relative.max,
            Self::Outline => run.errors.outline,
        }
    }

    fn predicted(self, run: &Run) -> Option<f64> {
        match self {
            Self::Wrong => None,
            Self::Distance => run.predicted.distance,
            Self::Outline => run.predicted.outline,
        }
    }

    fn titles(self) -> (&'static str, &'static str, Unit) {
        match self {
            Self::Wrong => {
                ("Wrong pixels by distance over radius", "misclassified pixels (share of all)", Unit::Percent)
            }
            Self::Distance => (
                "Error of the hit distance t by distance over radius",
                "largest relative error |t \u{2212} t*| / t*",
                Unit::Plain,
            ),
            Self::Outline => ("Error of outlines by distance over radius", "outlines off by (radii)", Unit::Plain),
        }
    }
}

/// Half an ulp of f32 relative to the number: the smallest error bound of an f32 distance.
const HALF_ULP: f64 = 1.0 / (1u64 << 24) as f64;

/// Space for the methods' names beside the chart.
const SIDE: i32 = 300;

/// The errors of each method in the main place; see [`main_place`].
pub(super) fn draw(record: &Record, against: Against) -> Drawn<Drawing> {
    let place = main_place(record).ok_or("nothing ran")?;
    let far = |run: &&Run| record.scenes.get(run.scene).is_some_and(|scene| scene.farthest.is_some());
    let runs: Vec<&Run> =
        record.runs.iter().filter(|run| run.place == place && run.refused.is_none()).filter(far).collect();
    let distance = |run: &Run| record.scenes[run.scene].farthest.unwrap_or(1.0);
    let names = methods(runs.iter().copied());
    let (title, y_title, unit) = against.titles();
    let x = Axis::new(
        "distance from the eye to the farthest centre / radius",
        Unit::Plain,
        runs.iter().map(|run| Some(distance(run))),
    );
    let errors: Vec<Option<f64>> = runs.iter().map(|run| against.error_of(run)).collect();
    // Predictions may extend the axis, but not so far that the measurements become invisible.
    let most = errors.iter().flatten().fold(1.0f64, |a, b| a.max(*b));
    let predicted = runs.iter().filter_map(|run| against.predicted(run)).filter(|p| *p > 0.0).map(|p| p.min(most));
    let values: Vec<Option<f64>> = errors.into_iter().chain(predicted.map(Some)).collect();
    let y = Axis::new(y_title, unit, values.into_iter());
    let top = header_height(&[place]);
    let zeros = methods(runs.iter().copied().filter(|run| against.error_of(run) == Some(0.0)));
    let connected = is_ladder(record);
    drawing([WIDTH, top + 1120], |area| {
        header(area, record, title, &[place], false)?;
        let chart = chart(area, (x, y), top, SIDE)?;
        let mut ends = Vec::new();
        let mut busy = Vec::new();
        for name in &names {
            let these: Vec<&Run> = runs.iter().copied().filter(|run| run.method == *name).collect();
            let (look, lane) = (look(name), lane(name, &zeros));
            let at = |run: &&Run| chart.at(distance(run), against.error_of(run), lane);
            let points: Vec<(i32, i32)> = these.iter().map(at).collect();
            busy.extend(&points);
            if connected {
                busy.extend(along(&points));
                bounds(area, &chart, &look, &these, &|run| Some((distance(run), against.predicted(run)?)))?;
                line(area, &look, &points, 5)?;
            }
            for point in &points {
                mark(area, &look, *point, if connected { 10 } else { 8 }, true)?;
            }
            ends.push((*name, points.last().copied().unwrap_or_default()));
        }
        if against == Against::Distance {
            references(area, &chart, record.tolerance, &busy)?;
        }
        side_labels(area, &chart, ends, connected)?;
        let dotted = runs.iter().any(|run| against.predicted(run).is_some());
        if dotted && connected {
            text(area, "dotted: predicted", &font(22).color(&QUIET), (chart.right + 24, chart.bottom - 14))?;
        }
        Ok(Vec::new())
    })
}

/// The limits of f32 and the tolerance of certified answers; labelled where no `busy` point is near.
fn references(area: &Area<'_>, chart: &Chart, tolerance: f64, busy: &[(i32, i32)]) -> Drawn {
    for (value, words) in [(HALF_ULP, "half an ulp of f32"), (tolerance, "tolerance of certified")] {
        let (_, y) = chart.at(1.0, Some(value), 0.5);
        let inside = (chart.top + 40..chart.bottom).contains(&y) && chart.zero_edge().is_none_or(|edge| y < edge);
        if value > 0.0 && inside {
            area.draw(&PathElement::new(vec![(chart.left, y), (chart.right, y)], QUIET.stroke_width(2)))?;
            let wide = width(words, 22);
            let free = |(x, y): &(i32, i32)| {
                let covers =
                    |point: &(i32, i32)| (x - 14..x + wide + 14).contains(&point.0) && (y - point.1).abs() < 26;
                !busy.iter().any(covers)
            };
            let last = chart.right - 16 - wide;
            let places = (0..=12).map(|i| chart.left + 16 + (last - chart.left - 16) * i / 12);
            let at = places.flat_map(|x| [(x, y + 20), (x, y - 18)]).find(free).unwrap_or((chart.left + 16, y + 20));
            text(area, words, &font(22).color(&QUIET), at)?;
        }
    }
    Ok(())
}

/// Points along a line, dense enough that no label between two of them crosses it.
fn along(line: &[(i32, i32)]) -> impl Iterator<Item = (i32, i32)> {
    line.windows(2).flat_map(|ends| {
        let [(x0, y0), (x1, y1)] = [ends[0], ends[1]];
        (0..=32).map(move |i| (x0 + (x1 - x0) * i / 32, y0 + (y1 - y0) * i / 32))
    })
}

/// The predicted bound as dots in the method's colour; unbounded predictions leave a gap.
fn bounds(
    area: &Area<'_>,
    chart: &Chart,
    look: &Look,
    runs: &[&Run],
    predicted: &dyn Fn(&Run) -> Option<(f64, f64)>,
) -> Drawn {
    let color = look.color;
    for pair in runs.windows(2) {
        if let (Some((x0, y0)), Some((x1, y1))) = (predicted(pair[0]), predicted(pair[1])) {
            let Some(ends) = below(chart.top, chart.at(x0, Some(y0), 0.5), chart.at(x1, Some(y1), 0.5)) else {
                continue;
            };
            let dots = DottedPathElement::new(ends, 0, 14, move |at| Circle::new(at, 3, color.filled()));
            area.draw(&dots)?;
        }
    }
    Ok(())
}

/// The part of a line below a row; bounds leave the chart upwards.
fn below(top: i32, a: (i32, i32), b: (i32, i32)) -> Option<[(i32, i32); 2]> {
    let cut = |from: (i32, i32), to: (i32, i32)| {
        let share = f64::from(top - from.1) / f64::from(to.1 - from.1);
        (from.0 + (share * f64::from(to.0 - from.0)).round() as i32, top)
    };
    match (a.1 >= top, b.1 >= top) {
        (true, true) => Some([a, b]),
        (true, false) => Some([a, cut(a, b)]),
        (false, true) => Some([cut(b, a), b]),
        (false, false) => None,
    }
}

/// Names beside the chart, each as close to its line's end as the others allow.
fn side_labels(area: &Area<'_>, chart: &Chart, mut ends: Vec<(&str, (i32, i32))>, connected: bool) -> Drawn {
    const GAP: i32 = 36;
    if connected {
        ends.sort_by_key(|(_, at)| at.1);
    }
    let mut rows: Vec<i32> = Vec::new();
    for (index, (_, at)) in ends.iter().enumerate() {
        let wished = if connected { at.1 } else { chart.top + 20 + GAP * index as i32 };
        rows.push(rows.last().map_or(wished, |last| wished.max(last + GAP)));
    }
    // Names below the chart are moved up again.
    let mut limit = chart.bottom - 50;
    for row in rows.iter_mut().rev() {
        *row = (*row).min(limit);
        limit = *row - GAP;
    }
    for ((name, at), row) in ends.iter().zip(rows) {
        let (look, x) = (look(name), chart.right + 40);
        if connected {
            let leader = PathElement::new(vec![*at, (chart.right + 8, row), (x - 4, row)], look.color.stroke_width(2));
            area.draw(&leader)?;
        }
        mark(area, &look, (x + 10, row), 10, true)?;
        text(area, name, &font(26).color(&INK), (x + 32, row))?;
    }
    Ok(())
}
