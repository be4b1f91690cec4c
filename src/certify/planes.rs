//! Planes that cut spheres, as rays pass them in f32 with bounds: the part of a ray that they keep, and what is hit of a sphere there.
//! docs/certificate.md, section 9a, derives the bounds.

use super::answer::{Answer, ProjectionRecord, Slopes};
use super::constants::{BEYOND, INFLATE, PLANE_QUOTIENT, UNIT, VANISH};
use super::general::GeneralRecord;
use super::projected::Roots;
use super::projection::ProjectionBounds;
use super::terms::Terms;
use super::tiles::Lists;
use crate::double_double as dd;
use crate::number::{Mask, Number};
use crate::scene::{Cuts, Spheres};
use crate::view::View;
use crate::view::planes::{EyePlane, EyePlanes};
use crate::view::ray::{NONE, dot3};
use bytemuck::{Pod, Zeroable};
use halfline_ground::parallel::{self, CHEAP};
use std::cmp::Ordering;

/// Error of the host in a numerator and a denominator, relative to the sizes of their terms: at most 9 roundings, the roundings
/// of the axes among them. Section 9a.
const HOST: f64 = 8.0 * f64::EPSILON;

/// The largest size of a numerator: its error leaves room for the quotient by the error of a denominator, which is at least 2^-49 as N
/// has a length of 1 at least. Section 9a.
const MOST: f64 = (1u128 << 90) as f64;

/// The largest size of a denominator times the reach of cut spheres, which leaves room for the factors of their product. Section 9a.
const MOST_REACH: f64 = (1u128 << 120) as f64;

/// A plane N.p = D as the rays of a view meet it: at the depth (relative to the reference) of a numerator over a denominator, both
/// linear in the pixel. Declared in shaders/certify/planes.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct PlaneRecord {
    /// Value at the middle pixel, per column, and per row; and a bound of the host's error.
    pub(super) num: [f32; 4],
    pub(super) den: [f32; 4],
    /// N / |N| to the right, up and back.
    pub(crate) normal: [f32; 3],
    /// [`HOLDS_EYE`], [`OUT_OF_RANGE`].
    pub(super) state: u32,
}

/// The state of a plane that holds the eye exactly, from which all rays come.
pub(crate) const HOLDS_EYE: u32 = 1;
/// The state of a plane whose numbers f32 does not hold.
pub(crate) const OUT_OF_RANGE: u32 = 2;

/// The numbers of planes that do not depend on the ray, declared in shaders/certify/planes.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct PlaneHead {
    /// Column and row of the middle pixel.
    pub(crate) middle: [i32; 2],
    /// Above the distance of every point of a cut sphere in a list from the reference depth, in front of the eye.
    pub(crate) reach: f32,
    /// The number of planes.
    pub(crate) count: u32,
}

/// The planes of a frame.
#[derive(Debug, Clone)]
pub(crate) struct PlaneRecords {
    pub(crate) head: PlaneHead,
    pub(crate) planes: Vec<PlaneRecord>,
    /// The rank of the sphere of each entry in lists of tiles.
    pub(super) of_entries: Vec<u32>,
}

/// The order of spheres that planes cut, by radius and id. A sphere's rank is its place there, from 1 on; 0 for a whole one. Of several
/// faces at one place the face of the least rank shows.
#[derive(Debug, Clone)]
pub(crate) struct Ranks {
    /// The rank of each sphere.
    of: Vec<u32>,
    /// The cut spheres in order.
    pub(crate) ids: Vec<u32>,
    /// The largest radius of a cut sphere.
    largest: f64,
}

impl Ranks {
    pub(crate) fn new(spheres: &Spheres, cuts: &Cuts) -> Self {
        let mut ids: Vec<u32> = parallel::collect(spheres.len(), CHEAP, &|range, out| {
            out.extend(range.map(|n| n as u32).filter(|id| cuts.is_cut(*id)));
        });
        let radius = |id: &u32| spheres.radii[*id as usize];
        parallel::sort(&mut ids, |a, b| radius(a).total_cmp(&radius(b)).then(a.cmp(b)));
        let mut of = vec![0; spheres.len()];
        (1..).zip(&ids).for_each(|(rank, id)| of[*id as usize] = rank);
        let largest = ids.last().map_or(0.0, radius);
        Self { of, ids, largest }
    }

    /// The rank of a sphere.
    pub(crate) fn rank(&self, id: u32) -> u32 {
        self.of.get(id as usize).copied().unwrap_or_default()
    }

