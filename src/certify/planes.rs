//! Planes that cut spheres, as rays pass them in f32 with bounds: the part of a ray that they keep, and what is hit of a sphere there.
//! docs/certificate.md, section 9a, derives the bounds.

use super::answer::{Answer, ProjectionRecord, Slopes};
use super::constants::{BEYOND, INFLATE, UNIT, VANISH};
use super::general::{GENERAL, General, GeneralRecord};
use super::projected::Roots;
use super::projection::{ProjectionBounds, UNKNOWN};
use super::terms::Terms;
use super::tiles::Lists;
use crate::double_double as dd;
use crate::number::{Mask, Number};
use crate::scene::{Cuts, Spheres};
use crate::view::View;
use crate::view::planes::{EyePlane, EyePlanes};
use crate::view::ray::{NONE, dot3};
use halfline_ground::parallel::{self, CHEAP};
use std::cmp::Ordering;

/// Error of a quotient in WGSL, and of its product with an error, in multiples of [`UNIT`].
const QUOTIENT: f32 = 4.0;

/// Error of the host in a numerator and a denominator, relative to the sizes of their terms: fewer than 8 roundings, those of the
/// axes among them.
const HOST: f64 = 8.0 * f64::EPSILON;

/// The largest size of a numerator or a denominator, which leaves room for their products with errors.
const MOST: f64 = (1u128 << 100) as f64;

/// A plane N.p = D as the rays of a view meet it: at the depth (relative to the reference) of a numerator over a denominator, both of
/// which are linear in the pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaneRecord {
    /// Value at the middle pixel, per column, and per row.
    pub(super) num: [f32; 3],
    pub(super) den: [f32; 3],
    /// Bounds of the host's errors.
    pub(super) blur: [f32; 2],
    /// Whether the eye from which all rays come is exactly on the plane.
    pub(super) holds_eye: bool,
    /// N / |N| to the right, up and back.
    pub(crate) normal: [f32; 3],
}

/// The planes of a frame, and the order of the faces of its spheres.
#[derive(Debug, Clone)]
pub(crate) struct PlaneRecords {
    pub(crate) planes: Vec<PlaneRecord>,
    /// Column and row of the middle pixel.
    pub(crate) middle: [i32; 2],
    /// Above the distance of every point of a cut sphere in a list from the reference depth, in front of the eye.
    pub(crate) reach: f32,
    /// Of each entry in lists of tiles its sphere's place, from 1 on, among cut ones by radius and id; 0 for whole ones. Of several faces
    /// at one place the least shows.
    ranks: Vec<u32>,
    /// The same of the general spheres, and these as if whole.
    general_ranks: Vec<u32>,
    generals: Vec<GeneralRecord>,
}

impl PlaneRecords {
    /// The planes of a view of spheres in these lists, whose centres have depths up to `deepest`.
    pub(super) fn new(
        (spheres, cuts): (&Spheres, &Cuts),
        view: &View,
        projection: &ProjectionBounds,
        (lists, generals): (&Lists, Vec<GeneralRecord>),
        (reference, deepest): (f32, f64),
    ) -> Self {
        let middle = [view.record.width, view.record.height].map(|n| (n / 2) as i32);
        let one = |plane: &EyePlane| PlaneRecord::new(plane, view, projection, (middle, reference.into()));
        let eye = EyePlanes::new(cuts, view.basis.e);
        let order = by_radius(spheres, cuts);
        let largest = order.last().map_or(0.0, |id| dd::ldexp(spheres.radii[*id as usize], -view.unit));
        let deep =
            |GeneralRecord { center_radius: [.., z, r], scale, .. }: &GeneralRecord| f64::from((z.abs() + r) * scale);
        let deepest = generals.iter().map(deep).fold(deepest + largest, f64::max);
        let reach = deepest.max(reference.into()) * f64::from(INFLATE);
        let mut by_id = vec![0; spheres.len()];
        (1..).zip(order).for_each(|(rank, id)| by_id[id as usize] = rank);
        let rank = |id: u32| by_id.get(id as usize).copied().unwrap_or_default();
        let ranks = parallel::map(&lists.details, |detail| rank(detail.id));
        let general_ranks = generals.iter().map(|general| rank(general.id)).collect();
        let planes = eye.iter().map(one).collect();
        Self { planes, middle, reach: reach as f32, ranks, general_ranks, generals }
    }
}

