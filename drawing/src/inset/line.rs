//! Lines from the things of a picture to their marks.

use super::page::{INK, PAPER, Page, Panel};
use super::sheet::{Shape, Sheet};

/// A line between the middles of two pixels, columns and rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Line {
    pub(super) from: [i64; 2],
    pub(super) to: [i64; 2],
}

impl Line {
    pub(super) fn length(&self) -> f32 {
        let [x, y] = [0, 1].map(|k| (self.to[k] - self.from[k]) as f32);
        (x * x + y * y).sqrt()
    }

    /// Its pixels.
    pub(super) fn points(&self) -> impl Iterator<Item = [i64; 2]> {
        let away = [0, 1].map(|k| self.to[k] - self.from[k]);
        let (steps, from) = (away[0].abs().max(away[1].abs()).max(1), self.from);
        (0..=steps).map(move |n| [0, 1].map(|k| from[k] + (2 * n * away[k] + steps).div_euclid(2 * steps)))
    }

    /// The distance of a point from it.
    pub(super) fn distance(&self, point: [i64; 2]) -> f32 {
        let [along, to] = [self.to, point].map(|at| [0, 1].map(|k| (at[k] - self.from[k]) as f32));
        let dot = |a: [f32; 2], b: [f32; 2]| a[0] * b[0] + a[1] * b[1];
        let share = (dot(along, to) / dot(along, along).max(1.0)).clamp(0.0, 1.0);
        let away = [0, 1].map(|k| to[k] - share * along[k]);
        dot(away, away).sqrt()
    }

    /// Whether two lines cross.
    pub(super) fn crosses(&self, other: &Self) -> bool {
        let side = |line: &Self, [x, y]: [i64; 2]| {
            let [a, b] = [line.from, line.to];
            ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])).signum()
        };
        let parts = |line: &Self, other: &Self| side(line, other.from) * side(line, other.to) <= 0;
        parts(self, other) && parts(other, self)
    }
}

impl Page {
    /// A line with a halo, and a dot at its beginning.
    pub(super) fn line_to(&self, line: Line, is_light: bool) -> Option<(Line, Panel)> {
        let (ink, halo_ink) = if is_light { (PAPER, INK) } else { (INK, PAPER) };
        let width = (0.06 * self.size).max(1.0);
        let [dot, halo] = [1.6 * width, 0.08 * self.size + 1.0];
        let edge = (dot + halo).ceil() as i64 + 1;
        let sides = [self.width, self.height].map(|side| side as i64);
        let low = [0, 1].map(|k| (line.from[k].min(line.to[k]) - edge).max(0));
        let high = [0, 1].map(|k| (line.from[k].max(line.to[k]) + edge + 1).min(sides[k]));
        let mut sheet = Sheet::new([0, 1].map(|k| (high[k] - low[k]).max(0) as f32), false)?;
        let middle = |at: [i64; 2]| [0, 1].map(|k| (at[k] - low[k]) as f32 + 0.5);
        let ends = [middle(line.from), middle(line.to)];
        for (color, more) in [(halo_ink, halo), (ink, 0.0)] {
            sheet.shapes.push(Shape::Line { ends, width: width + more, color });
            sheet.shapes.push(Shape::Disc { at: ends[0], radius: dot + more / 2.0, color });
        }
        Some((line, Panel { at: low.map(|x| x as usize), sheet }))
    }
}