    /// Writes the ranks of general spheres into their records.
    pub(super) fn mark(&self, generals: &mut [GeneralRecord]) {
        generals.iter_mut().for_each(|general| general.rank = self.rank(general.id));
    }
}

impl PlaneRecords {
    /// The planes of a view of spheres in these lists, whose centres have depths up to `deepest`.
    pub(super) fn new(
        (cuts, ranks): (&Cuts, &Ranks),
        view: &View,
        projection: &ProjectionBounds,
        (lists, generals): (&Lists, &[GeneralRecord]),
        (reference, deepest): (f32, f64),
    ) -> Self {
        let middle = [view.record.width, view.record.height].map(|n| (n / 2) as i32);
        let largest = dd::ldexp(ranks.largest, -view.unit);
        let deep =
            |GeneralRecord { center_radius: [.., z, r], scale, .. }: &GeneralRecord| f64::from((z.abs() + r) * scale);
        let deepest = generals.iter().map(deep).fold(deepest + largest, f64::max);
        let reach = (deepest.max(reference.into()) * f64::from(INFLATE)) as f32;
        let one =
            |plane: &EyePlane| PlaneRecord::new(plane, view, projection, (middle, reference.into(), reach.into()));
        let planes: Vec<PlaneRecord> = EyePlanes::new(cuts, view.basis.e).iter().map(one).collect();
        let of_entries = parallel::map(&lists.details, |detail| ranks.rank(detail.id));
        Self { head: PlaneHead { middle, reach, count: planes.len() as u32 }, planes, of_entries }
    }
}

impl PlaneRecord {
    fn new(
        plane: &EyePlane,
        view: &View,
        projection: &ProjectionBounds,
        (middle, reference, reach): ([i32; 2], f64, f64),
    ) -> Self {
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
        let eye = if *side == Ordering::Equal && !projection.parallel { HOLDS_EYE } else { 0 };
        if sizes.iter().any(|size| *size > MOST) || sizes[1] * reach > MOST_REACH {
            return Self { normal, state: eye | OUT_OF_RANGE, ..Self::zeroed() };
        }
        let linear = |[start, right, down]: [f64; 3], size: f64| {
            [start as f32, right as f32, down as f32, (HOST * size) as f32 * INFLATE]
        };
        Self { num: linear(num, sizes[0]), den: linear(den, sizes[1]), normal, state: eye }
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
        head: &PlaneHead,
        (projection, terms): (&ProjectionRecord, &Terms),
    ) -> Self {
        let c = R::from_f32;
        let (dx, dy) = (R::from_i32(s.column - head.middle[0]), R::from_i32(s.row - head.middle[1]));
        let [of_start, of_steps] = terms.along.map(c);
        let sum = |[start, right, down, blur]: [f32; 4]| {
            let (start, right, down) = (c(start), dx * c(right), dy * c(down));
            let sizes = of_start * start.abs() + of_steps * (right.abs() + down.abs());
            (start + right + down, (c(UNIT) * sizes + c(blur) + c(VANISH)) * c(INFLATE))
        };
        let (num, num_error) = sum(plane.num);
        let (den, den_error) = sum(plane.den);
        let (size, width) = (num.abs(), den.abs());
        let [holds_eye, unknown] = [HOLDS_EYE, OUT_OF_RANGE].map(|state| plane.state & state != 0);
        // A plane that no part of the ray within reach of the spheres passes.
        let far = ((width + den_error) * c(head.reach) * c(INFLATE)).less(size - num_error);
        let clear = !far & (den_error + den_error).less(width);
        let at = num / clear.pick(den, R::ONE);
        let error = ((num_error + at.abs() * den_error) / clear.pick(width - den_error, R::ONE)
            + c(UNIT * PLANE_QUOTIENT) * at.abs()
            + c(VANISH))
            * c(INFLATE);
        let place = [at - error, at + error];
        let eye = -c(projection.depth);
        let leaves = clear & R::ZERO.less(den);
        let enters = clear & den.less(R::ZERO);
        // Behind the eye, or through it.
        let behind = place[1].less(eye) | holds_eye;
        let ahead = enters & !behind;
        let later = ahead & self.entry[1].less(place[0]);
        let sooner = ahead & place[1].less(self.entry[0]);
        let doubtful = (ahead & !later & !sooner) | !(far | clear) | unknown;
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
