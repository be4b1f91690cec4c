//! Exact decisions whether a sphere lies between a hit and a light.
//!
//! A ray of the frame meets sphere h at e + offset with a' offset = q (b' -+ s) + aside, s = sqrt(D'): its coordinates are
//! x + y s with x and y of the frame's field. With l from the hit to the light (l = L - hit, or a direction) and, for each
//! sphere of centre c and radius r, p = c - hit,
//!
//! ```text
//! b = l.p      power = |p|^2 - r^2      D = b^2 - |l|^2 power      beyond = power - 2 b + |l|^2, the light's own power
//! ```
//!
//! the segment is blocked where some sphere has a root with 0 < t < 1, the ray to infinity where one has 0 < t. Which
//! it is follows from the signs of these numbers, without a second root: each is x + y s again. The sphere of the hit has
//! the power 0 by definition, so that no epsilon moves the ray off its own surface.
//!
//! The ray passes a plane N.p = D at num/den with num = D - N.hit and den = N.l, of the same kind. Whether it does so before a root t of
//! a sphere follows from the signs of |l|^2 num^2 - 2 b num den + power den^2 and |l|^2 num - b den.

use super::cut::{Crossing, ExactPlane};
use super::decide::{ExactFrame, ExactRay, Meeting, Root};
use super::field::{Field, FieldElement, resolve};
use crate::dyadic::{self, Dyadic, Dyadic3};
use crate::scene::{Ball, Solid};
use std::cmp::Ordering;

/// x + y s
#[derive(Debug, Clone)]
struct Tower {
    x: FieldElement,
    y: FieldElement,
}

/// The frame's field with s adjoined.
struct TowerField<'a> {
    field: &'a Field,
    /// s^2
    square: &'a FieldElement,
}

impl Tower {
    const ZERO: Self = Self { x: FieldElement::ZERO, y: FieldElement::ZERO };

    fn of(x: FieldElement) -> Self {
        Self { x, y: FieldElement::ZERO }
    }

    fn scaled(&self, by: &Dyadic) -> Self {
        Self { x: self.x.scaled(by), y: self.y.scaled(by) }
    }

    fn plus(&self, b: &Self) -> Self {
        Self { x: self.x.plus(&b.x), y: self.y.plus(&b.y) }
    }

    fn minus(&self, b: &Self) -> Self {
        Self { x: self.x.minus(&b.x), y: self.y.minus(&b.y) }
    }

    fn twice(self) -> Self {
        Self { x: self.x.ldexp(1), y: self.y.ldexp(1) }
    }
}

impl TowerField<'_> {
    fn times(&self, a: &Tower, b: &Tower) -> Tower {
        let times = |a: &FieldElement, b: &FieldElement| self.field.times(a, b);
        let ss = times(&times(&a.y, &b.y), self.square);
        Tower { x: times(&a.x, &b.x).plus(&ss), y: times(&a.x, &b.y).plus(&times(&a.y, &b.x)) }
    }

    fn dot(&self, a: &[Tower; 3], b: &[Tower; 3]) -> Tower {
        let [x, y, z] = std::array::from_fn(|n| self.times(&a[n], &b[n]));
        x.plus(&y).plus(&z)
    }

    /// The exact sign; s may be 0.
    fn sign(&self, a: &Tower) -> Ordering {
        let field = self.field;
        let y = match field.sign(self.square) {
            Ordering::Greater => field.sign(&a.y),
            _ => Ordering::Equal,
        };
        resolve(field.sign(&a.x), y, || {
            let squares = field.times(&a.x, &a.x).minus(&field.times(&field.times(&a.y, &a.y), self.square));
            field.sign(&squares)
        })
    }
}

/// The position of a light, or the direction to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Toward {
    /// A point. Spheres behind it hide nothing.
    Point([f64; 3]),
    /// A point as the exact sum of two vectors, which f64 need not hold. Spheres behind it hide nothing.
    OffsetPoint {
        /// A point.
        center: [f64; 3],
        /// From `center` to the light.
        offset: [f64; 3],
    },
    /// A direction of any length but zero, without end.
    Direction([f64; 3]),
    /// A direction, up to `reach` times its length, which is finite: a hit at t < reach counts.
    Within {
        /// Of any length but zero.
        direction: [f64; 3],
        /// In units of `direction`; positive.
        reach: f64,
    },
}

/// A hit from which rays leave to lights.
pub(super) struct HitPoint<'a> {
    field: TowerField<'a>,
    eye: &'a Dyadic3,
    /// s (hit - e)
    offset: [Tower; 3],
    /// s > 0: a', at a face times the denominator of its crossing.
    scale: FieldElement,
    root: Root,
    own: Solid,
    /// The planes that cut spheres, and the plane of the hit where it is on a face.
    planes: &'a [ExactPlane],
    face: Option<&'a ExactPlane>,
}

