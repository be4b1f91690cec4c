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

use super::decide::{ExactFrame, Root, power, root};
use super::field::FieldBasis;
use crate::double_double::{self as dd, Dd, Dd3};
use crate::dyadic::{self, Dyadic};
use crate::number::{Fused, Mask, power_of_two};
use crate::scene::Ball;
use crate::scene::camera::ExactViewport;
use std::cmp::Ordering;

/// Error of dir x p and of dir.p, relative to |dir| |p|. The module's documentation derives it.
const CROSS: f64 = power_of_two(-96);
/// Error of the squares in D and of their difference, relative to their sum. The module's documentation derives it.
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
    pub(crate) fn world<T: Fused>(&self, a: Dd3<T>) -> Dd3<T> {
        // Not array::from_fn, which compilers leave as a call.
        [self.component(a, 0), self.component(a, 1), self.component(a, 2)]
    }

    /// One component of it. Not a closure, which compilers leave as a call.
    #[inline(always)]
    fn component<T: Fused>(&self, [a, b, c]: Dd3<T>, k: usize) -> Dd<T> {
        let [right, up, forward] = &self.0;
        a * Dd::splat(right[k]) + b * Dd::splat(up[k]) + c * Dd::splat(forward[k])
    }
}

/// The eye, and the frame's basis.
pub(crate) struct ExactCamera {
    pub(crate) eye: [f64; 3],
    pub(crate) basis: AxesDd,
}

/// A sphere in the frame.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    pub(crate) ball: Ball,
    /// The lengths below are 2^-k of the world's.
    pub(crate) k: i32,
    pub(crate) p: Dd3,
    pub(crate) r: f64,
    /// At least |p|.
    pub(crate) size: f64,
    /// |p|^2 - r^2, with `power_error` as its relative error and `side` as its exact sign.
    power: Dd,
    power_error: f64,
    pub(crate) side: Ordering,
}

impl Body {
    /// Moves the sphere into the frame.
    ///
    /// The power is |p|^2 - r^2 in double-double while it is above 2^-10 of |p|^2 + r^2: products and sums err by at
    /// most 2^-97 of those, hence 2^-87 of it. Nearer to the surface it is computed exactly and rounded.
    pub(crate) fn new(frame: &ExactFrame, camera: &ExactCamera, ball: Ball) -> Self {
        let Ball { center, radius } = ball;
        let (p, radius_scaled, k) = offset(camera.eye, center, radius);
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
        let p = camera.basis.0.map(|axis| dd::dot(axis, p));
        Self { ball, k, p, r: radius_scaled, size, power: power_dd, power_error, side }
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

    /// Whether no ray hits the sphere.
    pub(crate) fn is_never(&self) -> bool {
        self.reach2 < 0.0
    }

    /// Converts the data to a unit of 2^`k`, for parallel rays whose origins have components up to 1 in it.
    pub(crate) fn rescale(&mut self, body: &Body, k: i32) {
        if self.is_never() {
            return;
        }
        let scaled = |x: f64| dd::ldexp(x, body.k - k);
        let reach = scaled(body.r) + SCREEN * (scaled(body.size) + 2.0);
        *self = Self { p: self.p.map(scaled), reach2: reach * reach * COMPARE };
    }
}

/// These numbers in every lane. Not `map`, which compilers leave as a call.
#[inline(always)]
pub(crate) fn splat<T: Fused>([x, y, z]: Dd3) -> Dd3<T> {
    [Dd::splat(x), Dd::splat(y), Dd::splat(z)]
}

/// A ray in the frame, or a vector of them: direction within 2^-99 of itself, scaled by 2^-k.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilterRay<T = f64> {
    pub(crate) dir: Dd3<T>,
    /// |dir|^2, within 2^-97.
    pub(crate) a: Dd<T>,
    /// At least |dir|.
    length: T,
    pub(crate) k: i32,
    /// The origin of a parallel ray in the plane of the eye, times 2^-k with its own k.
    from: Option<([Dd<T>; 2], i32)>,
}