impl PlaneRecords {
    /// The place of a slot's sphere among cut ones by radius and id, from 1 on; 0 for a whole one.
    #[inline(always)]
    pub(crate) fn rank(&self, slot: u32) -> u32 {
        let place = (slot & !GENERAL) as usize;
        if slot & GENERAL == 0 { self.ranks[place] } else { self.general_ranks[place] }
    }

    /// A general sphere as if whole.
    #[inline(always)]
    pub(crate) fn general<R: Number>(&self, place: u32) -> General<R> {
        General::new(&self.generals[place as usize])
    }
}

/// The cut spheres by radius and id.
fn by_radius(spheres: &Spheres, cuts: &Cuts) -> Vec<u32> {
    let mut order: Vec<u32> = parallel::collect(spheres.len(), CHEAP, &|range, out| {
        out.extend(range.map(|n| n as u32).filter(|id| cuts.is_cut(*id)));
    });
    let radius = |id: &u32| spheres.radii[*id as usize];
    parallel::sort(&mut order, |a, b| radius(a).total_cmp(&radius(b)).then(a.cmp(b)));
    order
}

impl PlaneRecord {
    fn new(plane: &EyePlane, view: &View, projection: &ProjectionBounds, (middle, reference): ([i32; 2], f64)) -> Self {
        let EyePlane { normal, length, gap, side, .. } = plane;
        let basis = view.basis;
        let [right, up, ahead] = [basis.u, basis.v, -basis.w].map(|axis| dot3(*normal, axis.to_array()));
        let gap = dd::ldexp(*gap, -view.unit);
        // Slopes, or for parallel rays lengths, per column and row, and at the middle pixel.
        let steps = [2.0 * projection.slope[0] * right, -2.0 * projection.slope[1] * up];
        let half = [0, 1]
            .map(|k| f64::from(middle[k]) + 0.5 - 0.5 * [view.record.width, view.record.height].map(f64::from)[k]);
        let start = steps[0] * half[0] + steps[1] * half[1];
        let (num, den, sizes) = if projection.parallel {
            let num = [gap - start - reference * ahead, -steps[0], -steps[1]];
            let wide = [0, 1].map(|k| projection.slope[k] * f64::from([view.record.width, view.record.height][k]));
            (num, [ahead, 0.0, 0.0], [gap.abs() + length * (wide[0] + wide[1] + reference), *length])
        } else {
            let den = [ahead + start, steps[0], steps[1]];
            let most = length * (1.0 + projection.edge[0] + projection.edge[1]);
            (
                [gap - reference * den[0], -reference * den[1], -reference * den[2]],
                den,
                [gap.abs() + reference * most, most],
            )
        };
        let normal = [right, up, -ahead].map(|x| (x / length) as f32);
        let holds_eye = *side == Ordering::Equal && !projection.parallel;
        if sizes.iter().all(|size| *size < MOST) {
            let blur = sizes.map(|size| (HOST * size) as f32 * INFLATE);
            Self { num: num.map(|x| x as f32), den: den.map(|x| x as f32), blur, holds_eye, normal }
        } else {
            Self { num: [0.0; 3], den: [0.0; 3], blur: [UNKNOWN; 2], holds_eye, normal }
        }
    }
}

/// The part of a ray that planes keep, by depths relative to the reference.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kept<R> {
    /// Bounds of its begin and its end.
    pub(crate) entry: [R; 2],
    pub(crate) exit: [R; 2],
    /// The plane through which the ray enters; [`NONE`] where it begins at the eye.
    pub(crate) plane: u32,
    /// Whether the planes certainly keep nothing of it.
    pub(crate) is_empty: bool,
    /// Whether the bounds do not tell through which plane it enters, or whether it leaves.
    pub(crate) is_unknown: bool,
}

impl<R: Number> Kept<R> {
    /// All of a ray.
    #[inline(always)]
    pub(crate) fn all(projection: &ProjectionRecord) -> Self {
        let (eye, end) = (-R::from_f32(projection.depth), R::from_f32(BEYOND));
        Self { entry: [eye; 2], exit: [end; 2], plane: NONE, is_empty: false, is_unknown: false }
    }

