//! Decisions that double-double arithmetic can make with certainty; exact signs are needed only for close calls.
//!
//! Every sphere is moved into the frame (p = c - e along right, up, forward) and scaled by a power of two 2^-k that
//! brings the larger of |p|_inf and r into [1, 2); the lens is scaled likewise. With N = |dir||p| and the relative
//! errors of [`crate::double_double`] (at most 2^-100 per operation), for `dir` within 2^-99 of itself:
//!
//! * p is within 2^-97 |p|: a rotation is three products and two sums with an axis good to 2^-104, in each of three
//!   components (sqrt(3) (2^-99.9 + 2^-99) |p|).
//! * dir x p is within [`CROSS`] N: 2^-97 and 2^-99 from p and dir, and sqrt(2) 2^-99 from two products and a sum
//!   (the nine |dir_i||p_j| with i != j square to at most |dir|^2 |p|^2, each taken twice).
//! * b = dir.p is within [`CROSS`] N: the same inputs, and 2^-98 from three products and two sums.
//! * D = a r^2 - |dir x p|^2 is within 2 |dir x p| e + e^2 + [`SQUARES`] (a r^2 + |dir x p|^2), e = CROSS N:
//!   a r^2 and the square of the computed vector err by at most 2^-97 and 2^-98, the difference by 2^-100.
//!
//! A parallel ray has the direction (0, 0, 1) and an origin q in the plane of the eye: two components, products and
//! quotients within 2^-99 of themselves. Of the two components of p - q and of b = p_z
//!
//! * each is within e = [`CROSS`] (|p| + |q|_1), and so is their length l: 2^-97 |p| and 2^-99 |q| from p and q, and 2^-100
//!   of both from the difference.
//! * D = r^2 - l^2 is within 2 l e + e^2 + [`SQUARES`] (r^2 + l^2), its root s as below, and t = b -+ s within e, that, and
//!   2^-98 (|b| + s).
//!
//! Products that underflow err by less than [`TINY`]. The bounds themselves are f64: [`ROUNDED`] pays for that.

use super::decide::{ExactFrame, Root, odds, power, root};
use super::field::FieldBasis;
use crate::double_double::{self as dd, Dd, Dd3};
use crate::dyadic::{self, Dyadic};
use crate::scene::camera::ExactViewport;
use std::cmp::Ordering;

/// See the module's head.
const CROSS: f64 = power_of_two(-96);
/// See the module's head.
const SQUARES: f64 = power_of_two(-96);
/// A handful of operations in f64, each within 2^-53, on numbers that are all positive.
const ROUNDED: f64 = 1.0 + power_of_two(-40);
/// Far above the errors of underflow (2^-1074 per product; operands are below 2^7 except quotients by a small a, which
/// are not products) and far below any number that decides; a D above it has a relative error of 2^-100 in its root.
pub(crate) const TINY: f64 = power_of_two(-900);
/// Relative error of the power of the eye: see [`Body::new`].
const POWER: f64 = power_of_two(-86);
/// The f64 pass: cross products of rounded operands are within 4 sqrt(2) 2^-53 N (two roundings of the operands, two of
/// the operations, for the nine products as above); 8 leaves room for |p| and the scale of `reach`.
const SCREEN: f64 = 8.0 * power_of_two(-53);
/// The f64 pass compares |dir x p|^2 (three squares and two sums) with a reach^2 (rounded a and reach, their square
/// and product): fewer than 16 roundings between them.
const COMPARE: f64 = 1.0 + 16.0 * power_of_two(-53);

/// 2^k for normal results.
const fn power_of_two(k: i64) -> f64 {
    f64::from_bits(((k + 1023) as u64) << 52)
}

/// A frame's basis for [`Body::new`]: unit vectors, every component within 2^-104 of itself.
pub(crate) struct AxesDd(pub(crate) [Dd3; 3]);

impl AxesDd {
    pub(crate) fn of(frame: &ExactFrame) -> Self {
        // 128 bits in each root and quotient leave an error of 2^-106 for the rounding.
        let (alpha, beta) = (frame.field.alpha2.sqrt(128), frame.field.beta2.sqrt(128));
        Self(frame.axes.each_ref().map(|axis| {
            let length = match axis.unit {
                FieldBasis::One => &alpha * &beta,
                FieldBasis::Alpha => beta.clone(),
                FieldBasis::Beta => alpha.clone(),
                FieldBasis::AlphaBeta => Dyadic::from(1),
            };
            axis.vector.each_ref().map(|x| x.over(&length, 128).to_dd())
        }))
    }