/// The exponent of the largest number of a lens.
pub(crate) fn exponent(lens: &ExactViewport) -> i32 {
    let depth = if lens.is_parallel() { 0.0 } else { lens.d };
    dd::exponent(lens.vw.max(lens.height_over(0, 1.0)).max(depth))
}

impl<T: Fused> FilterRay<T> {
    #[inline(always)]
    fn new(dir: Dd3<T>, k: i32) -> Self {
        let a = dd::dot(dir, dir);
        // The second term is for a direction whose square underflows.
        Self { dir, a, length: a.hi.sqrt() * T::splat(ROUNDED) + T::splat(power_of_two(-500)), k, from: None }
    }

    /// The ray through the centre of a pixel, which lies `columns` and `rows` half pixels from the middle of the image.
    #[inline(always)]
    pub(crate) fn through(lens: &ExactViewport, [width, height]: [u32; 2], [columns, rows]: [T; 2]) -> Self {
        let k = exponent(lens);
        let right = Self::part(columns, [dd::ldexp(lens.vw, -k), 1.0, 1.0], width);
        let up = Self::part(rows, lens.height(k), height);
        if lens.is_parallel() {
            let ahead = [Dd::from(T::ZERO), Dd::from(T::ZERO), Dd::from(T::splat(1.0))];
            return Self { from: Some(([right, up], k)), ..Self::new(ahead, 0) };
        }
        Self::new([right, up, Dd::from(T::splat(dd::ldexp(lens.d, -k)))], k)
    }

    /// n x y / (2 z count)
    #[inline(always)]
    fn part(n: T, [x, y, z]: [f64; 3], count: u32) -> Dd<T> {
        let by: Dd = Dd::product(z, 2.0 * f64::from(count));
        Dd::product(n, T::splat(x)) * Dd::from(T::splat(y)) / Dd::splat(by)
    }

    /// The origin of a parallel ray in the plane of the eye, times 2^-k.
    #[inline(always)]
    pub(crate) fn start(&self, k: i32) -> Option<[Dd<T>; 2]> {
        let ([right, up], own) = self.from?;
        Some([right.ldexp(own - k), up.ldexp(own - k)])
    }

    /// b = dir.p and the error of it and of the components of dir x p.
    #[inline(always)]
    fn along_body(&self, s: &Body) -> (Dd<T>, T) {
        let e = T::splat(CROSS) * self.length * T::splat(s.size) + T::splat(TINY);
        (dd::dot(self.dir, splat(s.p)), e)
    }

    /// Whether the ray of a perspective camera surely hits the sphere, and the hit: the near root from outside, else
    /// the far one.
    #[inline(always)]
    pub(crate) fn hit(&self, s: &Body) -> (T::Mask, FilterHit<T>) {
        let (b, e) = self.along_body(s);
        self.hit_at(s, (b, e), self.discriminant(s, e))
    }

    #[inline(always)]
    fn hit_at(&self, s: &Body, (b, e): (Dd<T>, T), disc: (Dd<T>, T)) -> (T::Mask, FilterHit<T>) {
        let ahead = e.less(b.hi);
        let sure = match s.side {
            Ordering::Less => ahead | !ahead,
            Ordering::Equal => ahead,
            Ordering::Greater => ahead & disc.1.less(disc.0.hi),
        };
        let (t, error) = self.parameter(s, b, e, disc);
        (sure, FilterHit { t, error, k: s.k })
    }

    /// D and its error; `e` is the error of the components of dir x p.
    #[inline(always)]
    fn discriminant(&self, s: &Body, e: T) -> (Dd<T>, T) {
        let moment = dd::cross(self.dir, splat(s.p));
        let l2 = dd::dot(moment, moment);
        let ar2 = self.a * Dd::splat(Dd::product(s.r, s.r));
        let error = (T::splat(2.0) * l2.hi.sqrt() + e) * e + T::splat(SQUARES) * (ar2.hi + l2.hi) + T::splat(TINY);
        (ar2 - l2, error * T::splat(ROUNDED))
    }

