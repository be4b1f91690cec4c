//! Logarithmic axes with bands for zero and for unbounded values, and the chart between two of them.

use super::look::{BAND, FAINT, GRID, QUIET};
use halfline_drawing::canvas::{Area, Drawn, INK, centered, font, text};
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use std::ops::Range;

/// The number format of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unit {
    Plain,
    Percent,
}

/// A logarithmic axis; coordinates on it are decades.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    title: String,
    unit: Unit,
    low: f64,
    high: f64,
    /// Decades below `low` for zero; 0 where no value is zero.
    zero: f64,
    /// Decades above `high` for unbounded values.
    unbounded: f64,
}

/// Share of an axis for the band of zero.
const ZERO: f64 = 0.28;
/// Share of an axis for the band of unbounded values.
const UNBOUNDED: f64 = 0.1;

impl Axis {
    /// An axis over `values`, where `None` is unbounded.
    pub(super) fn new(title: impl Into<String>, unit: Unit, values: impl Iterator<Item = Option<f64>> + Clone) -> Self {
        let logs = values.clone().flatten().filter(|value| *value > 0.0).map(f64::log10);
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        let (low, high) = if low <= high { (low, high) } else { (-6.0, 0.0) };
        let spare = (0.05 * (high - low)).max(0.15);
        let (low, high) = match unit {
            Unit::Plain => (low - spare, high + spare),
            // A share is at most 1, and an axis should show how small most shares are.
            Unit::Percent => ((low - spare).min(-3.1), 0.04),
        };
        let has = |test: fn(Option<f64>) -> bool| values.clone().any(test);
        let band = |share: f64, has: bool| if has { share * (high - low) } else { 0.0 };
        Self {
            title: title.into(),
            unit,
            low,
            high,
            zero: band(ZERO, has(|value| value == Some(0.0))),
            unbounded: band(UNBOUNDED, has(|value| value.is_none())),
        }
    }

    /// The same with space for names above.
    pub(super) fn roomy(mut self) -> Self {
        self.high += 0.1 * (self.high - self.low);
        self
    }

    /// The position of a value; `lane` (0 to 1, from above) separates values that are all zero.
    pub(super) fn at(&self, value: Option<f64>, lane: f64) -> f64 {
        match value {
            None => self.high + self.unbounded / 2.0,
            Some(value) if value > 0.0 => value.log10(),
            Some(_) => self.low - self.zero * lane,
        }
    }

    /// Labelled positions.
    fn ticks(&self) -> Vec<f64> {
        let span = self.high - self.low;
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let (factors, stride): (&[f64], i32) =
            if span < 2.5 { (&[1.0, 2.0, 5.0], 1) } else { (&[1.0], (span / 9.0).ceil() as i32) };
        let decades = (first..=last).filter(|decade| decade.rem_euclid(stride) == 0);
        let all = decades.flat_map(|decade| factors.iter().map(move |factor| f64::from(decade) + factor.log10()));
        let mut ticks: Vec<f64> = all.filter(|tick| (self.low..=self.high).contains(tick)).collect();
        ticks.extend((self.zero > 0.0).then(|| self.at(Some(0.0), 0.5)));
        ticks.extend((self.unbounded > 0.0).then(|| self.at(None, 0.5)));
        ticks
    }

    /// Positions between the labelled ones.
    fn between(&self) -> Vec<f64> {
        let span = self.high - self.low;
        let factors: &[f64] = if span < 4.0 { &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0] } else { &[1.0] };
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let all = decades.flat_map(|decade| factors.iter().map(move |factor| f64::from(decade) + factor.log10()));
        all.filter(|tick| (self.low..=self.high).contains(tick)).collect()
    }

    /// The pixel of a position between `first` and `last`, which may run downwards.
    fn pixel(&self, at: f64, (first, last): (i32, i32)) -> i32 {
        let Range { start, end } = self.range();
        first + ((at - start) / (end - start) * f64::from(last - first)).round() as i32
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, at: &f64, limit: (i32, i32)) -> i32 {
        self.pixel(*at, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { self.between() } else { self.ticks() }
    }

    fn range(&self) -> Range<f64> {
        self.low - self.zero..self.high + self.unbounded
    }
}

impl ValueFormatter<f64> for Axis {
    fn format(tick: &f64) -> String {
        tick.to_string()
    }

    fn format_ext(&self, tick: &f64) -> String {
        if *tick < self.low {
            return if self.unit == Unit::Percent { "none".into() } else { "0".into() };
        }
        if *tick > self.high {
            return "unbounded".into();
        }
        let decade = (tick + 1e-6).floor();
        let factor = 10f64.powf(tick - decade).round() as i32;
        match self.unit {
            // Powers of ten on the whole axis if some of its labels need them.
            Unit::Plain if factor == 1 && decade != 0.0 && (self.low < -2.5 || self.high > 4.0) => power(decade as i32),
            unit => number(factor, decade as i32, unit),
        }
    }
}

