//! The certificate of a given ray in f64: bounds of t for one ray and one sphere. docs/certificate.md, section 9,
//! derives them.

use crate::double_double::{self as dd, Dd};
use crate::number::power_of_two;
use crate::scene::Ball;
use crate::view::placement::{PLACED, Placement};
use crate::view::ray::dot3;

/// Half an ulp of 1: the relative error of one rounding to nearest. Section 9.
pub(crate) const EPS: f64 = power_of_two(-53);

/// The terms of the bounds: docs/certificate.md, section 9.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GivenTerms {
    /// Errors of the components of p x d and of b = p.d, relative to |p| |d|.
    pub(crate) cross: f64,
    /// Relative errors of a R^2, of |p x d|^2 as a square of computed numbers, and of their difference.
    pub(crate) squares: f64,
    /// Error of |p|^2 - R^2, relative to |p|^2 + R^2.
    pub(crate) power: f64,
    /// The same where |p|^2 - R^2 is computed in double-double.
    pub(crate) power_dd: f64,
    /// Relative error of the last sums, products and quotients.
    pub(crate) quotient: f64,
    /// Factors of the start's blur: in the errors of p x d and b, and, times |p| |d|, in the error of |p|^2.
    pub(crate) blur: [f64; 2],
    /// Factors of the direction's tilt: times |p| |d| in the errors of p x d and b, and in the relative errors of |d|^2
    /// and of its quotients.
    pub(crate) tilt: [f64; 2],
}

/// The derived terms. Tests take others, to show that each is needed.
pub(crate) const GIVEN_TERMS: GivenTerms = GivenTerms {
    cross: 6.0 * EPS,
    squares: 8.0 * EPS,
    power: 8.0 * EPS,
    power_dd: power_of_two(-94),
    quotient: 8.0 * EPS,
    blur: [4.0, 2.0],
    tilt: [1.0, 3.0],
};

/// A power whose relative error is larger is computed again in double-double. Section 9.
const FAINT: f64 = power_of_two(-20);
/// Factor for a few roundings of the bounds themselves. Section 9.
const ROUNDED: f64 = 1.0 + power_of_two(-48);
/// Factor for products of two errors, of rays that start beside their origin. Section 10.
pub(crate) const SLACK: f64 = 1.0 + power_of_two(-7);
/// Far above the error of underflow in a product of two squares. Section 9.
const TINY: f64 = power_of_two(-900);
/// Far above the error of underflow in a length. Section 9.
pub(crate) const SHORT: f64 = power_of_two(-500);

/// A ray in the tree's unit; its direction is scaled by 2^-f, so that its largest component is in [1, 2). It starts at
/// `origin`, an exact point of the world, or beside it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CertifiedRay {
    placement: Placement,
    /// Exact, in the world's coordinates.
    pub(crate) origin: [f64; 3],
    pub(crate) direction: [f64; 3],
    /// |direction|^2
    pub(crate) a: f64,
    /// The start minus `origin`, in the tree's unit.
    offset: [f64; 3],
    /// Bound of the error of `offset`, and one ulp of it, in the tree's unit.
    pub(crate) blur: f64,
    /// Bound of the direction's error, relative to its length.
    pub(crate) tilt: f64,
    /// The caller's t is t 2^shift.
    pub(crate) shift: i32,
    /// Lower and upper bound of the caller's limit, as t of this ray.
    pub(crate) limit: [f64; 2],
}

/// Bounds of the t at which a ray hits a sphere, by the root that counts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// The exact t lies between `low` and `high`, if the ray hits at all.
    pub(crate) low: f64,
    pub(crate) high: f64,
    /// The computed t, between them.
    pub(crate) t: f64,
    /// The hit is certain.
    pub(crate) sure: bool,
    /// The ray starts outside, so that the near root counts; known if `sure`.
    pub(crate) outside: bool,
}

/// The numbers reported for a hit: t in the caller's unit, the distance in the world's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HitNumbers {
    pub(crate) t: f64,
    pub(crate) distance: f64,
    /// Unit, against the ray.
    pub(crate) normal: [f64; 3],
    /// The relative error of t and distance.
    pub(crate) error: f64,
    /// The error of the normal as an angle.
    pub(crate) tilt: f64,
}

/// The answer to whether one ray hits anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AnyHit {
    Free,
    Blocked,
    Unsure,
}

impl AnyHit {
    /// Whether a sphere blocks a ray: `Blocked` if the ray certainly hits it before the limit, `Free` if it certainly
    /// does not.
    #[inline(always)]
    pub(crate) fn of(ray: &CertifiedRay, ball: Ball) -> Self {
        match ray.intersect(ball) {
            Some(bounds) if bounds.low >= ray.limit[1] => Self::Free,
            Some(bounds) if bounds.sure && bounds.high < ray.limit[0] => Self::Blocked,
            Some(_) => Self::Unsure,
            None => Self::Free,
        }
    }
}

