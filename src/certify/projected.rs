//! A sphere entirely in front of the eye plane, represented by its projected centre: the twin of
//! certify/projected.wgsl.

use super::answer::{Answer, ProjectionRecord, Slopes};
#[cfg(test)]
use super::constants::SURFACE;
use super::constants::{BEYOND, DEPTH, INFLATE, NORMAL, TURN, UNIT, VANISH};
use super::terms::Terms;
use crate::number::{Mask, Number};
use crate::view::ray::{positive, unit3};
use bytemuck::{Pod, Zeroable};

/// The data that every test reads, declared in certify/projection.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct ProjectedRecord {
    pub(crate) x: i32,
    pub(crate) y: i32,
    pub(crate) rho: f32,
    pub(crate) low: f32,
}

/// The data that only the winner needs, declared in certify/projection.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct ProjectedDetailRecord {
    pub(crate) subpixel_offset: [f32; 2],
    pub(crate) center: f32,
    pub(crate) id: u32,
}

/// Both records in the number type of a twin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projected<R> {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) rho: R,
    pub(super) low: R,
    pub(super) subpixel_offset: [R; 2],
    pub(super) center: R,
    pub(crate) id: u32,
}

impl<R: Number> Projected<R> {
    #[inline(always)]
    pub(crate) fn new(f: &ProjectedRecord, more: &ProjectedDetailRecord) -> Self {
        Self {
            x: f.x,
            y: f.y,
            rho: R::from_f32(f.rho),
            low: R::from_f32(f.low),
            subpixel_offset: more.subpixel_offset.map(R::from_f32),
            center: R::from_f32(more.center),
            id: more.id,
        }
    }
}

/// a rho^2 - |o|^2 - (slopes x o)^2: positive if the ray at offset o from the projected centre hits.
#[inline(always)]
pub(super) fn projected_discriminant<R: Number>(s: &Slopes<R>, rho: R, o: [R; 2]) -> R {
    let across = s.x * o[1] - s.y * o[0];
    s.a * (rho * rho) - (o[0] * o[0] + o[1] * o[1] + across * across)
}

/// A lower bound of the depth of the near root, or MISS for a certain miss.
#[inline(always)]
pub(crate) fn projected_low<R: Number>(s: &Slopes<R>, projection: &ProjectionRecord, f: &Projected<R>) -> R {
    let c = R::from_f32;
    let (column, row) = (s.column << projection.shift, s.row << projection.shift);
    let o = [R::from_i32(column - f.x) * c(projection.fixed[0]), R::from_i32(f.y - row) * c(projection.fixed[1])];
    let disc = projected_discriminant(s, f.rho, o);
    let error = c(projection.errors[0]) + f.rho * (c(projection.errors[1]) + f.rho * c(projection.errors[2]));
    // Slope along the offset plus root, in the order in which Mesa's compiler evaluates a sum that is used once.
    let total = s.x * o[0] + (s.y * o[1] + positive(disc + error).sqrt());
    let size = f.low * c(projection.unit) + c(projection.size);
    let low = f.low - total * (size * s.inverse);
    if disc < -error { R::MISS } else { low }
}

/// The offset, its square, the square of the slopes, the discriminant, and the bound of its error.
pub(super) struct Weighed<R> {
    pub(super) o: [R; 2],
    pub(super) o2: R,
    pub(super) slant2: R,
    pub(super) disc: R,
    pub(super) error: R,
}

/// The same sphere with its full record, and a bound for this ray: docs/certificate.md, section 2.
#[inline(always)]
pub(super) fn projected_weigh<R: Number>(
    s: &Slopes<R>,
    projection: &ProjectionRecord,
    f: &Projected<R>,
    terms: &Terms,
) -> Weighed<R> {
    let c = R::from_f32;
    let half = 1 << (projection.shift - 1);
    let [column, row] = [f.x, f.y].map(|fixed| (fixed + half) >> projection.shift);
    let dx = (R::from_i32(s.column - column) - f.subpixel_offset[0]) * c(projection.step[0]);
    let dy = (R::from_i32(row - s.row) - f.subpixel_offset[1]) * c(projection.step[1]);
    let disc = projected_discriminant(s, f.rho, [dx, dy]);
    let slant2 = s.x * s.x + s.y * s.y;
    let o2 = dx * dx + dy * dy;
    let e = c(projection.edge);
    let [rho2, offset2] = [terms.rho2, terms.offset2].map(|[alone, each]| c(alone) + c(each) * slant2);
    let roundings = rho2 * (f.rho * f.rho) + offset2 * o2;
    let error = (c(UNIT) * roundings + s.a * e * (c(2.0) * o2.sqrt() + e)) * c(INFLATE) + c(VANISH) * s.a;
    Weighed { o: [dx, dy], o2, slant2, disc, error }
}

