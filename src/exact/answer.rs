//! The answer in f64: from double-doubles where their errors are small enough, else from exact numbers.

use super::decide::{ExactFrame, Meeting, Root};
use super::field::FieldElement;
use super::filter::{AxesDd, Body, FilterHit, TINY};
use super::ray::RayForms;
use crate::double_double::{self as dd, Dd};
use crate::dyadic::{Dyadic, Dyadic3};

/// The nearest hit of a ray.
///
/// `t`, `distance` and `depth` are within (1/2 + 2^-10) ulp of the real numbers. The hit point is known within 2^-64 of
/// the smaller of distance and radius; `normal` (likewise relative to 1) and `position` are then rounded, each
/// component to the nearest f64. All of this holds away from the limits of f64, where results become infinite or
/// subnormal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Index of the sphere in the scene's order.
    pub id: u32,
    /// The root that counts.
    pub root: Root,
    /// The parameter, for the lecture's direction u u + v v - d w or for the caller's.
    pub t: f64,
    /// Euclidean length from the ray's origin to the hit, t |direction|.
    pub distance: f64,
    /// Distance along the view axis, t d; NaN for a ray without a camera.
    pub depth: f64,
    /// Unit, in world space, against the ray.
    pub normal: [f64; 3],
    /// The hit point in world space.
    pub position: [f64; 3],
    /// The ray only touches the sphere: its discriminant is exactly 0.
    pub tangent: bool,
}

/// The error of the hit point that [`Truth`] guarantees, before rounding: relative to the smaller of distance and
/// radius.
const CLOSE: f64 = f64::from_bits((1023 - 64) << 52);
/// Errors of directions, products and rotations in [`super::filter`] are below 2^-96; this covers a few of them.
const STEPS: f64 = f64::from_bits((1023 - 94) << 52);

/// The decided hit: sphere and root.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DecidedHit {
    pub(crate) id: u32,
    pub(crate) root: Root,
    pub(crate) tangent: bool,
}

/// The answer in double-double, if it is precise enough.
#[inline(always)]
pub(crate) fn quick(
    name: DecidedHit,
    eye: [f64; 3],
    basis: &AxesDd,
    rays: &RayForms<'_>,
    body: &Body,
    hit: &FilterHit,
) -> Option<Truth> {
    let ray = &rays.quick;
    let distance = hit.t * ray.a.sqrt();
    let from = ray.start(body.k);
    let aside = from.map_or(0.0, |[x, y]| x.hi.abs() + y.hi.abs());
    // The hit point has the error of its t; its position on the sphere also that of p. A depth close to underflow has
    // too few bits.
    let good = (hit.error + STEPS) * distance.hi <= CLOSE * distance.hi.min(body.r)
        && STEPS * (distance.hi + body.size + aside) <= CLOSE * body.r
        && (!rays.planar() || hit.t.hi * ray.dir[2].hi > TINY);
    if !good {
        return None;
    }
    // Neither array::from_fn nor map, which compilers leave as calls.
    let [u, v, w] = ray.dir;
    let mut offset = [u * hit.t, v * hit.t, w * hit.t];
    if let Some([x, y]) = from {
        (offset[0], offset[1]) = (x, y);
    }
    let (r, [p, q, s]) = (Dd::from(body.r), body.p);
    let [x, y, z] = basis.world([(offset[0] - p) / r, (offset[1] - q) / r, (offset[2] - s) / r]);
    let facing = |x: Dd| if name.root == Root::Near { x.value() } else { -x.value() };
    let normal = [facing(x), facing(y), facing(z)];
    let offset = basis.world(offset);
    let scaled = |x: Dd, k: i32| dd::ldexp(x.value(), k);
    let place = |n: usize| (offset[n].ldexp(body.k) + Dd::from(eye[n])).value();
    let position = [place(0), place(1), place(2)];
    // An offset beyond f64 may still give a finite position.
    position.iter().all(|x| x.is_finite()).then(|| Truth {
        id: name.id,
        root: name.root,
        tangent: name.tangent,
        t: scaled(hit.t, body.k - ray.k),
        distance: scaled(distance, body.k),
        depth: if rays.planar() { scaled(hit.t * ray.dir[2], body.k) } else { f64::NAN },
        normal,
        position,
    })
}

