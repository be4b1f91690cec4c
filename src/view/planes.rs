//! The planes that cut spheres, as the rays of one eye pass them.

use crate::double_double as dd;
use crate::dyadic::{self, Dyadic};
use crate::scene::{CutPlane, Cuts};
use crate::view::ray::dot3;
use glam::DVec3;
use std::cmp::Ordering;

/// Planes seen from an eye.
pub(crate) struct EyePlanes(Vec<EyePlane>);

/// N with its largest component in [1, 2), its length, and D - N.e, rounded from its exact value, with the sign of that.
pub(crate) struct EyePlane {
    pub(crate) normal: [f64; 3],
    pub(crate) length: f64,
    pub(crate) gap: f64,
    pub(crate) side: Ordering,
}

impl EyePlanes {
    pub(crate) fn new(cuts: &Cuts, eye: DVec3) -> Self {
        let eye = dyadic::vector(eye.to_array());
        let plane = |plane: &CutPlane| {
            let gap = &Dyadic::of(plane.distance) - &dyadic::dot(&dyadic::vector(plane.normal), &eye);
            // A power of two brings any length into range.
            let k = dd::exponent(plane.normal.iter().fold(0.0, |most, x| x.abs().max(most)));
            let normal = plane.normal.map(|x| dd::ldexp(x, -k));
            let (side, gap) = (gap.sign(), gap.ldexp(-i64::from(k)).to_f64());
            EyePlane { normal, length: dot3(normal, normal).sqrt(), gap, side }
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
