//! The paint of paths: the light of a headlight on a sphere as a radial gradient, and what else a page of a figure has.

use super::circle::{Ball, Projection};
use super::path::Step;
use crate::inset::sheet::OPACITY;
use glam::DVec2;
use halfline::frame::srgb::level;
use halfline::frame::tone::Toning;

/// A figure on a page, from back to front.
#[derive(Debug)]
pub(super) struct Page {
    /// Width and height, units.
    pub(super) size: [f64; 2],
    /// Units in an inch.
    pub(super) dpi: Option<u32>,
    pub(super) background: Option<[u8; 3]>,
    /// The colours from the middle of a sphere to its outline.
    pub(super) gradients: Vec<Vec<Stop>>,
    /// The lines where the depth jumps.
    pub(super) lines: Option<Lines>,
    pub(super) groups: Vec<Group>,
}

/// Lines over all paths.
#[derive(Debug)]
pub(super) struct Lines {
    pub(super) color: [u8; 3],
    pub(super) width: f64,
    pub(super) steps: Vec<Step>,
}

/// The width of the lines that close the seams between paths, pixels.
pub(super) const SEAM: f64 = 0.3;

/// The opacity of paper in the space of sRGB, in which programs blend, so that it is on black as it is in pictures.
pub(super) fn paper() -> f64 {
    f64::from(level(OPACITY)) / 255.0
}

/// Paths with one name.
#[derive(Debug)]
pub(super) struct Group {
    /// `None` for paths without a group.
    pub(super) id: Option<String>,
    /// Columns and their values.
    pub(super) data: Vec<(String, String)>,
    pub(super) paths: Vec<Path>,
}

/// A path of a page.
#[derive(Debug)]
pub(super) struct Path {
    pub(super) name: String,
    pub(super) data: Vec<(String, String)>,
    pub(super) steps: Vec<Step>,
    pub(super) paint: Paint,
}

/// The paint of a path.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Paint {
    Flat([u8; 3]),
    /// A gradient of the circle of radius 1, moved by a matrix, as of SVG; its middle is the focus.
    Radial {
        stops: usize,
        matrix: [f64; 6],
        focus: DVec2,
    },
}

/// A colour of a gradient at a share of the way from the middle to the outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stop {
    pub(super) at: f64,
    pub(super) color: [u8; 3],
}

/// The largest difference between a gradient and the shading, in levels of 255.
const LEVELS: f64 = 2.0;

/// The colour of a cosine between the normal and the way back, sRGB.
pub(super) fn lighted(own: [f32; 3], cosine: f64, toning: Toning) -> [u8; 3] {
    toning.of(own.map(|c| cosine.max(0.0) as f32 * c)).map(level)
}

/// The colours of a sphere under a light at the eye, from its middle to its outline. At a share s of the way the sine between the normal and
/// the ray is s.
pub(super) fn gradient(own: [f32; 3], toning: Toning) -> Vec<Stop> {
    const STEPS: usize = 4096;
    // Closer at the outline, where the light falls fastest.
    let share = |n: usize| (std::f64::consts::FRAC_PI_2 * n as f64 / STEPS as f64).sin();
    let colors: Vec<[u8; 3]> = (0..=STEPS).map(|n| lighted(own, (1.0 - share(n).powi(2)).sqrt(), toning)).collect();
    let fits = |from: usize, to: usize| {
        let step = ((to - from) / 32).max(1);
        (from..to).step_by(step).all(|n| {
            let along = (share(n) - share(from)) / (share(to) - share(from));
            (0..3).all(|k| {
                let [a, b, c] = [colors[from][k], colors[to][k], colors[n][k]].map(f64::from);
                (a + along * (b - a) - c).abs() <= LEVELS
            })
        })
    };
    let (mut stops, mut from) = (vec![Stop { at: 0.0, color: colors[0] }], 0);
    while from < STEPS {
        // The farthest that fits, by halves.
        let (mut near, mut far) = (from + 1, STEPS + 1);
        while far - near > 1 {
            let middle = near.midpoint(far);
            if fits(from, middle) { near = middle } else { far = middle }
        }
        stops.push(Stop { at: share(near), color: colors[near] });
        from = near;
    }
    stops
}

/// The matrix that moves the circle of radius 1 to the outline of a ball, and the place of its middle in that circle. The lines of equal
/// light are circles around it then: exactly for parallel rays, and nearly where the ball is small as seen by the eye.
pub(super) fn outline(ball: &Ball, projection: &Projection) -> Option<([f64; 6], DVec2)> {
    let ellipse = ball.contour(projection).ellipse(projection)?;
    let (sin, cos) = ellipse.turn.sin_cos();
    let [a, b] = ellipse.axes;
    let away = DVec2::from_angle(-ellipse.turn).rotate(projection.place(ball.center) - ellipse.center);
    let matrix = [a * cos, a * sin, -b * sin, b * cos, ellipse.center.x, ellipse.center.y];
    Some((matrix, away / DVec2::new(a, b)))
}