/// The sphere and the place of a hit.
pub(super) struct HitOf<'a> {
    pub(super) own: Solid,
    pub(super) root: Root,
    pub(super) meeting: &'a Meeting,
    /// The plane of a face.
    pub(super) entry: Option<&'a Crossing>,
}

/// The place where a ray to a light passes a plane, ahead: num/den with den > 0.
struct Pass {
    num: Tower,
    den: Tower,
}

impl Pass {
    fn is_before(&self, field: &TowerField<'_>, other: &Self) -> bool {
        let gap = field.times(&self.num, &other.den).minus(&field.times(&other.num, &self.den));
        field.sign(&gap) == Ordering::Less
    }
}

/// The part of a ray to a light that planes keep: behind the last entry and before the first exit.
#[derive(Default)]
struct Kept {
    entry: Option<Pass>,
    exit: Option<Pass>,
    is_empty: bool,
}

/// l.p and |p|^2 - r^2 of a sphere.
struct Place {
    b: Tower,
    power: Tower,
}

impl<'a> HitPoint<'a> {
    /// The hit of a ray; `stretch` is the factor from the real direction to the exact one.
    pub(super) fn new(
        frame: &'a ExactFrame,
        ray: &'a ExactRay,
        stretch: &Dyadic,
        planes: &'a [ExactPlane],
        HitOf { own, root, meeting, entry }: HitOf<'a>,
    ) -> Self {
        let field = TowerField { field: &frame.field, square: &meeting.disc };
        let mut scale = FieldElement::ZERO;
        scale.add(super::field::FieldBasis::One, &ray.a);
        if let Some(entry) = entry {
            // The ray enters: the denominator is below 0.
            scale = FieldElement::ZERO.minus(&entry.den.scaled(&ray.a));
        }
        let offset = std::array::from_fn(|n| {
            let mut q = FieldElement::ZERO;
            for (axis, along) in frame.axes.iter().zip(&ray.dir) {
                q.add(axis.unit, &(along * &axis.vector[n]));
            }
            let origin = frame.origin_offset(ray, n).scaled(stretch);
            if let Some(Crossing { num, den, .. }) = entry {
                let along = frame.field.times(&q, &num.scaled(&ray.a)).plus(&frame.field.times(den, &origin));
                return Tower::of(FieldElement::ZERO.minus(&along));
            }
            let y = if root == Root::Near { FieldElement::ZERO.minus(&q) } else { q.clone() };
            Tower { x: frame.field.times(&q, &meeting.b).plus(&origin), y }
        });
        let face = entry.map(|entry| &planes[entry.plane]);
        Self { field, eye: &frame.eye, offset, scale, root, own, planes, face }
    }

    /// s (c - hit)
    fn to(&self, point: &Dyadic3) -> [Tower; 3] {
        std::array::from_fn(|n| Tower::of(self.scale.scaled(&(&point[n] - &self.eye[n]))).minus(&self.offset[n]))
    }

    /// s l, turned to the side of the normal if `is_turned`.
    pub(super) fn toward(&self, light: Toward, is_turned: bool) -> LightVector {
        let scaled = |direction: [f64; 3], by: &Dyadic| {
            let direction = dyadic::vector(direction);
            std::array::from_fn(|n| Tower::of(self.scale.scaled(&(&direction[n] * by))))
        };
        let (l, infinite) = match light {
            Toward::Point(point) => (self.to(&dyadic::vector(point)), false),
            Toward::OffsetPoint { center, offset } => {
                let [center, offset] = [center, offset].map(dyadic::vector);
                (self.to(&std::array::from_fn(|n| &center[n] + &offset[n])), false)
            }
            Toward::Direction(direction) => (scaled(direction, &Dyadic::from(1)), true),
            Toward::Within { direction, reach } => (scaled(direction, &Dyadic::of(reach)), false),
        };
        let length2 = self.field.dot(&l, &l);
        let mut light = LightVector { l, length2, infinite, kept: Kept::default() };
        let behind = if self.root == Root::Far { Ordering::Less } else { Ordering::Greater };
        if is_turned && self.inward(&light) == behind {
            light.l = light.l.map(|l| Tower::ZERO.minus(&l));
        }
        light.kept = self.kept(&light);
        light
    }

