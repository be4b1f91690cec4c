//! The plane of speed and error, and its Pareto front.

use super::axis::{Axis, Chart, Unit, chart};
use super::canvas::{MARGIN, WIDTH, header, header_height, header_row, line, mark};
use super::look::{Look, Mark, QUIET, lane, look, width};
use crate::record::Record;
use crate::total::{Total, totals};
use halfline_drawing::canvas::{Area, Drawing, Drawn, INK, drawing, font, text};
use plotters::prelude::*;

/// The error that is plotted against the time.
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
    /// Columns of the minimum and the maximum time.
    whisker: [i32; 2],
}

/// The methods that were timed, one mark per place.
pub(super) fn draw(record: &Record, against: Against) -> Drawn<Drawing> {
    let mut points: Vec<Point<'_>> = totals(record)
        .into_iter()
        .filter_map(|total| {
            let error = match against {
                Against::Wrong => Some(total.wrong_share()),
                Against::Distance => total.relative,
            };
            Some(Point { ns: total.ns?, error, total, at: (0, 0), whisker: [0; 2] })
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
            Axis::new("largest relative error |t \u{2212} t*| / t*", Unit::Plain, errors).roomy(),
        ),
    };
    let top = header_height(&places);
    drawing([WIDTH, top + 1120], |area| {
        header(area, record, title, &places, true)?;
        let chart = chart(area, (x, y), top, 60)?;
        for point in &mut points {
            point.at = chart.at(point.ns[1], point.error, lane(point.total.method, &methods));
            point.whisker = [point.ns[0], point.ns[2]].map(|ns| chart.at(ns, Some(1.0), 0.5).0);
        }
        let mut lines = Vec::new();
        for (row, place) in places.iter().enumerate() {
            let (x, y) = (WIDTH - MARGIN - 190, header_row(row));
            line(area, &front(&record.places[*place].backend), &[(x - 70, y), (x - 12, y)], 3)?;
            text(area, "Pareto front", &font(25).color(&QUIET), (x, y))?;
            let here: Vec<&Point<'_>> = points.iter().filter(|point| point.total.place == *place).collect();
            let steps = steps(&chart, &here);
            line(area, &front(&record.places[*place].backend), &steps, 3)?;
            lines.extend(steps.windows(2).map(|ends| around(ends[0], ends[1], 3)));
        }
        for point in &points {
            let [least, greatest] = point.whisker;
            let look = Look { dash: None, ..look(point.total.method) };
            line(area, &look, &[(least, point.at.1), (greatest, point.at.1)], 3)?;
            lines.push(around((least, point.at.1), (greatest, point.at.1), 8));
            for end in [least, greatest] {
                line(area, &look, &[(end, point.at.1 - 8), (end, point.at.1 + 8)], 3)?;
            }
            mark(area, &look, point.at, 13, is_filled(record, &point.total))?;
        }
        labels(area, record, &chart, &points, &lines)?;
        Ok(Vec::new())
    })
}

/// The Pareto front of points (time and error): those for which no faster one is as accurate, fastest first.
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

/// The look of the front of a place.
fn front(backend: &str) -> Look {
    let dash = (backend == "cpu").then_some((14, 10));
    Look { color: RGBColor(0xaa, 0xaa, 0xaa), mark: Mark::Circle, dash }
}

/// A rectangle that names must not overlap.
type Box = [i32; 4];

fn around(a: (i32, i32), b: (i32, i32), spare: i32) -> Box {
    [a.0.min(b.0) - spare, a.1.min(b.1) - spare, a.0.max(b.0) + spare, a.1.max(b.1) + spare]
}

fn intersect(a: &Box, b: &Box) -> bool {
    a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]
}

const SIZE: i32 = 26;

