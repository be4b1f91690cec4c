//! A sphere that is not entirely in front of the eye plane, with a bound per ray: the twin of certify/general.wgsl.

use super::answer::{Answer, Slopes};
use super::constants::{BEYOND, CLEAR, FAR, HOST, HOST_PARTS, INFLATE, NORMAL, UNIT, VANISH};
use super::projected::Roots;
use super::terms::Terms;
use crate::number::{Mask, Number};
use crate::view::ray::{cross3, minus, positive, times, unit3};
use bytemuck::{Pod, Zeroable};

/// Marks a slot that refers to the list of general spheres.
pub(crate) const GENERAL: u32 = 0x8000_0000;

/// The record as declared in certify/general.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct GeneralRecord {
    pub(crate) center_radius: [f32; 4],
    pub(crate) power: f32,
    pub(crate) scale: f32,
    pub(crate) form: u32,
    pub(crate) id: u32,
    pub(crate) pixel: [i32; 2],
    pub(crate) by: [f32; 2],
    pub(crate) start: f32,
    pub(crate) blur: f32,
    /// The place of a sphere that planes cut among these ([`super::planes::Ranks`]); 0 for a whole one.
    pub(crate) rank: u32,
    /// WGSL rounds the size up to the alignment of center_radius.
    pub(crate) unused: f32,
}

/// The record in the number type of a twin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct General<R> {
    pub(super) center_radius: [R; 4],
    pub(super) power: R,
    pub(super) scale: R,
    pub(super) form: u32,
    pub(crate) id: u32,
    pub(super) pixel: [i32; 2],
    pub(super) start: R,
    pub(super) by: [R; 2],
    pub(super) blur: R,
    pub(crate) rank: u32,
}

impl<R: Number> General<R> {
    pub(crate) fn new(n: &GeneralRecord) -> Self {
        Self {
            center_radius: n.center_radius.map(R::from_f32),
            power: R::from_f32(n.power),
            scale: R::from_f32(n.scale),
            form: n.form,
            id: n.id,
            pixel: n.pixel,
            start: R::from_f32(n.start),
            by: n.by.map(R::from_f32),
            blur: R::from_f32(n.blur),
            rank: n.rank,
        }
    }
}

/// b = p.d, the discriminant, and the bounds of their errors; g = p x d and the sum of its errors.
pub(super) struct Weighed<R> {
    pub(super) b: R,
    pub(super) b_error: R,
    pub(super) disc: R,
    pub(super) error: R,
    pub(super) g: [R; 3],
    pub(super) g_error: R,
}

#[inline(always)]
pub(super) fn general_weigh<R: Number>(s: &Slopes<R>, n: &General<R>, terms: &Terms) -> Weighed<R> {
    let c = R::from_f32;
    let [px, py, pz, r] = n.center_radius;
    let l = s.x.abs() + s.y.abs() + R::ONE;
    let right = R::from_i32(s.column - n.pixel[0]) * n.by[0];
    let down = R::from_i32(s.row - n.pixel[1]) * n.by[1];
    let b = n.start + right + down;
    let [of_start, of_steps] = terms.along.map(c);
    let b_sum = of_start * n.start.abs() + of_steps * (right.abs() + down.abs());
    let b_error = (c(UNIT) * b_sum + n.blur + c(HOST_PARTS * HOST) * l) * c(INFLATE);
    let g = [-py - pz * s.y, pz * s.x + px, px * s.y - py * s.x];
    let e = [py.abs() + (pz * s.y).abs(), (pz * s.x).abs() + px.abs(), (px * s.y).abs() + (py * s.x).abs()];
    let [of_ball, alone, of_square, of_part] = terms.cross.map(c);
    let g_error = e.map(|e| of_part * c(UNIT) * e + c(HOST_PARTS * HOST) * l);
    let (disc, error);
    if n.form == 1 {
        let [of_b, of_ac, alone] = terms.power.map(c);
        let ac = s.a * n.power;
        disc = b * b - ac;
        error = c(2.0) * b.abs() * b_error
            + b_error * b_error
            + c(UNIT) * (of_b * b * b + (of_ac * s.a + alone) * ac.abs());
    } else {
        let gg = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
        let ar2 = s.a * (r * r);
        disc = ar2 - gg;
        let mixed = g[0].abs() * g_error[0] + g[1].abs() * g_error[1] + g[2].abs() * g_error[2];
        let small = g_error[0] * g_error[0] + g_error[1] * g_error[1] + g_error[2] * g_error[2];
        error = c(UNIT) * ((of_ball * s.a + alone) * ar2 + of_square * gg) + c(2.0) * mixed + small;
    }
    let sum = g_error[0] + g_error[1] + g_error[2];
    Weighed { b, b_error, disc, error: error * c(INFLATE) + s.a * c(VANISH), g, g_error: sum }
}

/// Root, sum, |d|^2, its reciprocal, and the product.
#[inline(always)]
fn sum_error<R: Number>(s: &Slopes<R>, terms: &Terms) -> R {
    R::from_f32(UNIT) * (R::from_f32(terms.root[2]) + R::from_f32(terms.root[1]) * s.a)
}

/// Root, sum and quotient of c/q.
fn quotient_error<R: Number>(terms: &Terms) -> R {
    R::from_f32(UNIT) * R::from_f32(terms.root[0])
}

