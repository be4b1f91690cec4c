//! Paths of SVG: closed lines of elliptical arcs.

use super::circle::Projection;
use super::regions::{Piece, Region, Regions};
use glam::DVec2;
use std::f64::consts::TAU;
use std::fmt::Write;

/// The largest part of an ellipse in one arc, so that no arc is the larger of two.
const MOST: f64 = 2.6;

impl Regions {
    /// The value of `d` of a region's path.
    pub(super) fn path(&self, region: &Region, projection: &Projection) -> String {
        let mut path = String::new();
        for line in &region.lines {
            for (n, piece) in line.iter().enumerate() {
                if n == 0 {
                    let start = projection.place(self.curves[piece.curve as usize].circle.point(piece.from));
                    let _ = write!(path, "M{}", numbers(start));
                }
                self.add(piece, projection, &mut path);
            }
            path.push('Z');
        }
        path
    }

    fn add(&self, piece: &Piece, projection: &Projection, path: &mut String) {
        let circle = &self.curves[piece.curve as usize].circle;
        let place = |angle: f64| projection.place(circle.point(angle));
        let Some(ellipse) = circle.ellipse(projection) else {
            let _ = write!(path, "L{}", numbers(place(piece.to)));
            return;
        };
        let [start, end] = [piece.from, piece.to].map(|angle| ellipse.angle(place(angle)));
        let middle = ellipse.angle(place(0.5 * (piece.from + piece.to)));
        // Onward if the middle comes before the end.
        let [to_middle, to_end] = [middle, end].map(|angle| (angle - start).rem_euclid(TAU));
        let is_whole = (piece.to - piece.from).abs() > TAU - 1e-9;
        let onward = is_whole || to_middle < to_end;
        let way = if is_whole {
            TAU
        } else if onward {
            to_end
        } else {
            TAU - to_end
        };
        let count = (way / MOST).ceil().max(1.0) as u32;
        let [a, b] = ellipse.axes;
        for n in 1..=count {
            let share = f64::from(n) / f64::from(count) * way;
            let angle = if onward { start + share } else { start - share };
            let to = if n == count { place(piece.to) } else { ellipse.place(angle) };
            let sweep = u8::from(onward);
            let _ = write!(
                path,
                "A{} {} 0 {sweep} {}",
                numbers(DVec2::new(a, b)),
                number(ellipse.turn.to_degrees()),
                numbers(to)
            );
        }
    }
}

fn number(x: f64) -> String {
    let text = format!("{x:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn numbers(at: DVec2) -> String {
    format!("{} {}", number(at.x), number(at.y))
}