    /// The sign of the cosine between the way to the light and that into the sphere of the hit.
    fn inward(&self, light: &LightVector) -> Ordering {
        match self.face {
            Some(face) => self.field.sign(&self.across(face, light)).reverse(),
            None => self.field.sign(&self.field.dot(&light.l, &self.to(&dyadic::vector(self.own.ball.center)))),
        }
    }

    /// s N.l
    fn across(&self, plane: &ExactPlane, light: &LightVector) -> Tower {
        plane.normal.iter().zip(&light.l).fold(Tower::ZERO, |sum, (normal, l)| sum.plus(&l.scaled(normal)))
    }

    /// The part of a ray to a light that planes keep.
    fn kept(&self, light: &LightVector) -> Kept {
        let (field, mut kept) = (&self.field, Kept::default());
        for plane in self.planes {
            let ExactPlane { normal, distance } = plane;
            let beyond = normal.iter().zip(&self.offset).fold(Tower::ZERO, |sum, (n, x)| sum.plus(&x.scaled(n)));
            let gap = distance - &dyadic::dot(normal, self.eye);
            let (num, den) = (Tower::of(self.scale.scaled(&gap)).minus(&beyond), self.across(plane, light));
            match (field.sign(&den), field.sign(&num)) {
                (Ordering::Greater, Ordering::Greater) => {
                    let pass = Pass { num, den };
                    if kept.exit.as_ref().is_none_or(|exit| pass.is_before(field, exit)) {
                        kept.exit = Some(pass);
                    }
                }
                (Ordering::Greater, _) | (Ordering::Equal, Ordering::Less) => kept.is_empty = true,
                (Ordering::Less, Ordering::Less) => {
                    let [num, den] = [num, den].map(|x| Tower::ZERO.minus(&x));
                    let pass = Pass { num, den };
                    if kept.entry.as_ref().is_none_or(|entry| entry.is_before(field, &pass)) {
                        kept.entry = Some(pass);
                    }
                }
                _ => {}
            }
        }
        if let Some(entry) = &kept.entry {
            let ends = light.infinite || field.sign(&entry.num.minus(&entry.den)) == Ordering::Less;
            kept.is_empty |= !ends || kept.exit.as_ref().is_some_and(|exit| !entry.is_before(field, exit));
        }
        kept
    }

    /// Whether the sphere of the hit hides the light.
    pub(super) fn hides_itself(&self, light: &LightVector) -> bool {
        self.is_hidden_from_surface(light, self.own.is_cut)
    }

    /// Whether the sphere of the hit hides the light, or one that is equal to it, cut or whole.
    fn is_hidden_from_surface(&self, light: &LightVector, is_cut: bool) -> bool {
        if self.field.sign(&light.length2) == Ordering::Equal {
            return false;
        }
        match self.root {
            // The light is behind the surface, or its ray grazes it. A face looks into what its plane removes.
            Root::Near | Root::Face => self.inward(light) != Ordering::Less,
            Root::Far => {
                let b = self.field.dot(&light.l, &self.to(&dyadic::vector(self.own.ball.center)));
                // The power of the hit is 0.
                let ends_beyond = |pass: &Pass| {
                    let far = self.field.times(&light.length2, &pass.num);
                    let chord = self.field.times(&b, &pass.den).twice();
                    self.field.sign(&far.minus(&chord)) == Ordering::Greater
                };
                let beyond = || self.field.sign(&light.length2.minus(&b.clone().twice())) == Ordering::Greater;
                let is_kept = || !light.kept.is_empty && light.kept.exit.as_ref().is_none_or(ends_beyond);
                (light.infinite || beyond()) && (!is_cut || is_kept())
            }
        }
    }

    /// Whether the hit is outside of a sphere.
    fn is_outside(&self, ball: Ball) -> bool {
        if ball == self.own.ball {
            return false;
        }
        let p = self.to(&dyadic::vector(ball.center));
        self.field.sign(&self.power(&p, ball.radius)) == Ordering::Greater
    }

    /// s^2 (|p|^2 - r^2) from s p
    fn power(&self, p: &[Tower; 3], radius: f64) -> Tower {
        let r = self.scale.scaled(&Dyadic::of(radius));
        self.field.dot(p, p).minus(&Tower::of(self.field.field.times(&r, &r)))
    }

    /// Whether another sphere hides the light.
    pub(super) fn is_hidden_by(&self, light: &LightVector, Solid { ball, is_cut }: Solid) -> bool {
        if ball == self.own.ball && (self.root != Root::Face || is_cut) {
            return self.is_hidden_from_surface(light, is_cut);
        }
        if self.field.sign(&light.length2) == Ordering::Equal || is_cut && light.kept.is_empty {
            return false;
        }
        let p = self.to(&dyadic::vector(ball.center));
        let place = Place { b: self.field.dot(&light.l, &p), power: self.power(&p, ball.radius) };
        if !is_cut || light.kept.entry.is_none() {
            return self.is_hidden_by_whole(light, &place) && (!is_cut || self.is_met_before_exit(light, &place));
        }
        self.is_entered(light, &place) && self.is_met_before_exit(light, &place)
    }