    /// The sum of the axes times `a`: from the frame to the world.
    #[inline(always)]
    pub(crate) fn world(&self, a: Dd3) -> Dd3 {
        // Not array::from_fn, which compilers leave as a call.
        let [right, up, forward] = &self.0;
        let component = |k: usize| a[0] * right[k] + a[1] * up[k] + a[2] * forward[k];
        [component(0), component(1), component(2)]
    }
}

/// A sphere in the frame.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
    /// The lengths below are 2^-k of the world's.
    pub(crate) k: i32,
    pub(crate) p: Dd3,
    pub(crate) r: f64,
    /// At least |p|.
    pub(crate) size: f64,
    /// |p|^2 - r^2, of which `power_error` is the relative error and `side` the exact sign.
    power: Dd,
    power_error: f64,
    pub(crate) side: Ordering,
}

impl Body {
    /// Moves the sphere into the frame.
    ///
    /// The power is |p|^2 - r^2 in double-double while it is above 2^-10 of |p|^2 + r^2: products and sums err by at
    /// most 2^-97 of those, hence 2^-87 of it. Nearer to the surface it is computed exactly and rounded.
    pub(crate) fn new(frame: &ExactFrame, eye: [f64; 3], basis: &AxesDd, center: [f64; 3], radius: f64) -> Self {
        let (p, radius_scaled, k) = offset(eye, center, radius);
        let r2 = Dd::product(radius_scaled, radius_scaled);
        let p2 = dd::dot(p, p);
        let mut power_dd = p2 - r2;
        let mut power_error = POWER;
        let mut side = power_dd.hi.total_cmp(&0.0);
        if power_dd.hi.abs() < power_of_two(-10) * (p2.hi + r2.hi) {
            let difference = dyadic::minus(&dyadic::vector(center), &frame.eye);
            let exact = power(&difference, radius).ldexp(-2 * i64::from(k));
            side = exact.sign();
            power_dd = exact.to_dd();
            // Below 2^-800 the low word, or all of it, may be lost: then only its sign is used.
            if side != Ordering::Equal && power_dd.hi.abs() < power_of_two(-800) {
                power_error = f64::INFINITY;
            }
        }
        // The second term is for a |p|^2 that underflows beside a radius near 1.
        let size = p2.hi.sqrt() * ROUNDED + power_of_two(-500);
        let p = basis.0.map(|axis| dd::dot(axis, p));
        Self { center, radius, k, p, r: radius_scaled, size, power: power_dd, power_error, side }
    }

    /// The data for the f64 pass.
    pub(crate) fn screen(&self) -> Screen {
        Screen::new(self.p.map(|x| x.hi), self.r, self.size)
    }
}

/// (c - e) 2^-k, r 2^-k and k, exact but for underflow below 2^-1074.
fn offset(eye: [f64; 3], center: [f64; 3], radius: f64) -> (Dd3, f64, i32) {
    let scaled = |by: f64| std::array::from_fn::<_, 3, _>(|n| Dd::diff(center[n] * by, eye[n] * by));
    let largest = |p: &Dd3, r: f64| p.iter().fold(r, |m, x| m.max(x.hi.abs()));
    let direct = scaled(1.0);
    // A difference beyond f64 is computed from numbers 16 times smaller; their underflow is 2^-2000 of it.
    let (p, r, shift) = if direct.iter().all(|x| x.hi.is_finite() && x.lo.is_finite()) {
        (direct, radius, 0)
    } else {
        (scaled(0.0625), radius * 0.0625, 4)
    };
    let k = dd::exponent(largest(&p, r));
    (p.map(|x| x.ldexp(-k)), dd::ldexp(r, -k), k + shift)
}

/// The data of a sphere for the f64 pass, 32 bytes together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Screen {
    p: [f64; 3],
    reach2: f64,
}

impl Screen {
    /// `size` is at least |p|.
    fn new(p: [f64; 3], r: f64, size: f64) -> Self {
        let reach = r + SCREEN * size;
        Self { p, reach2: reach * reach * COMPARE }
    }

    /// The data of a sphere that is not set up, for rays with a given direction, in the world's unit. c - e is within
    /// 2^-53 of itself in each component, which [`SCREEN`] covers. Where a square overflows, `reach2` does too, and
    /// nothing is missed.
    pub(crate) fn from(eye: [f64; 3], center: [f64; 3], radius: f64) -> Self {
        let p: [f64; 3] = std::array::from_fn(|n| center[n] - eye[n]);
        let size = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt() + power_of_two(-400);
        Self::new(p, radius, size)
    }

    /// A sphere that no ray hits.
    pub(crate) const NEVER: Self = Self { p: [0.0; 3], reach2: f64::NEG_INFINITY };

