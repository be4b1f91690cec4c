//! The plane of speed against error, and its Pareto front.

use super::axis::{Axis, Chart, Unit, chart};
use super::canvas::{Area, Drawn, MARGIN, WIDTH, header, header_height, header_row, line, mark, svg, text};
use super::look::{INK, Look, Mark, QUIET, font, lane, look, width};
use crate::measure::record::Record;
use crate::measure::total::{Total, totals};
use plotters::prelude::*;

/// Which error is held against the time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Against {
    /// Share of misclassified pixels.
    Wrong,
    /// Largest relative error of a distance.
    Distance,
}

/// A method in a place, on the plane.
struct Point<'a> {
    total: Total<'a>,
    ns: [f64; 3],
    error: Option<f64>,
    at: (i32, i32),
}

/// The methods that were timed, one mark a place.
pub(super) fn draw(record: &Record, against: Against) -> Drawn<String> {
    let mut points: Vec<Point<'_>> = totals(record)
        .into_iter()
        .filter_map(|total| {
            let error = match against {
                Against::Wrong => Some(total.wrong_share()),
                Against::Distance => total.relative,
            };
            Some(Point { ns: total.ns?, error, total, at: (0, 0) })
        })
        .collect();
    let mut places: Vec<usize> = points.iter().map(|point| point.total.place).collect();
    places.dedup();
    let mut methods = Vec::new();
    for point in points.iter().filter(|point| point.error == Some(0.0)) {
        if !methods.contains(&point.total.method) {
            methods.push(point.total.method);
        }
    }
    let times = points.iter().flat_map(|point| point.ns.map(Some));
    let x = Axis::new("time per ray (ns, whole frames; median, whisker from least to greatest)", Unit::Plain, times);
    let errors = points.iter().map(|point| point.error);
    let pixels = points.iter().map(|point| point.total.pixels).max().unwrap_or(0);
    let (title, y) = match against {
        Against::Wrong => (
            "Speed against wrong pixels",
            Axis::new(format!("misclassified pixels (share of {pixels})"), Unit::Percent, errors),
        ),
        Against::Distance => (
            "Speed against error of the hit distance t",
            Axis::new("largest relative error |t \u{2212} t*| / t*", Unit::Plain, errors),
        ),
    };
    let top = header_height(&places);
    svg(top + 1120, |area| {
        header(area, record, title, &places, true)?;
        let chart = chart(area, (x, y), top, 60)?;
        for point in &mut points {
            point.at = chart.at(point.ns[1], point.error, lane(point.total.method, &methods));
        }
        let mut taken = Vec::new();
        for (row, place) in places.iter().enumerate() {
            let (x, y) = (WIDTH - MARGIN - 190, header_row(row));
            line(area, &front(&record.places[*place].backend), &[(x - 70, y), (x - 12, y)], 3)?;
            text(area, "Pareto front", &font(25).color(&QUIET), (x, y))?;
            let here: Vec<&Point<'_>> = points.iter().filter(|point| point.total.place == *place).collect();
            let steps = steps(&chart, &here);
            line(area, &front(&record.places[*place].backend), &steps, 3)?;
            taken.extend(steps.windows(2).map(|ends| around(ends[0], ends[1], 3)));
        }
        for point in &points {
            let [least, _, greatest] = point.ns.map(|ns| chart.at(ns, Some(1.0), 0.5).0);
            let look = Look { dash: None, ..look(point.total.method) };
            line(area, &look, &[(least, point.at.1), (greatest, point.at.1)], 3)?;
            taken.push(around((least, point.at.1), (greatest, point.at.1), 8));
            taken.push(around(point.at, point.at, 18));
            for end in [least, greatest] {
                line(area, &look, &[(end, point.at.1 - 8), (end, point.at.1 + 8)], 3)?;
            }
            mark(area, &look, point.at, 13, record.places[point.total.place].backend != "cpu")?;
        }
        labels(area, &chart, &points, taken)?;
        Ok(String::new())
    })
}

/// Those of some points (time and error) than which none faster is as right, fastest first.
pub(super) fn pareto(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*a].0.total_cmp(&points[*b].0).then(points[*a].1.total_cmp(&points[*b].1)));
    let mut best = f64::INFINITY;
    order.retain(|index| {
        let better = points[*index].1 < best;
        best = best.min(points[*index].1);
        better
    });
    order
}

/// The front as steps from the upper to the right edge of the chart.
fn steps(chart: &Chart, points: &[&Point<'_>]) -> Vec<(i32, i32)> {
    let plane: Vec<(f64, f64)> = points.iter().map(|p| (p.ns[1], p.error.unwrap_or(f64::MAX))).collect();
    let mut steps: Vec<(i32, i32)> = Vec::new();
    for index in pareto(&plane) {
        let at = points[index].at;
        steps.push((at.0, steps.last().map_or(chart.top, |last| last.1)));
        steps.push(at);
    }
    steps.extend(steps.last().map(|last| (chart.right, last.1)));
    steps
}

/// How the front of a place is drawn.
fn front(backend: &str) -> Look {
    let dash = (backend == "cpu").then_some((14, 10));
    Look { color: RGBColor(0xaa, 0xaa, 0xaa), mark: Mark::Circle, dash }
}

/// A rectangle that a label must not cover.
type Box = [i32; 4];

fn around(a: (i32, i32), b: (i32, i32), spare: i32) -> Box {
    [a.0.min(b.0) - spare, a.1.min(b.1) - spare, a.0.max(b.0) + spare, a.1.max(b.1) + spare]
}

/// Each mark's name beside it, where no other mark or name is.
fn labels(area: &Area<'_>, chart: &Chart, points: &[Point<'_>], mut taken: Vec<Box>) -> Drawn {
    const SIZE: i32 = 26;
    for point in points {
        let total = &point.total;
        let scenes = format!("{} ({} of {} scenes)", total.method, total.scenes, total.of_scenes);
        let words = if total.is_whole() { total.method } else { &scenes };
        let (x, y) = point.at;
        let (wide, high) = (width(words, SIZE), SIZE + 4);
        let candidates = [26, 60, 100, 150].into_iter().flat_map(|away| {
            let (up, down) = (y - away, y + away);
            [
                (x + away, y),
                (x - away - wide, y),
                (x + away / 2, up),
                (x + away / 2, down),
                (x - wide / 2, up),
                (x - wide / 2, down),
                (x - away / 2 - wide, up),
                (x - away / 2 - wide, down),
            ]
        });
        let boxed = |(x, y): (i32, i32)| [x, y - high / 2, x + wide, y + high / 2];
        let free = |b: &Box| {
            let inside = b[0] > chart.left && b[2] < chart.right && b[1] > chart.top && b[3] < chart.bottom;
            inside && taken.iter().all(|t| b[2] < t[0] || t[2] < b[0] || b[3] < t[1] || t[3] < b[1])
        };
        let at = candidates.clone().find(|at| free(&boxed(*at))).unwrap_or((x + 26, y));
        let b = boxed(at);
        if (at.1 - y).abs() > 40 {
            let foot = (x.clamp(b[0], b[2]), if at.1 < y { b[3] } else { b[1] });
            area.draw(&PathElement::new(vec![point.at, foot], QUIET.stroke_width(1)))?;
        }
        text(area, words, &font(SIZE).color(&INK), at)?;
        taken.push(b);
    }
    Ok(())
}