    fn is_hidden_by_whole(&self, light: &LightVector, Place { b, power }: &Place) -> bool {
        let field = &self.field;
        let beyond = || field.sign(&power.minus(&b.clone().twice()).plus(&light.length2));
        match field.sign(power) {
            Ordering::Less => light.infinite || beyond() == Ordering::Greater,
            _ if field.sign(b) != Ordering::Greater => false,
            Ordering::Equal => light.infinite || field.sign(&b.clone().twice().minus(&light.length2)) == Ordering::Less,
            Ordering::Greater => {
                let disc = field.times(b, b).minus(&field.times(&light.length2, power));
                match (field.sign(&disc), light.infinite) {
                    (Ordering::Less, _) => false,
                    (_, true) => true,
                    (disc, false) => match field.sign(&b.minus(&light.length2)) {
                        Ordering::Less => true,
                        Ordering::Equal if disc == Ordering::Greater => true,
                        _ => beyond() == Ordering::Less,
                    },
                }
            }
        }
    }

    /// The signs of |l|^2 num^2 - 2 b num den + power den^2, below 0 between the roots of a sphere, and of |l|^2 num - b den, below 0 before
    /// the middle of these.
    fn signs_at_plane(
        &self,
        light: &LightVector,
        Place { b, power }: &Place,
        Pass { num, den }: &Pass,
    ) -> [Ordering; 2] {
        let field = &self.field;
        let (far, mid) = (field.times(&light.length2, num), field.times(b, den));
        let first = field.times(&far.minus(&mid.clone().twice()), num);
        let square = first.plus(&field.times(&field.times(power, den), den));
        [field.sign(&square), field.sign(&far.minus(&mid))]
    }

    /// Whether the ray, which begins in what planes keep or enters it, meets a sphere before it leaves that: at the near root, from inside
    /// at the far one.
    fn is_met_before_exit(&self, light: &LightVector, place: &Place) -> bool {
        let begins_inside = || light.kept.entry.is_none() && self.field.sign(&place.power) != Ordering::Greater;
        light.kept.exit.as_ref().is_none_or(|exit| match self.signs_at_plane(light, place, exit) {
            [side, _] if begins_inside() => side == Ordering::Greater,
            [side, middle] => side == Ordering::Less || middle == Ordering::Greater,
        })
    }

    /// Whether the ray, which enters what planes keep, meets a sphere behind the entry, or is inside of it there.
    fn is_entered(&self, light: &LightVector, place: &Place) -> bool {
        let Place { b, power } = place;
        let field = &self.field;
        let disc = field.times(b, b).minus(&field.times(&light.length2, power));
        let begins_before_end = || {
            let side = field.sign(&power.minus(&b.clone().twice()).plus(&light.length2));
            light.infinite || side == Ordering::Less || field.sign(&light.length2.minus(b)) == Ordering::Greater
        };
        let is_behind = |entry: &Pass| {
            let [side, middle] = self.signs_at_plane(light, place, entry);
            side == Ordering::Less || middle == Ordering::Less
        };
        field.sign(&disc) != Ordering::Less && light.kept.entry.as_ref().is_some_and(is_behind) && begins_before_end()
    }
}

/// A question about a hit and a light.
#[derive(Debug, Clone)]
pub(crate) enum LightQuestion {
    /// Whether the light is hidden by the hit's own sphere or by some others.
    Hidden {
        toward: Toward,
        /// The direction is turned to the side of the normal against the viewing ray.
        turned: bool,
        /// The others.
        among: Vec<Solid>,
    },
    /// Whether the hit is outside of a sphere that shines, neither in it nor on it.
    Outside(Ball),
}

impl LightQuestion {
    pub(super) fn answer(&self, hit: &HitPoint<'_>) -> bool {
        let (toward, turned, among) = match self {
            Self::Hidden { toward, turned, among } => (*toward, *turned, among),
            Self::Outside(ball) => return hit.is_outside(*ball),
        };
        let light = hit.toward(toward, turned);
        hit.hides_itself(&light) || among.iter().any(|solid| hit.is_hidden_by(&light, *solid))
    }
}

/// A light seen from a hit.
pub(super) struct LightVector {
    /// s l
    l: [Tower; 3],
    /// |s l|^2
    length2: Tower,
    infinite: bool,
    kept: Kept,
}
