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

use super::decide::{ExactFrame, ExactRay, Meeting, Root};
use super::field::{Field, FieldElement, resolve};
use crate::dyadic::{self, Dyadic, Dyadic3};
use crate::scene::Ball;
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
    fn of(x: Dyadic) -> Self {
        let mut number = FieldElement::ZERO;
        number.add(super::field::FieldBasis::One, &x);
        Self { x: number, y: FieldElement::ZERO }
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
    /// a' (hit - e)
    offset: [Tower; 3],
    /// a'
    a: &'a Dyadic,
    root: Root,
    ball: Ball,
}

impl<'a> HitPoint<'a> {
    /// The hit of a ray and the sphere of `meeting` by `root`; `stretch` is the factor from the real direction to the
    /// exact one.
    pub(super) fn new(
        frame: &'a ExactFrame,
        ray: &'a ExactRay,
        stretch: &Dyadic,
        meeting: &'a Meeting,
        root: Root,
        ball: Ball,
    ) -> Self {
        let field = TowerField { field: &frame.field, square: &meeting.disc };
        let offset = std::array::from_fn(|n| {
            let mut q = FieldElement::ZERO;
            for (axis, along) in frame.axes.iter().zip(&ray.dir) {
                q.add(axis.unit, &(along * &axis.vector[n]));
            }
            let origin = FieldElement(frame.origin_offset(ray, n).0.map(|x| &x * stretch));
            let y = if root == Root::Near { FieldElement::ZERO.minus(&q) } else { q.clone() };
            Tower { x: frame.field.times(&q, &meeting.b).plus(&origin), y }
        });
        Self { field, eye: &frame.eye, offset, a: &ray.a, root, ball }
    }

    /// a' (c - hit)
    fn to(&self, point: &Dyadic3) -> [Tower; 3] {
        std::array::from_fn(|n| Tower::of(self.a * &(&point[n] - &self.eye[n])).minus(&self.offset[n]))
    }

    /// a' l, and whether the light is at infinity.
    pub(super) fn toward(&self, light: Toward) -> LightVector {
        let scaled = |direction: [f64; 3], by: &Dyadic| {
            let direction = dyadic::vector(direction);
            std::array::from_fn(|n| Tower::of(&(self.a * &direction[n]) * by))
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
        LightVector { l, length2, infinite }
    }

    /// Whether the sphere of the hit hides the light.
    pub(super) fn hides_itself(&self, light: &LightVector) -> bool {
        if self.field.sign(&light.length2) == Ordering::Equal {
            return false;
        }
        let b = self.field.dot(&light.l, &self.to(&dyadic::vector(self.ball.center)));
        match self.root {
            // The light is behind the surface, or its ray grazes it.
            Root::Near => self.field.sign(&b) != Ordering::Less,
            // A face looks into what its plane removes.
            Root::Face => false,
            Root::Far if light.infinite => true,
            // The power of the hit is 0.
            Root::Far => self.field.sign(&light.length2.minus(&b.twice())) == Ordering::Greater,
        }
    }

    /// Whether the light is on the side of the surface that the camera does not see.
    fn is_behind(&self, light: &LightVector) -> bool {
        let b = self.field.dot(&light.l, &self.to(&dyadic::vector(self.ball.center)));
        self.field.sign(&b) == if self.root == Root::Near { Ordering::Greater } else { Ordering::Less }
    }

    /// Whether the hit is outside of a sphere.
    fn is_outside(&self, ball: Ball) -> bool {
        if ball == self.ball {
            return false;
        }
        let p = self.to(&dyadic::vector(ball.center));
        self.field.sign(&self.power(&p, ball.radius)) == Ordering::Greater
    }

    /// a'^2 (|p|^2 - r^2) from a' p
    fn power(&self, p: &[Tower; 3], radius: f64) -> Tower {
        let r = self.a * &Dyadic::of(radius);
        self.field.dot(p, p).minus(&Tower::of(r.square()))
    }

    /// Whether another sphere hides the light.
    pub(super) fn is_hidden_by(&self, light: &LightVector, ball: Ball) -> bool {
        let field = &self.field;
        if ball == self.ball {
            return self.hides_itself(light);
        }
        if field.sign(&light.length2) == Ordering::Equal {
            return false;
        }
        let p = self.to(&dyadic::vector(ball.center));
        let power = self.power(&p, ball.radius);
        let b = field.dot(&light.l, &p);
        let beyond = || field.sign(&power.minus(&b.clone().twice()).plus(&light.length2));
        match field.sign(&power) {
            Ordering::Less => light.infinite || beyond() == Ordering::Greater,
            _ if field.sign(&b) != Ordering::Greater => false,
            Ordering::Equal => light.infinite || field.sign(&b.twice().minus(&light.length2)) == Ordering::Less,
            Ordering::Greater => {
                let disc = field.times(&b, &b).minus(&field.times(&light.length2, &power));
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
        among: Vec<Ball>,
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
        let mut light = hit.toward(toward);
        if turned && hit.is_behind(&light) {
            light.l = light.l.map(|l| Tower::of(Dyadic::ZERO).minus(&l));
        }
        hit.hides_itself(&light) || among.iter().any(|ball| hit.is_hidden_by(&light, *ball))
    }
}

/// A light seen from a hit.
pub(super) struct LightVector {
    /// a' l
    l: [Tower; 3],
    /// |a' l|^2
    length2: Tower,
    infinite: bool,
}
