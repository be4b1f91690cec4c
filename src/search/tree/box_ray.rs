//! A ray as the boxes of the tree see it. docs/certificate.md, section 9b, derives its padding.

use crate::view::placement::PLACED;

/// u of docs/certificate.md: WGSL rounds up or down. Section 9b.
const U: f64 = 1.0 / (1u64 << 23) as f64;

/// The roundings of a slab test in u, of the largest number in it. Section 9b.
const SLABS: f64 = 8.0;

/// Smallest component of a direction in slab tests. A smaller one is replaced by it, so that nothing is divided by
/// zero. That moves a point of the ray by less than 2^-32 of its way. Section 9b.
const LEAST: f64 = 1.0 / (1u64 << 32) as f64;

/// Origins farther than this from the middle, in the tree's unit, are moved along the ray to the scene. Section 9b.
const NEAR: f64 = 4.0;

/// Origins farther than this are so inaccurate beside the scene that every sphere is tested. Section 9b.
const FARTHEST: f64 = (1u64 << 44) as f64;

/// With more padding than this boxes leave out so few spheres that every sphere is tested. Section 9b.
const WIDEST: f64 = 0.25;

/// A ray as the boxes see it, in the tree's unit: f32, and so much larger than a line that no rounding loses a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BoxRay {
    /// The origin or a point ahead of it, moved ahead along each axis by the padding: for the planes where it enters.
    pub(crate) enter: [f32; 3],
    /// The same moved back: for the planes where it leaves.
    pub(crate) leave: [f32; 3],
    /// Reciprocals of the direction.
    pub(crate) inverse: [f32; 3],
    /// The point itself.
    pub(crate) origin: [f32; 3],
    pub(crate) direction: [f32; 3],
    /// At least |direction|^2, by no more than a few roundings.
    pub(crate) a: f32,
    /// The root of `a`: at least |direction|.
    pub(crate) length: f32,
    /// The padding, rounded up: bound of the distance along each axis between a true point of the ray and the rounded
    /// line.
    pub(crate) pad: f32,
    /// t of that point on the ray.
    pub(crate) start: f64,
}

impl BoxRay {
    /// The ray from `origin` (in the tree's coordinates) along `direction`, whose largest component is in [1, 2). `extra`
    /// is a padding beside the padding of the slabs, for what a method may report. `None` if the ray certainly meets no sphere.
    #[inline(always)]
    pub(crate) fn new(origin: [f64; 3], direction: [f64; 3], extra: f64) -> Option<Self> {
        let far = origin[0].abs().max(origin[1].abs()).max(origin[2].abs());
        if far.is_nan() || far > FARTHEST || extra.is_nan() || extra > WIDEST {
            return Some(Self::EVERYTHING);
        }
        let lost = Self::lost(origin);
        let start = if far <= NEAR { 0.0 } else { entry(origin, direction, 1.0 + lost + extra)? };
        let from: [f64; 3] = std::array::from_fn(|n| origin[n] + start * direction[n]);
        let near = if far <= NEAR { far } else { 4.0 };
        let pad = SLABS * U * (1.0 + near) + lost + extra;
        let a = (direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]) * ROUNDED;
        let inverse = Self::inverse(direction);
        let signed_pad = |n: usize| if inverse[n] < 0.0 { -pad } else { pad };
        Some(Self {
            enter: std::array::from_fn(|n| (from[n] + signed_pad(n)) as f32),
            leave: std::array::from_fn(|n| (from[n] - signed_pad(n)) as f32),
            inverse,
            origin: from.map(|x| x as f32),
            direction: direction.map(|x| x as f32),
            a: a as f32,
            length: a.sqrt() as f32,
            pad: (pad as f32).next_up(),
            start,
        })
    }

    /// Reciprocals of a direction's components.
    #[inline(always)]
    pub(super) fn inverse(direction: [f64; 3]) -> [f32; 3] {
        direction.map(|d| (1.0 / if d.abs() < LEAST { LEAST.copysign(d) } else { d }) as f32)
    }

    /// Bound of the error of a ray's start in each component: the origin's place is rounded, and so is a way of the
    /// same length.
    #[inline(always)]
    pub(crate) fn lost(origin: [f64; 3]) -> f64 {
        origin[0].abs().max(origin[1].abs()).max(origin[2].abs()) * PLACED * 4.0
    }

    /// A ray that enters every box at its start.
    pub(crate) const EVERYTHING: Self = Self {
        enter: [ABOVE; 3],
        leave: [-ABOVE; 3],
        inverse: [1.0; 3],
        origin: [0.0; 3],
        direction: [1.0; 3],
        a: 3.001,
        length: 1.733,
        pad: ABOVE,
        start: 0.0,
    };

    /// The limit `t` of the ray as a t of the boxes, in f32 and counted from [`Self::start`]; rounded up.
    #[inline(always)]
    pub(crate) fn limit(&self, t: f64) -> f32 {
        let from = ((t - self.start) as f32).next_up();
        if from < f32::MAX { from } else { f32::MAX }
    }

    /// [`Self::limit`], rounded down.
    #[inline(always)]
    pub(crate) fn limit_below(&self, t: f64) -> f32 {
        ((t - self.start).min(f64::from(f32::MAX)) as f32).next_down()
    }
}

/// Factor above the rounding of |direction|^2 and of its root. Section 9.
const ROUNDED: f64 = 1.0 + 1.0 / (1u64 << 16) as f64;

/// Beyond the scene, and far from the end of f32.
const ABOVE: f32 = (1u64 << 20) as f32;

/// t at which the ray enters the cube of that half side, from outside; `None` if it certainly does not.
fn entry(origin: [f64; 3], direction: [f64; 3], side: f64) -> Option<f64> {
    let (mut first, mut last) = (0.0f64, f64::INFINITY);
    for n in 0..3 {
        let (o, d) = (origin[n], direction[n]);
        if d.abs() < LEAST {
            // Over the way to the scene such a component moves the ray by less than this.
            let moved = 8.0 * LEAST * (1.0 + origin.iter().fold(0.0f64, |far, x| far.max(x.abs())));
            if o.abs() > side + moved {
                return None;
            }
            continue;
        }
        let (a, b) = ((-side - o) / d, (side - o) / d);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    // Two quotients and differences of f64 in each.
    (first * (1.0 - 1e-14) <= last * (1.0 + 1e-14)).then_some(first * (1.0 - 1e-14))
}