impl CertifiedRay {
    /// A ray with finite numbers and a direction that is not zero.
    #[inline(always)]
    pub(crate) fn new(placement: &Placement, origin: [f64; 3], direction: [f64; 3], limit: f64) -> Self {
        Self::in_unit(placement, origin, direction, limit, placement.k)
    }

    /// The same for a `direction` in a unit of 2^-k of the tree's. The caller's t counts lengths of this direction.
    #[inline(always)]
    pub(crate) fn in_unit(placement: &Placement, origin: [f64; 3], direction: [f64; 3], limit: f64, k: i32) -> Self {
        let largest = direction[0].abs().max(direction[1].abs()).max(direction[2].abs());
        let f = dd::exponent(largest);
        let direction = direction.map(|x| dd::ldexp(x, -f));
        let shift = k - f;
        Self {
            placement: *placement,
            origin,
            direction,
            a: dot3(direction, direction),
            offset: [0.0; 3],
            blur: 0.0,
            tilt: 0.0,
            shift,
            limit: scaled(limit, -shift),
        }
    }

    /// The ray that starts at `offset` from the origin, in the tree's unit. The offset has an error of at most `blur`,
    /// and the direction one of at most `tilt` of its length.
    #[inline(always)]
    pub(crate) fn offset_by(self, offset: [f64; 3], blur: f64, tilt: f64) -> Self {
        // An ulp of the offset is lost where it is subtracted from a centre's, docs/certificate.md, section 10.
        let blur = (blur + 2.0 * EPS * dot3(offset, offset).sqrt()) * SLACK + SHORT;
        Self { offset, blur, tilt: tilt * SLACK, ..self }
    }

    /// The same ray with other bounds of its limit, as t of this ray.
    pub(crate) fn ending_at(self, limit: [f64; 2]) -> Self {
        Self { limit, ..self }
    }

    /// The start minus the origin, in the tree's unit.
    pub(crate) fn offset(&self) -> [f64; 3] {
        self.offset
    }

    /// A radius in the tree's unit.
    pub(crate) fn radius(&self, radius: f64) -> f64 {
        self.placement.radius(radius)
    }

    /// The start in the tree's coordinates.
    #[inline(always)]
    pub(crate) fn placed(&self) -> [f64; 3] {
        let origin = self.placement.point(self.origin);
        std::array::from_fn(|n| origin[n] + self.offset[n])
    }

    /// The ray in the opposite direction.
    pub(crate) fn turned(self) -> Self {
        Self { direction: self.direction.map(|x| -x), ..self }
    }

    /// Extra padding of boxes for this ray, in the tree's unit: the errors of its start, of its direction over the
    /// longest way through the scene, and of its place.
    #[inline(always)]
    pub(crate) fn doubt(&self) -> f64 {
        self.blur + 8.0 * self.tilt + 4.0 * PLACED
    }