/// A lower bound of the depth of the hit in the unit of the record, or MISS for a certain miss. Every case is computed and
/// one is picked, because compilers make no vectors of branches.
#[inline(always)]
pub(super) fn general_below<R: Number>(s: &Slopes<R>, n: &General<R>, w: &Weighed<R>, terms: &Terms) -> R {
    let (zero, far) = (R::ZERO, R::from_f32(FAR));
    let (outside, inside) = (zero.less(n.power), n.power.less(zero));
    let misses = !inside & (w.disc.less(-w.error) | w.b.less(-w.b_error));
    let most = positive(w.disc + w.error).sqrt();
    let least = positive(w.disc - w.error).sqrt();
    let by_quotient = R::ONE - quotient_error(terms);
    let q = w.b + w.b_error + most;
    let near = n.power / q * by_quotient;
    let near = zero.less(q).pick(near.less(far).pick(near, far), R::MISS);
    let sum = (w.b - w.b_error + least) * s.inverse * (R::ONE - sum_error(s, terms));
    let behind = inside.pick(-n.power / (w.b_error - w.b + most) * by_quotient, zero);
    let low = outside.pick(near, w.b_error.less(w.b).pick(sum, behind));
    misses.pick(R::MISS, low)
}

/// A lower bound of the depth of the hit in the frame's unit, or MISS for a certain miss.
#[inline(always)]
pub(crate) fn general_low<R: Number>(s: &Slopes<R>, n: &General<R>, terms: &Terms) -> R {
    let low = general_below(s, n, &general_weigh(s, n, terms), terms);
    low.less(R::MISS).pick(low * n.scale, R::MISS)
}

/// The roots of the sphere; planes may leave either of them.
#[inline(always)]
pub(crate) fn general_roots<R: Number>(s: &Slopes<R>, n: &General<R>, terms: &Terms) -> Roots<R> {
    let (beyond, one) = (R::from_f32(BEYOND), R::ONE);
    let Answer { low, high, hits, .. } = general_answer(s, n, terms);
    let w = general_weigh(s, n, terms);
    let least = positive(w.disc - w.error).sqrt();
    let most = positive(w.disc + w.error).sqrt();
    let of_sum = sum_error(s, terms);
    let sums = [
        (w.b - w.b_error + least) * s.inverse * (one - of_sum) * n.scale,
        (w.b + w.b_error + most) * s.inverse * (one + of_sum) * n.scale,
    ];
    let (outside, first) = (R::ZERO.less(n.power), general_low(s, n, terms));
    // An eye on the surface is not known to be on either side of it.
    let hits = hits & (outside | n.power.less(R::ZERO));
    let far = [outside.pick(sums[0], low), hits.pick(outside.pick(sums[1], high), beyond)];
    let near = [outside.pick(first, -beyond), outside.pick(high, -beyond)];
    Roots { near, far, hits, misses: !first.less(R::MISS), inside: !outside }
}

#[inline(always)]
pub(crate) fn general_answer<R: Number>(s: &Slopes<R>, n: &General<R>, terms: &Terms) -> Answer<R> {
    let c = R::from_f32;
    let w = general_weigh(s, n, terms);
    let root = positive(w.disc).sqrt();
    let most = positive(w.disc + w.error).sqrt();
    let least = positive(w.disc - w.error).sqrt();
    let (outside, inside) = (R::ZERO.less(n.power), n.power.less(R::ZERO));
    let ahead = w.b_error.less(w.b);
    let q = least - (w.b + w.b_error);
    let clear = (c(CLEAR) * least).less(q);
    let hits = w.error.less(w.disc) & (inside | ahead) & (outside | ahead | clear);
    let (of_sum, of_quotient) = (sum_error(s, terms), quotient_error(terms));
    let rounding = outside.pick(of_quotient, of_sum);
    let choose = |near: R, sum: R, behind: R| outside.pick(near, ahead.pick(sum, behind));
    let depth = choose(n.power / (w.b + root), (w.b + root) * s.inverse, -n.power / (root - w.b));
    let high = choose(
        n.power / (w.b - w.b_error + least) * (R::ONE + of_quotient),
        (w.b + w.b_error + most) * s.inverse * (R::ONE + of_sum),
        -n.power / q * (R::ONE + of_sum),
    );
    let d = [s.x, s.y, -R::ONE];
    let across = cross3(d, w.g);
    let facing = |x: R| outside.pick(-x, x);
    let side = [facing(across[0]), facing(across[1]), facing(across[2])];
    let normal = unit3(minus(side, times(root, d)));
    let (off, size) = (w.g_error + (most - least), s.a.sqrt() * n.center_radius[3]);
    let below = general_below(s, n, &w, terms);
    let low = below * n.scale;
    // Smaller values may be flushed to zero on one side only.
    let hits = hits & c(VANISH).less(low);
    let depth_interval = (high - below + rounding * high) * c(INFLATE) * n.scale;
    Answer {
        sure: hits & off.less(c(NORMAL) * size),
        hits,
        id: n.id,
        offset: depth * n.scale,
        low,
        high: high * n.scale,
        depth_interval,
        normal,
        #[cfg(test)]
        turn: outside.pick((off / size + c(UNIT) * c(super::constants::SURFACE)) * c(INFLATE), R::ZERO),
    }
}