/// Both roots of a ray, by depths relative to the reference, with bounds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Roots<R> {
    pub(crate) near: [R; 2],
    pub(crate) far: [R; 2],
    /// The ray certainly hits, and in front of the eye; or it certainly misses.
    pub(crate) hits: bool,
    pub(crate) misses: bool,
    /// The eye may be inside or on the surface: what the ray hits first is the far root.
    pub(crate) inside: bool,
}

/// The near root, and the numbers that its bounds are made of.
struct Solved<R> {
    weighed: Weighed<R>,
    root: R,
    /// Bounds of the root of the discriminant.
    most: R,
    least: R,
    /// The slope along the offset; it and the largest root.
    along: R,
    total: R,
    /// The depth of a unit of the roots; the error in that unit, and of a depth.
    length: R,
    mixed: R,
    blur: R,
    low: R,
    hits: bool,
}

#[inline(always)]
fn solved<R: Number>(s: &Slopes<R>, projection: &ProjectionRecord, f: &Projected<R>, terms: &Terms) -> Solved<R> {
    let c = R::from_f32;
    let weighed = projected_weigh(s, projection, f, terms);
    let Weighed { o: [dx, dy], slant2, disc, error, .. } = weighed;
    let slant = slant2.sqrt();
    let e = c(projection.edge);
    let hits = disc > error;
    let root = positive(disc).sqrt();
    let most = positive(disc + error).sqrt();
    let least = positive(disc - error).sqrt();
    let along = s.x * dx + s.y * dy;
    let total = along.abs() + most;
    let depth = c(projection.depth) + f.center;
    let length = (f.center * c(projection.unit) + c(projection.size)) * s.inverse;
    let [whole, each, of_along, of_root, of_center] = terms.depth.map(c);
    let steep = (s.x * dx).abs() + (s.y * dy).abs();
    let mixed = c(UNIT) * ((whole + each * slant2) * total + of_along * steep + of_root * most) + slant * e;
    let blur = (mixed * length + c(UNIT) * of_center * f.center.abs()) * c(INFLATE) + c(DEPTH) * depth;
    let low = f.center - (along + most) * length - blur;
    // A root that is not certainly in front of the eye is not certainly the hit. & instead of &&: there is nothing to
    // skip, and compilers can vectorize it.
    let hits = hits & (c(projection.depth) + low > c(VANISH));
    Solved { weighed, root, most, least, along, total, length, mixed, blur, low, hits }
}

/// The roots of the sphere; planes may leave either of them.
#[inline(always)]
pub(crate) fn projected_roots<R: Number>(
    s: &Slopes<R>,
    projection: &ProjectionRecord,
    f: &Projected<R>,
    terms: &Terms,
) -> Roots<R> {
    let c = R::from_f32;
    let Solved { weighed, most, least, along, length, blur, low, hits, .. } = solved(s, projection, f, terms);
    let high = f.center - (along + least) * length + blur;
    let far = [f.center - (along - least) * length - blur, f.center - (along - most) * length + blur];
    // Under parallel projection, a sphere that may intersect the eye plane has no depth.
    let has_depth = c(projection.depth) + f.center > R::ZERO;
    let far = [far[0], has_depth.pick(far[1], c(BEYOND))];
    Roots { near: [low, high], far, hits, misses: weighed.disc < -weighed.error, inside: false }
}

/// The answer for the winner, with its bounds.
#[inline(always)]
pub(crate) fn projected_answer<R: Number>(
    s: &Slopes<R>,
    projection: &ProjectionRecord,
    f: &Projected<R>,
    terms: &Terms,
) -> Answer<R> {
    let c = R::from_f32;
    let Solved { weighed, root, most, least, along, total, length, mixed, blur, low, hits } =
        solved(s, projection, f, terms);
    let Weighed { o: [dx, dy], o2, .. } = weighed;
    let high = f.center - (along + least) * length + blur;
    let k = (along + root) * s.inverse;
    let normal = unit3([dx - k * s.x, dy - k * s.y, k]);
    let off = s.a.sqrt() * (mixed + (most - least)) * s.inverse
        + c(UNIT) * c(TURN) * (total + o2.sqrt())
        + c(projection.edge);
    let sure = hits & (off < c(NORMAL) * f.rho);
    let depth_interval = (high - low + blur) * c(INFLATE);
    Answer {
        sure,
        hits,
        id: f.id,
        offset: -(along + root) * length,
        low,
        high,
        depth_interval,
        normal,
        #[cfg(test)]
        turn: (off / f.rho + c(UNIT) * c(SURFACE)) * c(INFLATE),
    }
}