    /// From the start to a point of the world, in the tree's unit.
    #[inline(always)]
    pub(crate) fn to(&self, point: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|n| self.placement.difference(point[n], self.origin[n]) - self.offset[n])
    }

    /// Bounds of the hit of a sphere; `None` if the ray certainly misses it. Numbers beyond f64 give bounds that decide
    /// nothing.
    #[inline(always)]
    pub(crate) fn intersect(&self, ball: Ball) -> Option<Bounds> {
        self.intersect_by(&GIVEN_TERMS, ball)
    }

    /// [`Self::intersect`] with other terms, for tests.
    #[inline(always)]
    pub(crate) fn intersect_by(&self, terms: &GivenTerms, ball: Ball) -> Option<Bounds> {
        let p = self.to(ball.center);
        let radius_scaled = self.placement.radius(ball.radius);
        let d = self.direction;
        let (p2, r2) = (dot3(p, p), radius_scaled * radius_scaled);
        let b = dot3(p, d);
        let g = [p[1] * d[2] - p[2] * d[1], p[2] * d[0] - p[0] * d[2], p[0] * d[1] - p[1] * d[0]];
        let (g2, ar2) = (dot3(g, g), self.a * r2);
        let n = (p2 * self.a).sqrt();
        // |d| is at most 4, and at least 1, so that |p| is at most n.
        let e = terms.cross * (n + SHORT) + (terms.tilt[0] * self.tilt * n + terms.blur[0] * self.blur);
        let disc = ar2 - g2;
        let error =
            ((2.0 * g2.sqrt() + e) * e + (terms.squares + terms.tilt[1] * self.tilt) * (ar2 + g2) + TINY) * ROUNDED;
        let (rounding, blurred) = (terms.power * (p2 + r2) + TINY, terms.blur[1] * self.blur * (n + self.blur));
        let (mut power, mut power_error) = (p2 - r2, rounding + blurred);
        if power > -power_error && (b < -e || disc < -error) {
            // Outside or on the surface. Inside, D is at least b^2, and b may have any sign.
            if power > power_error {
                return None;
            }
            (power, power_error) = self.power(terms, ball, blurred);
            if power > power_error {
                return None;
            }
        } else if power.abs() * FAINT < rounding {
            (power, power_error) = self.power(terms, ball, blurred);
        }
        let root = |x: f64| if x > 0.0 { x.sqrt() } else { 0.0 };
        let (root_low, root_mid, root_high) = (root(disc - error), root(disc), root(disc + error));
        // The quotients and products below take at most four roundings.
        let relative = terms.quotient + terms.tilt[1] * self.tilt;
        let (less, more) = (1.0 - relative, 1.0 + relative);
        let outside = power > power_error;
        let (low, t, high) = if outside {
            let q_low = if b > e { b - e } else { 0.0 } + root_low;
            let low = (power - power_error) / (b + e + root_high);
            (low, power / (b + root_mid), (power + power_error) / q_low)
        } else if power < -power_error {
            if b >= 0.0 {
                let least = (b - e + root_low) / self.a;
                (if least > 0.0 { least } else { 0.0 }, (b + root_mid) / self.a, (b + e + root_high) / self.a)
            } else {
                // b itself may be above zero by e.
                let q_low = root_low - b - e;
                let high = if q_low > 0.0 { (-power + power_error) / q_low } else { f64::INFINITY };
                ((-power - power_error) / (root_high + e - b), -power / (root_mid - b), high)
            }
        } else {
            return Some(Bounds::UNKNOWN);
        };
        let (low, high) = (low * less, high * more);
        if !(low >= 0.0 && high <= f64::MAX) {
            return Some(Bounds { low: if low >= 0.0 { low } else { 0.0 }, ..Bounds::UNKNOWN });
        }
        let sure = !outside || (disc > error && b > e);
        Some(Bounds { low, high, t: t.max(low).min(high), sure, outside })
    }

    /// |p|^2 - R^2 in double-double, and its error.
    #[cold]
    fn power(&self, terms: &GivenTerms, ball: Ball, blurred: f64) -> (f64, f64) {
        let p: [Dd; 3] = std::array::from_fn(|n| {
            self.placement.exact_difference(ball.center[n], self.origin[n]) - Dd::from(self.offset[n])
        });
        let radius = self.placement.radius(ball.radius);
        let (p2, r2) = (dd::dot(p, p), Dd::product(radius, radius));
        let power = (p2 - r2).value();
        (power, (terms.power_dd * (p2.hi + r2.hi) + EPS * power.abs() + blurred + TINY) * ROUNDED)
    }

    /// The numbers reported for the hit of a sphere, from the bounds of its t.
    #[inline(always)]
    pub(crate) fn numbers(&self, ball: Ball, bounds: &Bounds) -> HitNumbers {
        let length = self.a.sqrt();
        let r = self.placement.radius(ball.radius);
        let p = self.to(ball.center);
        let outward: [f64; 3] = std::array::from_fn(|n| bounds.t * self.direction[n] - p[n]);
        let size = dot3(outward, outward).sqrt();
        let sign = if bounds.outside { 1.0 / size } else { -1.0 / size };
        let along = bounds.t * length;
        let width = bounds.high - bounds.low;
        // The point is off by its t and by roundings of t d and p; scaling to unit length at most doubles the angle.
        let shift = width * length + 8.0 * EPS * (along + dot3(p, p).sqrt());
        self.numbers_at([bounds.low, bounds.t, bounds.high], (outward.map(|x| x * sign), 2.0 * shift / r))
    }

    /// The numbers reported for a hit: from t and its bounds, the normal and its error as an angle.
    #[inline(always)]
    pub(crate) fn numbers_at(&self, [low, t, high]: [f64; 3], (normal, tilt): ([f64; 3], f64)) -> HitNumbers {
        HitNumbers {
            t: dd::ldexp(t, self.shift),
            distance: dd::ldexp(t * self.a.sqrt(), self.placement.k),
            normal,
            error: (high - low) / low + GIVEN_TERMS.quotient,
            tilt,
        }
    }
}

impl Bounds {
    /// Bounds that decide nothing: a hit at any t, or none.
    pub(super) const UNKNOWN: Self = Self { low: 0.0, high: f64::INFINITY, t: 0.0, sure: false, outside: false };
}

/// `limit` 2^k between two numbers, which differ where f64 cannot hold it.
#[inline(always)]
fn scaled(limit: f64, k: i32) -> [f64; 2] {
    let there = dd::ldexp(limit, k);
    match there {
        _ if limit <= 0.0 => [0.0; 2],
        _ if limit == f64::INFINITY => [f64::INFINITY; 2],
        f64::INFINITY => [f64::MAX, f64::INFINITY],
        _ if there < SHORT => [0.0, SHORT],
        _ => [there; 2],
    }
}
