//! Bounds of the projections of all spheres in a box, so that the group passes without them. Every bound is the operations of
//! project.rs at the ends of their operands: f64 rounds monotonically, so they bound the rounded numbers of every sphere.
//! docs/certificate.md, section 11, derives them.

use super::project::{Pixels, below, floor};
use super::{INFLATE, LONGEST, ProjectionBounds, RANGE, STEEPEST, U, U64, WIDEST};
use crate::number::{larger, smaller};
use crate::scene::instances::enclosure::Enclosure;

/// The projections of the spheres in a box.
pub(in crate::certify) enum Enclosed {
    /// Each of them is behind the eye plane, or is projected outside of the image.
    Unseen,
    /// None is general. The pixels of each that is projected are among these, and its least depth is no smaller.
    Projected { least: f32, pixels: Pixels },
    /// Every ray misses each of them by far, whichever form it has.
    Missed,
    /// They may be anything.
    Unknown,
}

/// The distance of a box from all rays, relative to that from the eye, at which every bound of the kernel proves that they miss:
/// the square of it is 2^-8, and the bounds are below 2^-16 for rays of |d|^2 up to `NARROW`. Section 11.
const MISS_DISTANCE: f64 = 1.0 / 16.0;
/// The largest |d|^2 of rays for which [`MISS_DISTANCE`] is derived. Section 11.
const NARROW: f64 = 16.0;

/// More than the rounding of the f64 expressions whose operands are not joined monotonically: 2^-50 and less.
/// Section 11.
const SLACK: f64 = 1.0 / (1u64 << 44) as f64;

/// Pixels that the place of a projected centre may move by when it is computed in double-double, beside its bound.
/// Section 11.
const MOVED: f64 = 1.0 / (1 << 20) as f64;

impl ProjectionBounds {
    /// The least and the largest depth of the centres, in the frame's unit, as they are computed.
    pub(in crate::certify) fn depths(&self, around: &Enclosure) -> [f64; 2] {
        around.along(self.scaled_axes[2], self.basis.e)
    }

    /// The sum of the largest |c - e| along each axis of the world.
    #[inline(always)]
    fn away(&self, around: &Enclosure) -> f64 {
        let most = around.away(self.basis.e)[0];
        most.x + most.y + most.z
    }

    /// Bounds of the projections of the spheres in a box.
    #[inline(always)]
    pub(in crate::certify) fn enclose(&self, around: &Enclosure) -> Enclosed {
        match self.project_box(around) {
            Enclosed::Unknown if self.misses(around) => Enclosed::Missed,
            known => known,
        }
    }

    /// [`Self::enclose`] without the comparison of the box with the sides of the image.
    #[inline(always)]
    fn project_box(&self, around: &Enclosure) -> Enclosed {
        let [x, y, [near, far]] = self.scaled_axes.map(|axis| around.along(axis, self.basis.e));
        let [least_r, most_r] = around.radii.map(|radius| radius * self.to_frame);
        let error = self.rotated * self.away(around);
        let size = |[low, high]: [f64; 2]| larger(high.abs(), low.abs());
        let deepest = size([near, far]);
        if far + most_r + error + 2.0 * U64 * (deepest + most_r) < 0.0 {
            return Enclosed::Unseen;
        }
        let lengths2 = size(x) * size(x) + size(y) * size(y) + far * far;
        let in_front = near > 1.001 * most_r
            && near * near > 4.0 * most_r * most_r
            && lengths2 < 4096.0 * near * near
            && self.widest <= WIDEST;
        if !(in_front || self.parallel) {
            return Enclosed::Unknown;
        }
        let inverse = if self.parallel { [1.0; 2] } else { [1.0 / far, 1.0 / near] };
        let rho = [least_r * inverse[0] * self.per_unit, most_r * inverse[1] * self.per_unit];
        let blurred = self.low.blurred(rho[1] as f32);
        let ranged = rho[0] >= RANGE[0]
            && rho[1] < RANGE[1]
            && self.is_in_range(near)
            && self.is_in_range(far)
            && self.total(rho[1], blurred) * self.scale[0] <= STEEPEST;
        // The quotients of the centres' coordinates and depths.
        let q =
            [x, y].map(|[low, high]| [low * inverse[usize::from(low < 0.0)], high * inverse[usize::from(high >= 0.0)]]);
        let blur = self.blur(error * inverse[1], q.map(size));
        if !(ranged && blur <= LONGEST) {
            return Enclosed::Unknown;
        }
        let moved = 2.0 * blur + MOVED;
        let (mut pixels, mut visible, mut outside) = ([[0.0; 2]; 2], true, false);
        for k in 0..2 {
            let [a, b] = q[k].map(|q| self.place(q, k));
            let place = [smaller(a, b) - moved, larger(a, b) + moved];
            let half = self.extent(rho[1], self.edge[k], k);
            let first = -floor(-larger(place[0] - half, self.corner[k]));
            let last = floor(smaller(place[1] + half, self.end[k] - 1.0));
            visible &= first <= last;
            outside |= size(place) >= self.farthest;
            pixels[k] = [first, last];
        }
        if !visible {
            return Enclosed::Unseen;
        }
        if outside {
            return Enclosed::Unknown;
        }
        let coordinates = (size(x) as f32) + (size(y) as f32) + deepest as f32;
        let low = near as f32 - self.low.error(rho[1] as f32, blurred, far as f32, deepest as f32, coordinates);
        let low = f64::from(low);
        let low = f64::from(below(low - low.abs() * SLACK));
        let most = INFLATE * (rho[1] + f64::from(blurred)) * self.length(far);
        let least = low - most - 2.0 * U * (larger(low.abs(), deepest) + most);
        Enclosed::Projected { least: below(least - least.abs() * SLACK), pixels }
    }

    /// Whether [`Self::misses`] is derived for the rays.
    pub(super) fn is_narrow(&self) -> bool {
        !self.parallel && self.widest <= NARROW
    }

    /// Whether every kernel proves for every ray that it misses each sphere in the box, whichever form the sphere has, and
    /// none of them is projected onto the image.
    pub(in crate::certify) fn misses(&self, around: &Enclosure) -> bool {
        if !self.is_narrow() {
            return false;
        }
        let radius = around.radii[1] * self.to_frame;
        let distance = self.away(around) * self.to_frame + radius;
        let [right, up, ahead] = self.scaled_axes;
        [right, up].into_iter().zip(self.edge).any(|(axis, edge)| {
            // Points of rays are within |axis| <= edge ahead. Projected spheres are widened by no more than this.
            let apart =
                radius * (1.0 + 0.5 * edge * edge) * (1.0 + MISS_DISTANCE) + MISS_DISTANCE * distance * edge.hypot(1.0);
            [axis, -axis].into_iter().any(|side| around.along(side - edge * ahead, self.basis.e)[0] > apart)
        })
    }
}
