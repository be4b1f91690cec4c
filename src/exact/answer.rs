//! The answer in f64: from double-doubles where their errors are small enough, else from exact numbers.

use super::cut::Crossing;
use super::decide::{ExactFrame, Meeting, Root};
use super::field::FieldElement;
use super::filter::{Body, ExactCamera, FilterHit, FilterRay, TINY, splat};
use super::ray::RayForms;
use crate::double_double::Dd;
use crate::dyadic::{Dyadic, Dyadic3};
use crate::number::vector::Vector;
use crate::number::{Fused, Mask};

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
    /// Distance along the view axis, t d; for a curved lens, whose t it takes in f64, below 0 behind the eye. NaN for a ray without a
    /// camera.
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

/// The answers to a ray, or to a vector of them, in double-double.
pub(crate) struct Quick<T: Fused = f64> {
    /// Whether the answer is within the errors of [`Truth`], for each ray.
    pub(crate) good: T::Mask,
    t: T,
    distance: T,
    /// NaN for rays without a camera.
    depth: T,
    normal: [T; 3],
    position: [T; 3],
}

impl<T: Fused> Quick<T> {
    /// The answer of a hit at a root; `is_planar` where the third component of the direction is along the view axis.
    #[inline(always)]
    pub(crate) fn new(
        root: Root,
        camera: &ExactCamera,
        ray: &FilterRay<T>,
        is_planar: bool,
        body: &Body,
        hit: &FilterHit<T>,
    ) -> Self {
        let ExactCamera { eye, basis } = camera;
        let distance = hit.t * ray.a.sqrt();
        let from = ray.start(body.k);
        let start_size = if let Some([x, y]) = from { x.hi.abs() + y.hi.abs() } else { T::ZERO };
        let (size, radius, steps, close) = (T::splat(body.size), T::splat(body.r), T::splat(STEPS), T::splat(CLOSE));
        // The hit point has the error of its t; its position on the sphere also the error of p. A depth close to underflow has
        // too few bits.
        let nearest = distance.hi.less(radius).pick(distance.hi, radius);
        let mut good = ((hit.error + steps) * distance.hi).at_most(close * nearest)
            & (steps * (distance.hi + size + start_size)).at_most(close * radius);
        let depth = hit.t * ray.dir[2];
        if is_planar {
            good = good & T::splat(TINY).less(hit.t.hi * ray.dir[2].hi);
        }
        // Neither closures, nor array::from_fn, nor map, which compilers leave as calls.
        let [u, v, w] = ray.dir;
        let mut offset = [u * hit.t, v * hit.t, w * hit.t];
        if let Some([x, y]) = from {
            (offset[0], offset[1]) = (x, y);
        }
        let (r, [p, q, s]) = (Dd::from(radius), splat(body.p));
        let [x, y, z] = basis.world([(offset[0] - p) / r, (offset[1] - q) / r, (offset[2] - s) / r]);
        let mut normal = [x.value(), y.value(), z.value()];
        if root == Root::Far {
            normal = [-normal[0], -normal[1], -normal[2]];
        }
        let offset = basis.world(offset);
        let place = [
            offset[0].ldexp(body.k) + Dd::from(T::splat(eye[0])),
            offset[1].ldexp(body.k) + Dd::from(T::splat(eye[1])),
            offset[2].ldexp(body.k) + Dd::from(T::splat(eye[2])),
        ];
        Self {
            good,
            t: hit.t.value().ldexp(body.k - ray.k),
            distance: distance.value().ldexp(body.k),
            depth: if is_planar { depth.value().ldexp(body.k) } else { T::splat(f64::NAN) },
            normal,
            position: [place[0].value(), place[1].value(), place[2].value()],
        }
    }
}

impl Quick {
    /// The answer, if it is precise enough.
    #[inline(always)]
    pub(crate) fn truth(self, name: DecidedHit) -> Option<Truth> {
        let Self { good, t, distance, depth, normal, position } = self;
        let DecidedHit { id, root, tangent } = name;
        // An offset beyond f64 may still give a finite position.
        let is_finite = position[0].is_finite() && position[1].is_finite() && position[2].is_finite();
        (good && is_finite).then_some(Truth { id, root, tangent, t, distance, depth, normal, position })
    }
}

impl Quick<Vector<f64>> {
    /// The answer of a lane.
    #[inline(always)]
    pub(crate) fn lane(&self, l: usize) -> Quick {
        let of = |v: &[Vector<f64>; 3]| [v[0].0[l], v[1].0[l], v[2].0[l]];
        Quick {
            good: self.good.0[l] != 0,
            t: self.t.0[l],
            distance: self.distance.0[l],
            depth: self.depth.0[l],
            normal: of(&self.normal),
            position: of(&self.position),
        }
    }
}

/// The place of a hit in exact numbers.
pub(crate) enum Place<'a> {
    /// A root of the sphere.
    Root(&'a Meeting),
    /// A plane that cuts the sphere, with its normal of length 1.
    Face(&'a Crossing, [f64; 3]),
}

/// The answer from exact numbers, with as many bits as necessary; `None` when the line misses the sphere.
pub(crate) fn slow(
    name: DecidedHit,
    frame: &ExactFrame,
    rays: &RayForms<'_>,
    place: &Place<'_>,
    radius: f64,
) -> Option<Truth> {
    let ray = rays.exact(frame);
    let sign = if name.root == Root::Near { 1 } else { -1 };
    let radius = Dyadic::of(radius);
    let path_of = |bits| match place {
        Place::Root(meeting) => Path::new(frame, rays, meeting, name.root, bits),
        Place::Face(crossing, _) => Some(Path::to_face(frame, rays, crossing, bits)),
    };
    // A first estimate of the distance gives the number of bits needed beyond 2^-96 for a position on a small sphere.
    let length = path_of(16)?.distance();
    let origin_offset = |n| frame.origin_offset(ray, n);
    let start = |n, bits| (&frame.field.value(&origin_offset(n), bits) * rays.stretch()).over(&ray.a, bits);
    let farthest = (0..3).map(|n| start(n, 16)).filter(|x| !x.is_zero()).map(|x| x.magnitude()).max();
    let farthest = farthest.map_or(length.magnitude(), |exponent| exponent.max(length.magnitude()));
    let bits = 96 + (farthest - radius.magnitude()).max(0) as usize;
    let path = path_of(bits)?;
    let offset: Dyadic3 = std::array::from_fn(|n| {
        let mut sum = FieldElement::ZERO;
        for (axis, along) in frame.axes.iter().zip(&ray.dir) {
            sum.add(axis.unit, &(along * &axis.vector[n]));
        }
        let along = (&frame.field.value(&sum, bits) * &path.scaled).over(&ray.a, bits);
        &along + &start(n, bits)
    });
    let normal = |n: usize| match place {
        Place::Root(meeting) => (&(&offset[n] - &meeting.p[n]) * &Dyadic::from(sign)).over(&radius, bits).to_f64(),
        Place::Face(_, normal) => normal[n],
    };
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

    /// The way to a plane.
    fn to_face(frame: &'a ExactFrame, rays: &'a RayForms<'a>, crossing: &Crossing, bits: usize) -> Self {
        let bits = bits + 4;
        Self { frame, rays, bits, scaled: crossing.scaled(&frame.field, rays.exact(frame), bits) }
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