    /// The part that one more plane, with this index, keeps of it. Every case is computed and one is picked, because compilers make no
    /// vectors of branches.
    #[inline(always)]
    pub(crate) fn cut(
        self,
        s: &Slopes<R>,
        (plane, index): (&PlaneRecord, u32),
        ([column, row], reach): ([i32; 2], f32),
        (projection, terms): (&ProjectionRecord, &Terms),
    ) -> Self {
        let c = R::from_f32;
        let (dx, dy) = (R::from_i32(s.column - column), R::from_i32(s.row - row));
        let [of_start, of_steps] = terms.along.map(c);
        let sum = |[start, right, down]: [f32; 3], blur: f32| {
            let (start, right, down) = (c(start), dx * c(right), dy * c(down));
            let sizes = of_start * start.abs() + of_steps * (right.abs() + down.abs());
            (start + right + down, (c(UNIT) * sizes + c(blur) + c(VANISH)) * c(INFLATE))
        };
        let (num, num_error) = sum(plane.num, plane.blur[0]);
        let (den, den_error) = sum(plane.den, plane.blur[1]);
        let (size, width) = (num.abs(), den.abs());
        // A plane that no part of the ray within reach of the spheres passes.
        let far = ((width + den_error) * c(reach) * c(INFLATE)).less(size - num_error);
        let clear = !far & (den_error + den_error).less(width);
        let at = num / clear.pick(den, R::ONE);
        let error = ((num_error + at.abs() * den_error) / clear.pick(width - den_error, R::ONE)
            + c(UNIT * QUOTIENT) * at.abs()
            + c(VANISH))
            * c(INFLATE);
        let place = [at - error, at + error];
        let eye = -c(projection.depth);
        let leaves = clear & R::ZERO.less(den);
        let enters = clear & den.less(R::ZERO);
        // Behind the eye, or through it.
        let behind = place[1].less(eye) | plane.holds_eye;
        let ahead = enters & !behind;
        let later = ahead & self.entry[1].less(place[0]);
        let sooner = ahead & place[1].less(self.entry[0]);
        let doubtful = (ahead & !later & !sooner) | !(far | clear);
        let entry = [0, 1].map(|k| (ahead & self.entry[k].less(place[k])).pick(place[k], self.entry[k]));
        let exit = [0, 1].map(|k| (leaves & place[k].less(self.exit[k])).pick(place[k], self.exit[k]));
        Self {
            entry,
            exit,
            plane: if later { index } else { self.plane },
            is_empty: self.is_empty | (far & num.less(R::ZERO)) | (leaves & behind),
            is_unknown: self.is_unknown | doubtful,
        }
    }
}

/// The hit of a cut sphere within what planes keep of a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CutLow<R> {
    /// A lower bound of the depth of the hit, or MISS for a certain miss.
    pub(crate) low: R,
    /// Whether it is certainly hit at its near root, from inside at its far one.
    pub(crate) at_root: bool,
    /// Whether it is certainly hit at its face, between the bounds of the part's begin.
    pub(crate) at_face: bool,
}

impl<R: Number> CutLow<R> {
    #[inline(always)]
    pub(crate) fn new(kept: &Kept<R>, roots: &Roots<R>) -> Self {
        let Kept { entry, exit, plane, is_empty, is_unknown } = *kept;
        let Roots { near, far, hits, misses, inside } = *roots;
        // From inside, a ray that no plane lets in hits the far root.
        let from_inside = inside & (plane == NONE) & !is_unknown;
        let first = [0, 1].map(|k| from_inside.pick(far[k], near[k]));
        let gone = misses | is_empty | exit[1].less(entry[0]) | far[1].less(entry[0]) | exit[1].less(first[0]);
        let known = hits & !is_unknown & !gone;
        let low = first[0].less(entry[0]).pick(entry[0], first[0]);
        Self {
            low: gone.pick(R::MISS, low),
            at_root: known & entry[1].less(first[0]) & first[1].less(exit[0]),
            at_face: known & (plane != NONE) & near[1].less(entry[0]) & entry[1].less(far[0]) & entry[1].less(exit[0]),
        }
    }
}

impl<R: Number> Kept<R> {
    /// The answer of a face of a sphere, whose order among others is not decided.
    #[inline(always)]
    pub(crate) fn face(&self, id: u32, normal: [f32; 3]) -> Answer<R> {
        let c = R::from_f32;
        let [low, high] = self.entry;
        let offset = c(0.5) * (low + high);
        Answer {
            sure: true,
            hits: true,
            id,
            offset,
            low,
            high,
            // Half of the width, and the rounding of the middle, which is less than the other half.
            depth_interval: (high - low) * c(INFLATE),
            normal: normal.map(c),
            #[cfg(test)]
            turn: R::ZERO,
        }
    }
}
