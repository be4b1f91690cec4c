//! Given rays as devices read them.

use super::device::{NEAR, PLACE, on_grid};
use super::{BoxRay, Tree};
use crate::double_double as dd;
use bytemuck::{Pod, Zeroable};

/// A ray as the boxes see it, on devices; search/tree.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct BoxRayRecord {
    /// As of [`BoxRay`]; the fourth numbers are unused.
    pub(crate) enter: [f32; 4],
    pub(crate) leave: [f32; 4],
    pub(crate) inverse: [f32; 4],
}

impl BoxRayRecord {
    /// A ray as the boxes see it, or one that meets nothing.
    pub(crate) fn new(ray: Option<BoxRay>) -> Self {
        let four = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
        let of = |ray: BoxRay| Self { enter: four(ray.enter), leave: four(ray.leave), inverse: four(ray.inverse) };
        ray.map_or(Self::NOTHING, of)
    }

    /// A ray that leaves every box before it enters it.
    const NOTHING: Self = Self { enter: [-BEYOND_SCENE; 4], leave: [BEYOND_SCENE; 4], inverse: [1.0; 4] };
}

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

/// Beyond the scene.
const BEYOND_SCENE: f32 = (1u32 << 20) as f32;

/// A ray as devices certify it, in the tree's unit; certify/given.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct CertifiedRayRecord {
    /// The start: the origin or a point ahead of it, as [`BoxRay`] has it.
    pub(crate) steps: [i32; 3],
    /// Lower bound of the limit, as t from the start.
    pub(crate) sure_limit: f32,
    pub(crate) rest: [f32; 3],
    /// Upper bound of the limit, as t from the start.
    pub(crate) limit: f32,
    pub(crate) direction: [f32; 3],
    /// Bound of the error of the places of the ray and of a sphere together, in each component.
    pub(crate) blur: f32,
}

impl CertifiedRayRecord {
    /// A ray that tests no sphere.
    pub(crate) const NOTHING: Self =
        Self { steps: [0; 3], sure_limit: -1.0, rest: [0.0; 3], limit: -1.0, direction: [1.0; 3], blur: 0.0 };

    /// The ray from `origin` (in the tree's coordinates) along `direction`, whose largest component is in [1, 2), with
    /// a limit between the two numbers of `limit`. `None` if its boxes leave nothing out, since then f32 decides
    /// nothing either.
    pub(crate) fn new(origin: [f64; 3], direction: [f64; 3], limit: [f64; 2], boxes: &BoxRay) -> Option<Self> {
        if *boxes == BoxRay::EVERYTHING {
            return None;
        }
        let (steps, rest) = on_grid(std::array::from_fn(|n| origin[n] + boxes.start * direction[n]));
        Some(Self {
            steps,
            sure_limit: boxes.limit_below(limit[0]),
            rest,
            limit: boxes.limit(limit[1]),
            direction: direction.map(|x| x as f32),
            blur: ((BoxRay::lost(origin) + PLACE) as f32).next_up(),
        })
    }
}