/// A number of one digit times a power of ten, in a short form.
pub(super) fn number(factor: i32, decade: i32, unit: Unit) -> String {
    let value = f64::from(factor) * 10f64.powi(decade);
    match (unit, factor) {
        (Unit::Percent, _) => format!("{:.*} %", usize::try_from(-(decade + 2)).unwrap_or(0), 100.0 * value),
        (Unit::Plain, _) if (-2..=3).contains(&decade) => {
            format!("{value:.*}", usize::try_from(-decade).unwrap_or(0))
        }
        (Unit::Plain, 1) => power(decade),
        (Unit::Plain, _) => format!("{factor}\u{b7}{}", power(decade)),
    }
}

/// A value to one digit.
pub(super) fn rounded(value: f64) -> String {
    if value <= 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decade = (value.log10() + 1e-9).floor();
    match (value / 10f64.powf(decade)).round() as i32 {
        10 => number(1, decade as i32 + 1, Unit::Plain),
        factor => number(factor, decade as i32, Unit::Plain),
    }
}

/// A power of ten.
fn power(decade: i32) -> String {
    let raised = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    "10".chars().chain(decade.to_string().chars().map(raised)).collect()
}

/// The position of the chart on its page.
#[derive(Debug, Clone)]
pub(super) struct Chart {
    x: Axis,
    y: Axis,
    pub(super) left: i32,
    pub(super) top: i32,
    pub(super) right: i32,
    pub(super) bottom: i32,
}

/// Space for the numbers and the title of an axis.
const LABELS: [i32; 2] = [120, 190];

/// Draws the axes and the grid of a chart that leaves `header` above and `side` to the right.
pub(super) fn chart(area: &Area<'_>, (x, y): (Axis, Axis), header: i32, side: i32) -> Drawn<Chart> {
    let (width, height) = area.dim_in_pixel();
    let (left, right) = (LABELS[1], width as i32 - side);
    let (top, bottom) = (header, height as i32 - LABELS[0]);
    let chart = Chart { x, y, left, top, right, bottom };
    let mut builder = ChartBuilder::on(area);
    builder.margin_top(top).margin_right(side);
    builder.set_label_area_size(LabelAreaPosition::Left, LABELS[1]);
    builder.set_label_area_size(LabelAreaPosition::Bottom, LABELS[0]);
    let mut context = builder.build_cartesian_2d(chart.x.clone(), chart.y.clone())?;
    context
        .configure_mesh()
        .bold_line_style(GRID.stroke_width(2))
        .light_line_style(FAINT.stroke_width(2))
        .axis_style(QUIET.stroke_width(2))
        .label_style(font(26))
        .draw()?;
    // Drawn over the grid: within this band distances have no meaning.
    let band =
        |from: f64, to: f64| Rectangle::new([(left + 2, chart.row(to)), (right, chart.row(from) - 2)], BAND.filled());
    let Axis { low, high, zero, unbounded, .. } = chart.y;
    if unbounded > 0.0 {
        area.draw(&band(high, high + unbounded))?;
    }
    // plotters positions titles by an estimated width; these are positioned exactly.
    text(area, &chart.x.title, &centered(&font(28)), ((left + right) / 2, bottom + 88))?;
    let turned = centered(&font(28)).transform(FontTransform::Rotate270);
    text(area, &chart.y.title, &turned, (MARGIN_TITLE, (top + bottom) / 2))?;
    if zero > 0.0 {
        area.draw(&band(low - zero, low))?;
        let edge = chart.row(low);
        area.draw(&DashedPathElement::new([(left, edge), (right, edge)], 10, 8, INK.mix(0.5).stroke_width(2)))?;
    }
    Ok(chart)
}

/// The middle of the vertical axis' title.
const MARGIN_TITLE: i32 = 34;

impl Chart {
    /// The point of a value on each axis.
    pub(super) fn at(&self, x: f64, y: Option<f64>, lane: f64) -> (i32, i32) {
        (self.column(self.x.at(Some(x), 0.5)), self.row(self.y.at(y, lane)))
    }

    /// The upper edge of the band for zero of the vertical axis, if it has one.
    pub(super) fn zero_edge(&self) -> Option<i32> {
        (self.y.zero > 0.0).then(|| self.row(self.y.low))
    }

    fn column(&self, x: f64) -> i32 {
        self.x.pixel(x, (self.left, self.right))
    }

    fn row(&self, y: f64) -> i32 {
        self.y.pixel(y, (self.bottom, self.top))
    }
}
