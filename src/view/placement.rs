//! Placement of a set of spheres: its own origin and unit.

use crate::double_double::{self as dd, Dd};
use glam::DVec3;
use halfline_ground::parallel::{self, CHEAP};
use std::ops::Range;

/// The middle of the scene, and a power of two that brings every sphere into [-1, 1] in each coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    middle: [f64; 3],
    /// The unit is 2^k.
    pub(crate) k: i32,
    /// 1, or 1/2 if differences of coordinates may exceed f64.
    half: f64,
    /// 2^-k / half, in two factors, since 2^-k itself may exceed f64.
    shrink: [f64; 2],
}

/// The error of a coordinate in f64, in the tree's unit: one difference of numbers whose difference is at most 2.
/// Section 9 of docs/certificate.md.
pub(crate) const PLACED: f64 = 1.0 / (1u64 << 51) as f64;

impl Placement {
    pub(crate) fn new(centers: &[[f64; 3]], radii: &[f64]) -> Self {
        let nothing = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let join = |[low, high]: [DVec3; 2], other: [DVec3; 2]| [low.min(other[0]), high.max(other[1])];
        let span = |ids: Range<usize>| centers[ids].iter().map(|c| [DVec3::from_array(*c); 2]).fold(nothing, join);
        let spans = parallel::blocks(0..centers.len(), CHEAP, &|ids, _| span(ids));
        let [low, high] = spans.into_iter().fold(nothing, join);
        let largest = parallel::reduce(radii, 0.0, f64::max);
        if centers.is_empty() {
            return Self { middle: [0.0; 3], k: 0, half: 1.0, shrink: [1.0; 2] };
        }
        let middle = low * 0.5 + high * 0.5;
        let reach = |half: f64| {
            let far = (high * half - middle * half).max(middle * half - low * half);
            far.max_element() + largest * half
        };
        let half = if (reach(1.0) * 2.0).is_finite() { 1.0 } else { 0.5 };
        // One more, so that rounding leaves nothing outside.
        let exponent = dd::exponent(reach(half)) + 1;
        let first = -exponent / 2;
        Self {
            middle: middle.to_array(),
            k: exponent + i32::from(half < 1.0),
            half,
            shrink: [dd::ldexp(1.0, first), dd::ldexp(1.0, -exponent - first)],
        }
    }

    /// a - b in the tree's unit: within 2^-53 of itself, away from underflow; infinite or NaN if f64 cannot hold it.
    #[inline(always)]
    pub(crate) fn difference(&self, a: f64, b: f64) -> f64 {
        self.length(a * self.half - b * self.half)
    }

    /// The same as a sum of two f64, exact away from the limits of f64.
    pub(crate) fn exact_difference(&self, a: f64, b: f64) -> Dd {
        let difference = Dd::diff(a * self.half, b * self.half);
        Dd { hi: self.length(difference.hi), lo: self.length(difference.lo) }
    }

    /// A length that was multiplied by `half`.
    #[inline(always)]
    fn length(&self, x: f64) -> f64 {
        x * self.shrink[0] * self.shrink[1]
    }

    /// A radius in the tree's unit, exact away from underflow.
    #[inline(always)]
    pub(crate) fn radius(&self, radius: f64) -> f64 {
        self.length(radius * self.half)
    }

    /// The origin of the tree's coordinates.
    pub(crate) fn middle(&self) -> [f64; 3] {
        self.middle
    }

    /// A point in the tree's coordinates, within [`PLACED`] for points of the scene.
    #[inline(always)]
    pub(crate) fn point(&self, p: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|n| self.difference(p[n], self.middle[n]))
    }
}