/// The answer from exact numbers, with as many bits as necessary; `None` when the line misses the sphere.
pub(crate) fn slow(
    name: DecidedHit,
    frame: &ExactFrame,
    rays: &RayForms<'_>,
    meeting: &Meeting,
    radius: f64,
) -> Option<Truth> {
    let ray = rays.exact(frame);
    let sign = if name.root == Root::Near { 1 } else { -1 };
    let radius = Dyadic::of(radius);
    // A first estimate of the distance gives the number of bits needed beyond 2^-96 for a position on a small sphere.
    let length = Path::new(frame, rays, meeting, name.root, 16)?.distance();
    let aside = |n| frame.aside(ray, n);
    let start = |n, bits| (&frame.field.value(&aside(n), bits) * rays.stretch()).over(&ray.a, bits);
    let farthest = (0..3).map(|n| start(n, 16)).filter(|x| !x.is_zero()).map(|x| x.magnitude()).max();
    let farthest = farthest.map_or(length.magnitude(), |aside| aside.max(length.magnitude()));
    let bits = 96 + (farthest - radius.magnitude()).max(0) as usize;
    let path = Path::new(frame, rays, meeting, name.root, bits)?;
    let offset: Dyadic3 = std::array::from_fn(|n| {
        let mut sum = FieldElement::ZERO;
        for (axis, along) in frame.axes.iter().zip(&ray.dir) {
            sum.add(axis.unit, &(along * &axis.vector[n]));
        }
        let along = (&frame.field.value(&sum, bits) * &path.scaled).over(&ray.a, bits);
        &along + &start(n, bits)
    });
    let normal = |n: usize| (&(&offset[n] - &meeting.p[n]) * &Dyadic::from(sign)).over(&radius, bits).to_f64();
    Some(Truth {
        id: name.id,
        root: name.root,
        tangent: name.tangent,
        t: path.t().to_f64(),
        distance: path.distance().to_f64(),
        depth: if rays.planar() { path.depth().to_f64() } else { f64::NAN },
        normal: std::array::from_fn(normal),
        position: std::array::from_fn(|n| (&frame.eye[n] + &offset[n]).to_f64()),
    })
}

/// One root along one ray: b' -+ sqrt(D') to some bits, and the lengths that follow from it.
pub(crate) struct Path<'a> {
    frame: &'a ExactFrame,
    rays: &'a RayForms<'a>,
    bits: usize,
    pub(crate) scaled: Dyadic,
}

impl<'a> Path<'a> {
    pub(crate) fn new(
        frame: &'a ExactFrame,
        rays: &'a RayForms<'a>,
        meeting: &Meeting,
        root: Root,
        bits: usize,
    ) -> Option<Self> {
        // Two to four more operations follow, each with an error below 2^-(bits+3) of the result.
        let bits = bits + 4;
        let scaled = meeting.scaled_root(&frame.field, root, bits)?;
        Some(Self { frame, rays, bits, scaled })
    }

    /// t |dir| = (b' -+ sqrt(D')) / sqrt(a')
    pub(crate) fn distance(&self) -> Dyadic {
        self.scaled.over(&self.rays.exact(self.frame).a.sqrt(self.bits), self.bits)
    }

    /// t = 2 W H alpha beta (b' -+ sqrt(D')) / a'
    pub(crate) fn t(&self) -> Dyadic {
        &self.per_length() * self.rays.stretch()
    }

    /// t d, with d and t of the scaled ray.
    fn depth(&self) -> Dyadic {
        &self.per_length() * &self.rays.exact(self.frame).dir[2]
    }

    fn per_length(&self) -> Dyadic {
        let field = &self.frame.field;
        let unit = (&field.alpha2 * &field.beta2).sqrt(self.bits);
        (&unit * &self.scaled).over(&self.rays.exact(self.frame).a, self.bits)
    }
}
