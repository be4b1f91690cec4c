//! The rays of a view as the boxes see them, padded so that no sphere which a method reports is left out.

use super::{BoxRay, Tree};
use crate::double_double as dd;
use crate::intersect::{Form, Method};
use crate::view::View;
use crate::view::ray::RayRecord;

/// How far a method may report a sphere beside the ray, or before or behind the hit; docs/tree.md. S is at least |p| + r + |o|.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Slack {
    /// Of S, in u = 2^-23: the rounding of records, and of the form's t and outline.
    pub(crate) linear: f64,
    /// Of S^2, in u: what the form's discriminant may be off by.
    pub(crate) square: f64,
}

impl Slack {
    /// For what `method` may report.
    pub(crate) fn of(method: Method) -> Self {
        match method.form() {
            _ if method.is_wide() => Self { linear: 8.0, square: 0.0 },
            Form::Perpendicular => Self { linear: 64.0, square: 0.0 },
            Form::General | Form::Normalised => Self { linear: 64.0, square: 32.0 },
        }
    }

    /// The padding of spheres of radius `r` or more with S = `s`.
    fn pad(self, r: f64, s: f64) -> f64 {
        const U: f64 = 1.0 / (1u64 << 23) as f64;
        // sqrt(r^2 + e) - r without its cancellation.
        let e = self.square * U * s * s;
        let square = if e > 0.0 { e / (r + (r * r + e).sqrt()) } else { 0.0 };
        self.linear * U * s + square
    }
}

/// The farthest that a sphere reaches from the middle of the tree: its coordinates and its radius together are at most 1.
const REACH: f64 = 1.75;

/// How the rays of a view lie in the tree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MethodRays {
    /// The view's eye in the tree's coordinates.
    eye: [f64; 3],
    /// The view's unit in the tree's.
    pub(crate) ratio: f64,
    /// The least radius of all spheres in the tree's unit, where the slack depends on it.
    least: f64,
    slack: Slack,
}

impl MethodRays {
    /// For the rays of `view` by `method`.
    pub(crate) fn new(tree: &Tree, view: &View, method: Method) -> Self {
        Self::padded(tree, view, Slack::of(method))
    }

    /// The same with another slack.
    pub(super) fn padded(tree: &Tree, view: &View, slack: Slack) -> Self {
        let radius = |[.., radius]: &[f64; 4]| tree.placement.radius(*radius);
        let least = if slack.square > 0.0 { tree.spheres.iter().map(radius).fold(f64::MAX, f64::min) } else { 0.0 };
        let eye = tree.placement.point(view.basis.e.to_array());
        Self { eye, ratio: dd::ldexp(1.0, view.unit - tree.placement.k), least, slack }
    }

    /// The ray as the boxes see it; `None` if `method` certainly reports nothing.
    #[inline(always)]
    pub(crate) fn ray(&self, r: &RayRecord) -> Option<BoxRay> {
        // Of a number and its rounding error.
        let whole = |high: f32, low: f32| f64::from(high) + f64::from(low);
        let away: [f64; 3] = std::array::from_fn(|n| whole(r.origin[n], r.origin_low[n]) * self.ratio);
        let low = [r.direction[3], r.origin[3], r.origin_low[3]];
        let direction = std::array::from_fn(|n| whole(r.direction[n], low[n]));
        let length = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z).sqrt();
        let extra = self.slack.pad(self.least, REACH + length(self.eye) + length(away));
        // Kernels read the ratio as f32.
        if !(self.ratio as f32).is_normal() {
            return Some(BoxRay::EVERYTHING);
        }
        BoxRay::new(std::array::from_fn(|n| self.eye[n] + away[n]), direction, extra)
    }

    /// t of a hit in the frame's unit, as a limit of the boxes.
    #[inline(always)]
    pub(crate) fn limit(&self, ray: &BoxRay, t: f64) -> f32 {
        ray.limit(t * self.ratio)
    }
}