    /// The same for parallel rays whose origins, times 2^-`k`, have components up to 1: in that unit.
    pub(crate) fn aside(&mut self, body: &Body, k: i32) {
        if self.reach2 < 0.0 {
            return;
        }
        let scaled = |x: f64| dd::ldexp(x, body.k - k);
        let reach = scaled(body.r) + SCREEN * (scaled(body.size) + 2.0);
        *self = Self { p: self.p.map(scaled), reach2: reach * reach * COMPARE };
    }
}

/// A ray in the frame: direction within 2^-99 of itself, scaled by 2^-k.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilterRay {
    pub(crate) dir: Dd3,
    /// |dir|^2, within 2^-97.
    pub(crate) a: Dd,
    /// At least |dir|.
    length: f64,
    pub(crate) k: i32,
    /// The origin of a parallel ray in the plane of the eye, times 2^-k with its own k.
    from: Option<([Dd; 2], i32)>,
}

/// The exponent of the largest number of a lens.
pub(crate) fn exponent(lens: &ExactViewport) -> i32 {
    let depth = if lens.is_parallel() { 0.0 } else { lens.d };
    dd::exponent(lens.vw.max(lens.height_over(0, 1.0)).max(depth))
}

impl FilterRay {
    #[inline(always)]
    fn new(dir: Dd3, k: i32) -> Self {
        let a = dd::dot(dir, dir);
        // The second term is for a direction whose square underflows.
        Self { dir, a, length: a.hi.sqrt() * ROUNDED + power_of_two(-500), k, from: None }
    }

    /// A ray with a given direction; not zero.
    pub(crate) fn along(direction: [f64; 3]) -> Self {
        let k = dd::exponent(direction.iter().fold(0.0f64, |m, x| m.max(x.abs())));
        Self::new(direction.map(|x| Dd::from(dd::ldexp(x, -k))), k)
    }

    /// The ray through the centre of row i, column j.
    #[inline(always)]
    pub(crate) fn through(lens: &ExactViewport, [width, height]: [u32; 2], i: u32, j: u32) -> Self {
        let k = exponent(lens);
        let [columns, rows] = odds([width.into(), height.into()], i, j).map(|n| n as f64);
        let part = |n: f64, [x, y, z]: [f64; 3], count: u32| {
            Dd::product(n, x) * Dd::from(y) / Dd::product(z, 2.0 * f64::from(count))
        };
        let [right, up] =
            [part(columns, [dd::ldexp(lens.vw, -k), 1.0, 1.0], width), part(rows, lens.height(k), height)];
        if lens.is_parallel() {
            let ahead = [0.0, 0.0, 1.0].map(Dd::from);
            return Self { from: Some(([right, up], k)), ..Self::new(ahead, 0) };
        }
        Self::new([right, up, Dd::from(dd::ldexp(lens.d, -k))], k)
    }

    /// The origin of a parallel ray in the plane of the eye, times 2^-k.
    #[inline(always)]
    pub(crate) fn start(&self, k: i32) -> Option<[Dd; 2]> {
        self.from.map(|(from, own)| from.map(|x| x.ldexp(own - k)))
    }

    /// The f64 pass: whether the line certainly misses the sphere.
    #[inline(always)]
    pub(crate) fn misses(&self, s: &Screen) -> bool {
        if let Some(([right, up], _)) = self.from {
            let (x, y) = (s.p[0] - right.hi, s.p[1] - up.hi);
            return x * x + y * y > s.reach2 + TINY;
        }
        let ([x, y, z], [u, v, d]) = (s.p, self.dir.map(|x| x.hi));
        let (l, m, n) = (v * z - d * y, d * x - u * z, u * y - v * x);
        l * l + m * m + n * n > self.a.hi * s.reach2 + TINY
    }

    /// The double-double pass.
    #[inline(always)]
    pub(crate) fn meet(&self, s: &Body) -> FilterResult {
        if let Some(from) = self.start(s.k) {
            return aside(from, s);
        }
        let e = CROSS * self.length * s.size + TINY;
        let b = dd::dot(self.dir, s.p);
        if s.side != Ordering::Less && b.hi < -e {
            return FilterResult::Miss;
        }
        let (disc, error) = self.discriminant(s, e);
        if s.side == Ordering::Greater && disc.hi < -error {
            return FilterResult::Miss;
        }
        let ahead = b.hi > e;
        let sure = match s.side {
            Ordering::Less => true,
            Ordering::Equal => ahead,
            Ordering::Greater => ahead && disc.hi > error,
        };
        let (t, error) = self.parameter(s, b, e, (disc, error));
        let hit = FilterHit { t, error, k: s.k };
        if sure { FilterResult::FilterHit(hit, root(s.side)) } else { FilterResult::Unsure(hit) }
    }

