//! Paths: the lines of regions as arcs of ellipses and straight lines of the image.

use super::circle::{Ellipse, Projection};
use super::curves::Shape;
use super::regions::{Piece, Region, Regions};
use glam::DVec2;
use std::f64::consts::TAU;

/// The largest part of an ellipse in one arc, so that no arc is the larger of two.
const MOST: f64 = 2.6;

/// A step of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// A closed line begins.
    Start(DVec2),
    /// A straight line.
    Line(DVec2),
    /// A part of an ellipse: from an angle of it so far on, or back where that is negative, to a place.
    Arc { ellipse: Ellipse, from: f64, way: f64, to: DVec2 },
}

/// A number to 1e-4, without zeros that say nothing.
pub(super) fn number(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text.strip_prefix("0.").map(|digits| format!(".{digits}")) {
        Some(short) => short,
        None if text == "-0" => "0".into(),
        None => text.into(),
    }
}

/// The two numbers of a place.
pub(super) fn numbers(at: DVec2) -> String {
    format!("{} {}", number(at.x), number(at.y))
}

impl Regions {
    /// The path of a region, of closed lines.
    pub(super) fn path(&self, region: &Region, projection: &Projection) -> Vec<Step> {
        let mut path = Vec::new();
        for line in &region.lines {
            for (n, piece) in line.iter().enumerate() {
                if n == 0 {
                    path.push(Step::Start(projection.place(self.shape(piece).point(piece.from))));
                }
                self.add(piece, projection, &mut path);
            }
        }
        path
    }

    /// The path of pieces; each piece begins a line.
    pub(super) fn path_of_jumps(&self, projection: &Projection) -> Vec<Step> {
        let mut path = Vec::new();
        for piece in &self.jumps {
            path.push(Step::Start(projection.place(self.shape(piece).point(piece.from))));
            self.add(piece, projection, &mut path);
        }
        path
    }

    fn shape(&self, piece: &Piece) -> &Shape {
        &self.curves[piece.curve as usize].shape
    }

    fn add(&self, piece: &Piece, projection: &Projection, path: &mut Vec<Step>) {
        let shape = self.shape(piece);
        let place = |at: f64| projection.place(shape.point(at));
        let ellipse = match shape {
            Shape::Circle(circle) => circle.ellipse(projection),
            Shape::Line(_) => None,
        };
        let Some(ellipse) = ellipse else {
            path.push(Step::Line(place(piece.to)));
            return;
        };
        let [start, end] = [piece.from, piece.to].map(|angle| ellipse.angle(place(angle)));
        let middle = ellipse.angle(place(0.5 * (piece.from + piece.to)));
        // Onward if the middle comes before the end.
        let [to_middle, to_end] = [middle, end].map(|angle| (angle - start).rem_euclid(TAU));
        let is_whole = (piece.to - piece.from).abs() > TAU - 1e-9;
        let way = if is_whole {
            TAU
        } else if to_middle < to_end {
            to_end
        } else {
            to_end - TAU
        };
        let count = (way.abs() / MOST).ceil().max(1.0) as u32;
        let part = way / f64::from(count);
        for n in 0..count {
            let from = start + f64::from(n) * part;
            let to = if n + 1 == count { place(piece.to) } else { ellipse.place(from + part) };
            path.push(Step::Arc { ellipse, from, way: part, to });
        }
    }
}
