//! The planes that cut spheres, as the rays of one eye pass them.

use crate::double_double::Dd;
use crate::dyadic::{self, Dyadic};
use crate::scene::{CutPlane, Cuts};
use crate::view::ray::dot3;
use glam::DVec3;
use std::cmp::Ordering;
use std::sync::Arc;

/// Planes seen from an eye.
#[derive(Clone)]
pub(crate) struct EyePlanes(Arc<[EyePlane]>);

/// N with its largest component in [1, 2), its length, D in that unit, and D - N.e, rounded from its exact value, with the sign of that.
pub(crate) struct EyePlane {
    pub(crate) normal: [f64; 3],
    pub(crate) length: f64,
    distance: f64,
    pub(crate) gap: f64,
    pub(crate) side: Ordering,
}

/// Bound of the error of a sum of three products and a number in double-double, relative to the sum of their sizes.
/// Section 9a of docs/certificate.md.
const SUMMED: f64 = 1.0 / (1u128 << 96) as f64;

impl EyePlanes {
    pub(crate) fn new(cuts: &Cuts, eye: DVec3) -> Self {
        let eye = dyadic::vector(eye.to_array());
        let plane = |plane: &CutPlane| {
            let gap = &Dyadic::of(plane.distance) - &dyadic::dot(&dyadic::vector(plane.normal), &eye);
            let (side, gap) = (gap.sign(), gap.ldexp(-i64::from(plane.exponent())).to_f64());
            let CutPlane { normal, distance } = plane.in_range();
            EyePlane { normal, length: dot3(normal, normal).sqrt(), distance, gap, side }
        };
        Self(cuts.planes.iter().map(plane).collect())
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &EyePlane> {
        self.0.iter()
    }

    /// The normal of a plane, of length 1.
    pub(crate) fn normal(&self, plane: usize) -> [f64; 3] {
        let EyePlane { normal, length, .. } = &self.0[plane];
        normal.map(|x| x / length)
    }
}

impl EyePlane {
    /// D - N.p of a point of the world, and a bound of its error.
    pub(crate) fn gap_at(&self, point: [f64; 3]) -> [f64; 2] {
        let terms: [Dd; 3] = std::array::from_fn(|k| Dd::product(self.normal[k], point[k]));
        let gap = (Dd::from(self.distance) - (terms[0] + terms[1] + terms[2])).value();
        let sizes = terms.iter().map(|term| term.hi.abs()).sum::<f64>() + self.distance.abs();
        // Products below the normal numbers lose bits, and D where it was scaled.
        [gap, SUMMED * sizes + f64::EPSILON * gap.abs() + 8.0 * f64::MIN_POSITIVE]
    }
}