    /// D and its error; `e` is that of the components of dir x p.
    #[inline(always)]
    fn discriminant(&self, s: &Body, e: f64) -> (Dd, f64) {
        let moment = dd::cross(self.dir, s.p);
        let l2 = dd::dot(moment, moment);
        let ar2 = self.a * Dd::product(s.r, s.r);
        let error = (2.0 * l2.hi.sqrt() + e) * e + SQUARES * (ar2.hi + l2.hi) + TINY;
        (ar2 - l2, error * ROUNDED)
    }

    /// t and its relative error for a line that hits the sphere.
    ///
    /// |b| + sqrt(D) = q is a sum of like signs; one root is q/a, the other |power|/q. Where D > E its root errs by at
    /// most E/sqrt(D), anywhere by sqrt(E), and roundings of q and its parts stay below 2^-98 q. An a that is itself next
    /// to underflow has fewer bits than that.
    #[inline(always)]
    fn parameter(&self, s: &Body, b: Dd, e: f64, (disc, error): (Dd, f64)) -> (Dd, f64) {
        let magnitude = if b.hi < 0.0 { -b } else { b };
        let (q, loss) = if s.side == Ordering::Equal {
            (magnitude + magnitude, 2.0 * e)
        } else {
            let half = disc.sqrt();
            (magnitude + half, e + if disc.hi > error { error / half.hi } else { error.sqrt() })
        };
        let loss = (loss + power_of_two(-98) * q.hi) * ROUNDED;
        let q_error = if q.hi > 2.0 * loss && self.a.hi > TINY { loss / (q.hi - loss) } else { f64::INFINITY };
        // The quotients and a itself add less than 2^-96.
        if s.side == Ordering::Equal || (s.side == Ordering::Less && b.hi >= 0.0) {
            return (q / self.a, (q_error + power_of_two(-96)) * ROUNDED);
        }
        let power = if s.side == Ordering::Less { -s.power } else { s.power };
        (power / q, (q_error + s.power_error + power_of_two(-96)) * ROUNDED)
    }
}

/// The double-double pass for a parallel ray from that origin, in the sphere's unit. Results that are not finite decide
/// nothing.
#[inline(always)]
fn aside([right, up]: [Dd; 2], s: &Body) -> FilterResult {
    let (x, y, b) = (s.p[0] - right, s.p[1] - up, s.p[2]);
    let e = CROSS * (s.size + right.hi.abs() + up.hi.abs()) + TINY;
    let (l2, r2) = (x * x + y * y, Dd::product(s.r, s.r));
    let disc = r2 - l2;
    let error = ((2.0 * l2.hi.sqrt() + e) * e + SQUARES * (r2.hi + l2.hi) + TINY) * ROUNDED;
    if disc.hi < -error {
        return FilterResult::Miss;
    }
    let half = disc.sqrt();
    let of_root = if disc.hi > error { error / half.hi } else { error.sqrt() };
    let loss = (e + of_root + power_of_two(-98) * (b.hi.abs() + half.hi)) * ROUNDED;
    let (near, far) = (b - half, b + half);
    if far.hi < -loss {
        return FilterResult::Miss;
    }
    let hit = |t: Dd| FilterHit {
        t,
        error: if t.hi > 2.0 * loss { loss / (t.hi - loss) * ROUNDED } else { f64::INFINITY },
        k: s.k,
    };
    match (disc.hi > error, near.hi > loss, near.hi < -loss && far.hi > loss) {
        (true, true, _) => FilterResult::FilterHit(hit(near), Root::Near),
        (true, _, true) => FilterResult::FilterHit(hit(far), Root::Far),
        // It is not known which of the roots counts.
        _ => FilterResult::Unsure(FilterHit { error: f64::INFINITY, ..hit(far) }),
    }
}

/// The result of the double-double pass for one sphere. An unsure result still bounds its t.
pub(crate) enum FilterResult {
    Miss,
    FilterHit(FilterHit, Root),
    Unsure(FilterHit),
}

/// The root that counts: t for the scaled ray and sphere, its relative error, and the sphere's exponent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilterHit {
    pub(crate) t: Dd,
    pub(crate) error: f64,
    k: i32,
}

impl FilterHit {
    /// The order of t, where the errors allow a decision.
    #[inline(always)]
    pub(crate) fn order(&self, other: &Self) -> Option<Ordering> {
        let k = self.k.max(other.k);
        let (s, t) = (self.t.ldexp(self.k - k), other.t.ldexp(other.k - k));
        // The difference itself has an error of 2^-100 of the larger; with an infinite or undefined error there is no
        // decision.
        let doubt = (s.hi * (self.error + power_of_two(-99)) + t.hi * (other.error + power_of_two(-99))) * ROUNDED;
        let gap = (s - t).hi;
        (gap.abs() > doubt + TINY).then(|| gap.total_cmp(&0.0))
    }
}
