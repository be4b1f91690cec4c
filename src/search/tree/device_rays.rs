//! Rays from hits as devices read them.

use super::device::{NEAR, on_grid};
use super::{BoxRay, Tree};
use crate::double_double as dd;
use bytemuck::{Pod, Zeroable};

/// A direction as devices trace it from points of their own, declared in main/sky.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct DirectionRecord {
    /// A direction, as bits of f32, and 0; or the whole steps of a place on the grid, and 1.
    pub(crate) first: [u32; 4],
    /// The reciprocals of the direction's components, or the rest of the place beside its steps; bits of f32.
    pub(crate) second: [u32; 4],
}

impl DirectionRecord {
    /// The length to which directions of length 1 are scaled.
    pub(crate) const UNIT: f64 = 2.0;

    /// A direction of length 1, doubled: so its longest component is above 1.
    pub(crate) fn of_unit(direction: &[f32; 3]) -> Self {
        Self::scaled(direction.map(|x| Self::UNIT * f64::from(x)))
    }

    /// A direction of any length, with its longest component in [1, 2).
    pub(crate) fn new(direction: [f64; 3]) -> Self {
        let e = dd::exponent(direction.iter().fold(0.0, |most, x| x.abs().max(most)));
        Self::scaled(direction.map(|x| dd::ldexp(x, -e)))
    }

    /// A place, for rays that end there; `None` where it is out of the range of f32.
    pub(crate) fn place(tree: &Tree, place: [f64; 3]) -> Option<Self> {
        let at = tree.placement.point(place);
        let far = at.iter().fold(0.0f64, |far, x| x.abs().max(far));
        let (steps, [x, y, z]) = match far {
            far if far <= NEAR => on_grid(at),
            _ => ([0; 3], at.map(|x| x as f32)),
        };
        let [i, j, k] = steps.map(|step| step as u32);
        let [x, y, z] = [x, y, z].map(f32::to_bits);
        (far < FARTHEST).then_some(Self { first: [i, j, k, 1], second: [x, y, z, 0] })
    }

    /// The record of `direction`, rounded to f32.
    fn scaled(direction: [f64; 3]) -> Self {
        let [x, y, z] = direction.map(|x| (x as f32).to_bits());
        let [a, b, c] = BoxRay::inverse(direction).map(f32::to_bits);
        Self { first: [x, y, z, 0], second: [a, b, c, 0] }
    }
}

/// Bound of a place's coordinates, in the tree's unit: the squares of ways to it are within f32.
const FARTHEST: f64 = (1u64 << 40) as f64;