    /// t and its relative error for a line that hits the sphere.
    ///
    /// |b| + sqrt(D) = q is a sum of like signs; one root is q/a, the other |power|/q. Where D > E its root errs by at
    /// most E/sqrt(D), anywhere by sqrt(E), and roundings of q and its parts stay below 2^-98 q. An a that is itself next
    /// to underflow has fewer bits than that.
    #[inline(always)]
    fn parameter(&self, s: &Body, b: Dd<T>, e: T, (disc, error): (Dd<T>, T)) -> (Dd<T>, T) {
        let is_behind = b.hi.less(T::ZERO);
        let magnitude = Dd::pick(is_behind, -b, b);
        let (q, loss) = if s.side == Ordering::Equal {
            (magnitude + magnitude, T::splat(2.0) * e)
        } else {
            let half = disc.sqrt();
            (magnitude + half, e + error.less(disc.hi).pick(error / half.hi, error.sqrt()))
        };
        let rounded = T::splat(ROUNDED);
        let loss = (loss + T::splat(power_of_two(-98)) * q.hi) * rounded;
        let is_bounded = (T::splat(2.0) * loss).less(q.hi) & T::splat(TINY).less(self.a.hi);
        let q_error = is_bounded.pick(loss / (q.hi - loss), T::splat(f64::INFINITY));
        // The quotients and a itself add less than 2^-96.
        let steps = T::splat(power_of_two(-96));
        let far = (q_error + steps) * rounded;
        let near = (q_error + T::splat(s.power_error) + steps) * rounded;
        let power = Dd::splat(if s.side == Ordering::Less { -s.power } else { s.power });
        match s.side {
            Ordering::Equal => (q / self.a, far),
            Ordering::Greater => (power / q, near),
            Ordering::Less => (Dd::pick(is_behind, power / q, q / self.a), is_behind.pick(near, far)),
        }
    }
}

impl FilterRay {
    /// A ray with a given direction; not zero.
    pub(crate) fn along(direction: [f64; 3]) -> Self {
        let k = dd::exponent(direction.iter().fold(0.0f64, |m, x| m.max(x.abs())));
        Self::new(direction.map(|x| Dd::from(dd::ldexp(x, -k))), k)
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
    pub(crate) fn intersect(&self, s: &Body) -> FilterResult {
        if let Some(from) = self.start(s.k) {
            return intersect_parallel(from, s);
        }
        let (b, e) = self.along_body(s);
        if s.side != Ordering::Less && b.hi < -e {
            return FilterResult::Miss;
        }
        let (disc, error) = self.discriminant(s, e);
        if s.side == Ordering::Greater && disc.hi < -error {
            return FilterResult::Miss;
        }
        let (sure, hit) = self.hit_at(s, (b, e), (disc, error));
        if sure { FilterResult::FilterHit(hit, root(s.side)) } else { FilterResult::Unsure(hit) }
    }
}

/// The double-double pass for a parallel ray from that origin, in the sphere's unit. Results that are not finite decide
/// nothing.
#[inline(always)]
fn intersect_parallel([right, up]: [Dd; 2], s: &Body) -> FilterResult {
    let (x, y, b) = (s.p[0] - right, s.p[1] - up, s.p[2]);
    let e = CROSS * (s.size + right.hi.abs() + up.hi.abs()) + TINY;
    let (l2, r2): (Dd, Dd) = (x * x + y * y, Dd::product(s.r, s.r));
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
pub(crate) struct FilterHit<T = f64> {
    pub(crate) t: Dd<T>,
    pub(crate) error: T,
    k: i32,
}

impl FilterHit {
    /// A hit that nothing is known about.
    pub(crate) fn unknown(self) -> Self {
        Self { t: Dd::from(f64::NAN), error: f64::INFINITY, ..self }
    }

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
