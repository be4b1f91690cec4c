//! Any sphere that is not wholly in front, with a bound for each ray: the twin of certify/near.wgsl.

use super::{Answer, Slopes};
use crate::ray::{cross3, minus, negated, positive, times, unit3};
use crate::real::Real;
use bytemuck::{Pod, Zeroable};

/// certify/lens.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct NearRecord {
    pub(crate) ball: [f32; 4],
    pub(crate) power: f32,
    pub(crate) scale: f32,
    pub(crate) form: u32,
    pub(crate) id: u32,
}

/// The record in the arithmetic of a twin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Near<R> {
    pub(crate) ball: [R; 4],
    pub(crate) power: R,
    pub(crate) scale: R,
    pub(crate) form: u32,
    pub(crate) id: u32,
}

impl<R: Real> Near<R> {
    pub(crate) fn new(n: &NearRecord) -> Self {
        let (power, scale) = (R::exact(n.power), R::exact(n.scale));
        Self { ball: n.ball.map(R::exact), power, scale, form: n.form, id: n.id }
    }
}

/// 2^-23: WGSL rounds either way.
const UNIT: f32 = 1.192_092_9e-7;
/// 2^-48: what the host's f64 rotation leaves.
pub(crate) const HOST: f32 = 3.552_713_7e-15;
/// 1 + 2^-10: the bounds are computed in f32 themselves.
const INFLATE: f32 = 1.000_976_6;
/// 2^-100: what flushed subnormals leave, times |d|^2.
const VANISH: f32 = 7.888_609e-31;
/// 12 UNIT: root, sum and quotient of c/q.
const QUOTIENT: f32 = 12.0 * UNIT;
/// 24 UNIT: root, sum, |d|^2 and quotient of the others.
const SUM: f32 = 24.0 * UNIT;
/// A depth beyond every frame, and below MISS.
const FAR: f32 = 3.0e38;
/// Radians promised, less the roundings of the unit vector.
pub(crate) const NORMAL: f32 = 0.97e-3;

/// b = p.d, the discriminant, and the bounds of their errors; g = p x d and the sum of its errors.
struct Weighed<R> {
    b: R,
    b_error: R,
    disc: R,
    error: R,
    g: [R; 3],
    g_error: R,
}

fn near_weigh<R: Real>(s: &Slopes<R>, n: &Near<R>) -> Weighed<R> {
    let c = R::exact;
    let [px, py, pz, r] = n.ball;
    let l = s.x.abs() + s.y.abs() + R::ONE;
    let b = px * s.x + py * s.y - pz;
    let b_sum = (px * s.x).abs() + (py * s.y).abs() + pz.abs();
    let b_error = (c(5.0 * UNIT) * b_sum + c(2.0 * HOST) * l) * c(INFLATE);
    let g = [-py - pz * s.y, pz * s.x + px, px * s.y - py * s.x];
    let e = [py.abs() + (pz * s.y).abs(), (pz * s.x).abs() + px.abs(), (px * s.y).abs() + (py * s.x).abs()];
    let g_error = e.map(|e| c(4.0 * UNIT) * e + c(2.0 * HOST) * l);
    let (disc, error);
    if n.form == 1 {
        let ac = s.a * n.power;
        disc = b * b - ac;
        error = c(2.0) * b.abs() * b_error + b_error * b_error + c(UNIT) * (c(2.0) * b * b + c(8.5) * ac.abs());
    } else {
        let gg = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
        let ar2 = s.a * (r * r);
        disc = ar2 - gg;
        let mixed = g[0].abs() * g_error[0] + g[1].abs() * g_error[1] + g[2].abs() * g_error[2];
        let small = g_error[0] * g_error[0] + g_error[1] * g_error[1] + g_error[2] * g_error[2];
        error = c(UNIT) * (c(12.0) * ar2 + c(4.0) * gg) + c(2.0) * mixed + small;
    }
    let sum = g_error[0] + g_error[1] + g_error[2];
    Weighed { b, b_error, disc, error: error * c(INFLATE) + s.a * c(VANISH), g, g_error: sum }
}

/// A lower bound of the depth of the hit, or MISS for a certain miss. Record's unit.
fn near_below<R: Real>(s: &Slopes<R>, n: &Near<R>, w: &Weighed<R>) -> R {
    let zero = R::ZERO;
    if n.power >= zero && (w.disc < -w.error || w.b < -w.b_error) {
        return R::MISS;
    }
    let most = positive(w.disc + w.error).sqrt();
    let least = positive(w.disc - w.error).sqrt();
    if n.power > zero {
        let q = w.b + w.b_error + most;
        if q <= zero {
            return R::MISS;
        }
        let low = n.power / q * R::exact(1.0 - QUOTIENT);
        return if low < R::exact(FAR) { low } else { R::exact(FAR) };
    }
    if w.b > w.b_error {
        return (w.b - w.b_error + least) * s.inverse * R::exact(1.0 - SUM);
    }
    if n.power < zero {
        return -n.power / (w.b_error - w.b + most) * R::exact(1.0 - QUOTIENT);
    }
    zero
}

/// A lower bound of the depth of the hit in the frame's unit, or MISS for a certain miss.
pub(crate) fn near_low<R: Real>(s: &Slopes<R>, n: &Near<R>) -> R {
    let low = near_below(s, n, &near_weigh(s, n));
    if low < R::MISS { low * n.scale } else { R::MISS }
}

pub(crate) fn near_answer<R: Real>(s: &Slopes<R>, n: &Near<R>) -> Answer<R> {
    let w = near_weigh(s, n);
    let root = positive(w.disc).sqrt();
    let most = positive(w.disc + w.error).sqrt();
    let least = positive(w.disc - w.error).sqrt();
    let ahead = w.b > w.b_error;
    let mut hits = w.disc > w.error && (n.power < R::ZERO || ahead);
    let (depth, high);
    if n.power > R::ZERO {
        depth = n.power / (w.b + root);
        high = n.power / (w.b - w.b_error + least) * R::exact(1.0 + QUOTIENT);
    } else if ahead {
        depth = (w.b + root) * s.inverse;
        high = (w.b + w.b_error + most) * s.inverse * R::exact(1.0 + SUM);
    } else {
        let q = least - (w.b + w.b_error);
        depth = -n.power / (root - w.b);
        high = -n.power / q * R::exact(1.0 + SUM);
        hits = hits && q > R::HALF * least;
    }
    let d = [s.x, s.y, -R::ONE];
    let across = cross3(d, w.g);
    let side = if n.power > R::ZERO { negated(across) } else { across };
    let normal = unit3(minus(side, times(root, d)));
    let true_normal = w.g_error + (most - least) < R::exact(NORMAL) * (s.a.sqrt() * n.ball[3]);
    let low = near_below(s, n, &w);
    Answer {
        sure: hits && true_normal,
        hits,
        id: n.id,
        offset: depth * n.scale,
        low: low * n.scale,
        high: high * n.scale,
        normal,
    }
}
