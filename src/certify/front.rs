//! A sphere wholly in front of the eye plane, by its projected centre: the twin of certify/front.wgsl.

use super::{Answer, DEPTH, INFLATE, LensRecord, NORMAL, Slopes, Terms, UNIT, VANISH};
use crate::ray::{positive, unit3};
use crate::real::Real;
use bytemuck::{Pod, Zeroable};

/// What every candidate is asked; certify/lens.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct FrontRecord {
    pub(crate) x: i32,
    pub(crate) y: i32,
    pub(crate) rho: f32,
    pub(crate) low: f32,
}

/// What only a winner is asked; certify/lens.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct FrontMoreRecord {
    pub(crate) rest: [f32; 2],
    pub(crate) center: f32,
    pub(crate) id: u32,
}

/// Both records in the arithmetic of a twin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Front<R> {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) rho: R,
    pub(super) low: R,
    pub(super) rest: [R; 2],
    pub(super) center: R,
    pub(crate) id: u32,
}

impl<R: Real> Front<R> {
    #[inline(always)]
    pub(crate) fn new(f: &FrontRecord, more: &FrontMoreRecord) -> Self {
        Self {
            x: f.x,
            y: f.y,
            rho: R::exact(f.rho),
            low: R::exact(f.low),
            rest: more.rest.map(R::exact),
            center: R::exact(more.center),
            id: more.id,
        }
    }
}

/// a rho^2 - |o|^2 - (slopes x o)^2: positive where the ray at offset o from the projected centre hits.
#[inline(always)]
pub(super) fn front_discriminant<R: Real>(s: &Slopes<R>, rho: R, o: [R; 2]) -> R {
    let across = s.x * o[1] - s.y * o[0];
    s.a * (rho * rho) - (o[0] * o[0] + o[1] * o[1] + across * across)
}

/// A lower bound of the depth of the near root, or MISS for a certain miss.
#[inline(always)]
pub(crate) fn front_low<R: Real>(s: &Slopes<R>, lens: &LensRecord, f: &Front<R>) -> R {
    let c = R::exact;
    let o = [R::whole(s.fixed_column - f.x) * c(lens.fixed_x), R::whole(f.y - s.fixed_row) * c(lens.fixed_y)];
    let disc = front_discriminant(s, f.rho, o);
    let error = c(lens.error0) + f.rho * (c(lens.error1) + f.rho * c(lens.error2));
    // Slope along the offset plus root, in the order that Mesa's compiler gives a sum which is used once.
    let total = s.x * o[0] + (s.y * o[1] + positive(disc + error).sqrt());
    let size = f.low * c(lens.unit) + c(lens.size);
    let low = f.low - total * (size * s.inverse);
    if disc < -error { R::MISS } else { low }
}

/// Offset, its square, slopes' square; the discriminant, and the bound of its error.
pub(super) struct Weighed<R> {
    pub(super) o: [R; 2],
    pub(super) o2: R,
    pub(super) slant2: R,
    pub(super) disc: R,
    pub(super) error: R,
}

/// The same sphere with all it has, and a bound for this ray: docs/certificate.md, section 2.
#[inline(always)]
pub(super) fn front_weigh<R: Real>(s: &Slopes<R>, lens: &LensRecord, f: &Front<R>, terms: &Terms) -> Weighed<R> {
    let c = R::exact;
    let half = 1 << (lens.shift - 1);
    let [column, row] = [f.x, f.y].map(|fixed| (fixed + half) >> lens.shift);
    let dx = (R::whole(s.column - column) - f.rest[0]) * c(lens.step_x);
    let dy = (R::whole(row - s.row) - f.rest[1]) * c(lens.step_y);
    let disc = front_discriminant(s, f.rho, [dx, dy]);
    let slant2 = s.x * s.x + s.y * s.y;
    let o2 = dx * dx + dy * dy;
    let e = c(lens.edge);
    let [ball, offset] = [terms.ball, terms.offset].map(|[alone, each]| c(alone) + c(each) * slant2);
    let roundings = ball * (f.rho * f.rho) + offset * o2;
    let error = (c(UNIT) * roundings + s.a * e * (c(2.0) * o2.sqrt() + e)) * c(INFLATE) + c(VANISH) * s.a;
    Weighed { o: [dx, dy], o2, slant2, disc, error }
}

/// The winner's answer and its bounds.
#[inline(always)]
pub(crate) fn front_answer<R: Real>(s: &Slopes<R>, lens: &LensRecord, f: &Front<R>, terms: &Terms) -> Answer<R> {
    let c = R::exact;
    let Weighed { o: [dx, dy], o2, slant2, disc, error } = front_weigh(s, lens, f, terms);
    let slant = slant2.sqrt();
    let e = c(lens.edge);
    let hits = disc > error;
    let root = positive(disc).sqrt();
    let most = positive(disc + error).sqrt();
    let least = positive(disc - error).sqrt();
    let along = s.x * dx + s.y * dy;
    let total = along.abs() + most;
    let depth = c(lens.depth) + f.center;
    let length = (f.center * c(lens.unit) + c(lens.size)) * s.inverse;
    let [whole, each, of_along, of_root, of_center] = terms.depth.map(c);
    let steep = (s.x * dx).abs() + (s.y * dy).abs();
    let mixed = c(UNIT) * ((whole + each * slant2) * total + of_along * steep + of_root * most) + slant * e;
    let blur = (mixed * length + c(UNIT) * of_center * f.center.abs()) * c(INFLATE) + c(DEPTH) * depth;
    let low = f.center - (along + most) * length - blur;
    let high = f.center - (along + least) * length + blur;
    let k = (along + root) * s.inverse;
    let normal = unit3([dx - k * s.x, dy - k * s.y, k]);
    let off = s.a.sqrt() * (mixed + (most - least)) * s.inverse + c(UNIT) * c(4.0) * (total + o2.sqrt()) + e;
    // A root that is not surely ahead is not surely the hit. & and not &&: nothing to skip, and compilers make vectors of it.
    let hits = hits & (c(lens.depth) + low > c(VANISH));
    let sure = hits & (off < c(NORMAL) * f.rho);
    let width = (high - low + blur) * c(INFLATE);
    Answer { sure, hits, id: f.id, offset: -(along + root) * length, low, high, width, normal }
}
