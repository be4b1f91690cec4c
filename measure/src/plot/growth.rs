//! The growth of times, or of another quantity: panels of curves on logarithmic axes, with the exponent at the end of each
//! curve.

use super::Plot;
use super::axis::{Axis, Chart, Unit, chart};
use super::canvas::{WIDTH, header, header_height, line, mark};
use super::look::{Look, Mark};
use crate::record::{PlaceRecord, Record};
use halfline::error::Result;
use halfline_drawing::canvas::{Area, Drawing, Drawn, bold, drawing, font, text};
use plotters::prelude::*;

/// A measurement of growing times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Growth {
    /// The title: the first part of the heading.
    pub title: String,
    /// The subject: the part of the heading behind the colon.
    pub subject: String,
    /// The places of the curves; see [`Curve::place`].
    pub places: Vec<PlaceRecord>,
    /// The panels, from left to right.
    pub panels: Vec<Panel>,
}

/// Curves over one quantity.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// The quantity on the horizontal axis, with its unit.
    pub over: String,
    /// The quantity on the vertical axis, with its unit. Panels of the same one have the same axis.
    pub measured: String,
    /// The curves; curves of the same name have the same colour.
    pub curves: Vec<Curve>,
}

/// The measurements of one kind of scene in one place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// The kind of scene.
    pub name: String,
    /// Index into the places.
    pub place: usize,
    /// Both quantities, in increasing order.
    pub points: Vec<[f64; 2]>,
}

/// Decades of the quantity over which the exponent is fitted.
const DECADES: f64 = 2.0;

impl Curve {
    /// The exponent p and the factor c of c n^p, by least squares of log time on log n over the last two decades;
    /// `None` for fewer than three points.
    #[must_use]
    pub fn fit(&self) -> Option<[f64; 2]> {
        let logs: Vec<[f64; 2]> = self.points.iter().map(|point| point.map(f64::log10)).collect();
        let first = logs.last()?[0] - DECADES - 1e-6;
        let end: Vec<[f64; 2]> = logs.into_iter().filter(|[n, _]| *n >= first).collect();
        let mean = |k: usize| end.iter().map(|point| point[k]).sum::<f64>() / end.len() as f64;
        let middle = [mean(0), mean(1)];
        let sum = |k: usize| end.iter().map(|point| (point[0] - middle[0]) * (point[k] - middle[k])).sum::<f64>();
        let exponent = sum(1) / sum(0);
        (end.len() >= 3 && exponent.is_finite()).then(|| [exponent, 10f64.powf(middle[1] - exponent * middle[0])])
    }
}

impl Growth {
    /// Every panel in one picture.
    ///
    /// # Errors
    /// [`Error::Io`](halfline::Error::Io) at the plot's name if drawing fails.
    pub fn plot(&self) -> Result<Plot> {
        let caption = "Straight is a power law; its exponent over the last two decades is written at each curve.";
        Plot::of("growth", caption, draw(self))
    }
}

/// Colours and marks of the kinds of scenes, from Okabe and Ito's palette; filled and hollow marks distinguish the
/// places.
const LOOKS: [([u8; 3], Mark); 3] =
    [([0x00, 0x9e, 0x73], Mark::Circle), ([0xd5, 0x5e, 0x00], Mark::Diamond), ([0x00, 0x72, 0xb2], Mark::Square)];

fn draw(growth: &Growth) -> Drawn<Drawing> {
    let places: Vec<usize> = (0..growth.places.len()).collect();
    let record = Record { subject: growth.subject.clone(), places: growth.places.clone(), ..Record::default() };
    let top = header_height(&places);
    let each = WIDTH / growth.panels.len().max(1) as i32;
    drawing([WIDTH, top + 900], |area| {
        header(area, &record, &growth.title, &places, true)?;
        for (column, panel) in growth.panels.iter().enumerate() {
            let n = panel.curves.iter().flat_map(|curve| &curve.points).map(|[n, _]| Some(*n));
            let alike = growth.panels.iter().filter(|other| other.measured == panel.measured);
            let values = alike.flat_map(|panel| &panel.curves).flat_map(|curve| &curve.points);
            let axes = (
                Axis::new(panel.over.as_str(), Unit::Plain, n),
                Axis::new(panel.measured.as_str(), Unit::Plain, values.map(|[_, value]| Some(*value))),
            );
            let left = each * column as i32;
            let (_, rest) = area.clone().split_horizontally(left);
            let (sheet, _) = rest.split_horizontally(each);
            // All areas share one canvas, so the chart leaves space for the header and for the names below it.
            let chart = chart(&sheet, axes, top + 20 + 34 * most_names(growth), SIDE)?;
            draw_panel(&sheet, &chart, growth, panel, top)?;
        }
        Ok(Vec::new())
    })
}

fn most_names(growth: &Growth) -> i32 {
    growth.panels.iter().map(|panel| names(panel).len()).max().unwrap_or(0) as i32
}

/// The kinds of scenes in a panel.
fn names(panel: &Panel) -> Vec<&str> {
    let mut names: Vec<&str> = panel.curves.iter().map(|curve| curve.name.as_str()).collect();
    names.dedup();
    names
}

fn draw_panel(area: &Area<'_>, chart: &Chart, growth: &Growth, panel: &Panel, top: i32) -> Drawn {
    let names = names(panel);
    let look = |name: &str| {
        let ([r, g, b], mark) = LOOKS[names.iter().position(|other| *other == name).unwrap_or(0) % LOOKS.len()];
        Look { color: RGBColor(r, g, b), mark, dash: None }
    };
    for (row, name) in names.iter().enumerate() {
        let y = top + 20 + 34 * row as i32;
        mark(area, &look(name), (chart.left + 10, y), 10, true)?;
        text(area, name, &font(24), (chart.left + 32, y))?;
    }
    let at = |[n, ms]: [f64; 2]| chart.at(n, Some(ms), 0.5);
    let mut ends = Vec::new();
    for curve in &panel.curves {
        let points: Vec<(i32, i32)> = curve.points.iter().map(|point| at(*point)).collect();
        let hollow = growth.places.get(curve.place).is_some_and(|place| place.backend == "cpu");
        let look = look(&curve.name);
        line(area, &Look { dash: hollow.then_some((14, 10)), ..look }, &points, 4)?;
        for point in &points {
            mark(area, &look, *point, 9, !hollow)?;
        }
        if let (Some([exponent, _]), Some(last)) = (curve.fit(), points.last()) {
            ends.push((*last, format!("n^{exponent:.2}"), look.color));
        }
    }
    // Beside the ends; overlapping ones are moved down.
    ends.sort_by_key(|((x, y), ..)| (*x, *y));
    let mut before = (0, 0);
    for ((x, y), words, color) in ends {
        let row = if x == before.0 { y.max(before.1 + SIZE + 5) } else { y };
        text(area, &words, &bold(SIZE).color(&color), (x + 18, row))?;
        before = (x, row);
    }
    Ok(())
}

/// Height of the text at a curve.
const SIZE: i32 = 23;

/// Space for it beside the chart.
const SIDE: i32 = 110;