/// Each mark's name beside it, or at the end of a line in the method's colour where there is space. Leaders may cross
/// `lines`, names may not.
fn labels(area: &Area<'_>, record: &Record, chart: &Chart, points: &[Point<'_>], lines: &[Box]) -> Drawn {
    let mut taken: Vec<Box> = points.iter().map(|point| around(point.at, point.at, 17)).collect();
    for (index, point) in points.iter().enumerate() {
        let total = &point.total;
        let scenes = format!("{} ({} of {} scenes)", total.method, total.scenes, total.of_scenes);
        let words = if total.is_whole() { total.method } else { &scenes };
        let (x, y) = point.at;
        let wide = width(words, SIZE);
        let name = |left: i32, y: i32, wide: i32| [left, y - SIZE / 2 - 2, left + wide, y + SIZE / 2 + 2];
        let free = |b: &Box| {
            let inside = b[0] > chart.left && b[2] < chart.right && b[1] > chart.top && b[3] < chart.bottom;
            inside && !taken.iter().chain(lines).any(|other| intersect(b, other))
        };
        let [left, right] = [point.whisker[0].min(x - 16) - 12, point.whisker[1].max(x + 16) + 12];
        if let Some(b) = [name(right, y, wide), name(left - wide, y, wide)].into_iter().find(|b| free(b)) {
            text(area, words, &font(SIZE).color(&INK), (b[0], y))?;
            taken.push(b);
            continue;
        }
        let apart = |(across, down): (i32, i32)| {
            let left = if across < 0 { x + across - wide } else { x + across };
            name(left, y + down, wide)
        };
        // A leader may start under the marks that crowd its own, but must cross no others.
        let clear = |b: &Box| {
            let (foot, crowd) = (foot(point.at, b), around(point.at, point.at, 36));
            let mut along = (1..=16).map(|i| (x + (foot.0 - x) * i / 16, y + (foot.1 - y) * i / 16));
            let others = || taken.iter().enumerate().filter(|(other, _)| *other != index);
            along.all(|at| {
                intersect(&around(at, at, 0), &crowd)
                    || !others().any(|(_, other)| intersect(&around(at, at, 0), other))
            })
        };
        let downs = [50, 84, 120, 160, 210, 270].into_iter().flat_map(|down| [-down, down]);
        let mut candidates: Vec<(i32, i32)> = downs
            .flat_map(|down| {
                [30, 80, 140, 200, 260].into_iter().flat_map(move |across| [(across, down), (-across, down)])
            })
            .collect();
        // For equal distances, up before down and right before left.
        candidates.sort_by_key(|(across, down)| (across.abs() + 2 * down.abs(), *down > 0, *across < 0));
        let mut boxes = candidates.into_iter().map(apart).filter(free).peekable();
        let first = boxes.peek().copied();
        let b = boxes.find(clear).or(first).unwrap_or_else(|| apart((30, -52)));
        let (look, near) = (look(total.method), foot(point.at, &b));
        let far = (b[0] + b[2] - near.0, near.1);
        // A later name must not cover the leader outside of the crowd.
        let along = (6..16).map(|i| (x + (near.0 - x) * i / 16, y + (near.1 - y) * i / 16));
        taken.extend(along.map(|at| around(at, at, 2)));
        area.draw(&PathElement::new(vec![point.at, near, far], look.color.stroke_width(3)))?;
        mark(area, &look, point.at, 13, is_filled(record, total))?;
        text(area, words, &font(SIZE).color(&INK), (b[0], (b[1] + b[3]) / 2))?;
        taken.push(b);
    }
    Ok(())
}

/// The end of a leader from `at` to a name: the nearer end of the line under it.
fn foot(at: (i32, i32), name: &Box) -> (i32, i32) {
    (if (at.0 - name[0]).abs() < (at.0 - name[2]).abs() { name[0] } else { name[2] }, name[3])
}

/// Marks of adapters are filled, marks of the reference path hollow.
fn is_filled(record: &Record, total: &Total<'_>) -> bool {
    record.places[total.place].backend != "cpu"
}
