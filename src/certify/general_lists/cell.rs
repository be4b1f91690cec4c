//! Bounds of the depths at which the rays of a rectangle of pixels hit general spheres, eight spheres at a time in loops
//! that compilers vectorize. docs/certificate.md, section 3b, derives them.

use crate::certify::constants::{
    AC, AC_A, AR2, AR2_A, B2, FAR, G, GG, HOST, HOST_PARTS, INFLATE, START, STEP, SUM, SUM_A, UNIT, VANISH,
};
use crate::certify::general::General;
use crate::certify::projection::ProjectionBounds;
use crate::number::vector::LANES;
use crate::number::{Mask, larger, smaller};
use crate::view::ray::positive;
use pulp::NullaryFnOnce;

/// The relative rounding of a lower bound as the kernel computes it, and of the quotients here: the kernel's is within
/// 2 x 15 u < 2^-18. Section 3b.
const ROUNDED: f64 = 1.0 / (1 << 16) as f64;

/// The rays through a rectangle of pixels of the view's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileBlock {
    /// The middle and half of the extent, in pixels.
    middle: [f64; 2],
    half: [f64; 2],
    /// Middle and half of the extent in slopes.
    slope: [f64; 2],
    reach: [f64; 2],
    /// Largest |slope|.
    most: [f64; 2],
    /// Least and largest |d|^2.
    square: [f64; 2],
}

impl TileBlock {
    /// The rays of the tiles from `first` up to `ends`, by column and row.
    pub(super) fn new(projection: &ProjectionBounds, first: [u32; 2], ends: [u32; 2]) -> Self {
        let (pixels, size, slopes) = projection.cell(first, ends);
        let middle = pixels.map(|[first, last]| 0.5 * (first + last));
        let half = pixels.map(|[first, last]| 0.5 * (last - first));
        let across = (2.0 * middle[0] + 1.0 - size[0]) * slopes[0];
        let slope = [across, (size[1] - 1.0 - 2.0 * middle[1]) * slopes[1]];
        let reach = [0, 1].map(|k| 2.0 * slopes[k] * half[k]);
        let most = [0, 1].map(|k| slope[k].abs() + reach[k]);
        let least = [0, 1].map(|k| positive(slope[k].abs() - reach[k]));
        let square = [least, most].map(|[x, y]| 1.0 + x * x + y * y);
        Self { middle, half, slope, reach, most, square }
    }

    /// The spheres of `slots` that rays of the cell may hit first. A sphere is dropped if all rays certainly miss it,
    /// or if another certainly covers the cell and is nearer by more than `margin` of its own depth.
    pub(super) fn kept(&self, spheres: &[General<f64>], slots: &[u32], margin: f64) -> Vec<u32> {
        let mut lows = Vec::with_capacity(slots.len());
        let mut least = f64::INFINITY;
        pulp::Arch::new().dispatch(Weigh { cell: self, spheres, slots, lows: &mut lows, least: &mut least });
        let limit = if margin < f64::INFINITY { least * (1.0 + margin) } else { margin };
        let kept = |(slot, low): (&u32, f64)| (low <= limit && low < f64::INFINITY).then_some(*slot);
        slots.iter().zip(lows).filter_map(kept).collect()
    }

    /// The bounds of all spheres.
    #[cfg(test)]
    pub(super) fn all_depths(&self, spheres: &[General<f64>]) -> Vec<[f64; 2]> {
        spheres.iter().map(|near| self.depths(near)).collect()
    }

    /// Bounds of the depths at which the rays of the cell hit one sphere, without branches. The first is below all
    /// lower bounds that the kernel computes, and infinite if all rays certainly miss. The second is above the depths
    /// of all hits if all rays certainly hit, else infinite.
    #[inline(always)]
    fn depths(&self, n: &General<f64>) -> [f64; 2] {
        let c = |constant: f32| f64::from(constant);
        let ([x, y], [hx, hy], [wide, high]) = (self.slope, self.reach, self.most);
        let ([px, py, pz, r], [least_a, most_a]) = (n.center_radius, self.square);
        let square = r * r;
        let hosts = c(HOST_PARTS) * c(HOST) * (wide + high + 1.0);
        // b = p.d is linear in the pixel; b_error is what the kernel's bound is at most.
        let [right, down] = [0, 1].map(|k| (self.middle[k] - f64::from(n.pixel[k])) * n.by[k]);
        let [half_right, half_down] = [0, 1].map(|k| n.by[k].abs() * self.half[k]);
        let steps = right.abs() + half_right + down.abs() + half_down;
        let b_error = (c(UNIT) * (c(START) * n.start.abs() + c(STEP) * steps) + n.blur + hosts) * c(INFLATE);
        let b = n.start + right + down;
        let (least_b, most_b) =
            (b - (half_right + half_down + 2.0 * b_error), b + (half_right + half_down + 2.0 * b_error));
        // The components of g = p x d are linear in the slopes.
        let g = [(-py - pz * y).abs(), (pz * x + px).abs(), (px * y - py * x).abs()];
        let spread = [pz.abs() * hy, pz.abs() * hx, px.abs() * hy + py.abs() * hx];
        let sizes = [py.abs() + pz.abs() * high, pz.abs() * wide + px.abs(), px.abs() * high + py.abs() * wide];
        let (mut least_gg, mut most_gg, mut mixed) = (0.0, 0.0, 0.0);
        for k in 0..3 {
            let (least, most) = (positive(g[k] - spread[k]), g[k] + spread[k]);
            let error = c(G) * c(UNIT) * sizes[k] + hosts;
            least_gg += least * least;
            most_gg += most * most;
            mixed += (2.0 * most + error) * error;
        }
        // The discriminant by both forms; the error of the form that the kernel takes comes twice on top.
        let flushed = most_a * c(VANISH);
        let ball = most_a * square;
        let of_cross = c(UNIT) * ((c(AR2_A) * most_a + c(AR2)) * ball + c(GG) * most_gg) + mixed;
        let of_cross = of_cross * c(INFLATE) + flushed;
        let largest_b = larger(most_b, -least_b);
        let smallest_b = positive(larger(least_b, -most_b));
        let ac = most_a * n.power.abs();
        let of_square = (2.0 * largest_b + b_error) * b_error
            + c(UNIT) * (c(B2) * largest_b * largest_b + (c(AC_A) * most_a + c(AC)) * ac);
        let of_square = of_square * c(INFLATE) + flushed;
        let outside = n.power > 0.0;
        let [nearer, farther] = [n.power * outside.pick(least_a, most_a), n.power * outside.pick(most_a, least_a)];
        let error = 2.0 * (n.form == 1).pick(of_square, of_cross);
        let most = smaller(ball - least_gg + of_cross, largest_b * largest_b - nearer + of_square) + error;
        let least =
            larger(least_a * square - most_gg - of_cross, smallest_b * smallest_b - farther - of_square) - error;
        let (most_root, least_root) = (positive(most).sqrt(), positive(least).sqrt());
        // The eye outside: the near root c / (b + root).
        let near = smaller(n.power / (most_b + most_root) * (1.0 - ROUNDED), c(FAR));
        let near_high = n.power / (least_b + least_root);
        // Inside or on the surface: the far root (b + root) / a, or |c| / (root - b).
        let sum_rounded = 1.0 - (2.0 * c(UNIT) * (c(SUM) + c(SUM_A) * most_a) + ROUNDED);
        let by_sum = (positive(least_b) + least_root) / most_a * sum_rounded;
        let by_quotient = n.power.abs() / (most_root - least_b) * (1.0 - ROUNDED);
        let far = (least_b > 0.0).pick(by_sum, (most_b < 0.0).pick(by_quotient, smaller(by_sum, by_quotient)));
        let sum_high = (most_b + most_root) / least_a;
        let rest = least_root - most_b;
        let far_high = (rest > 0.0).pick(smaller(sum_high, n.power.abs() / rest), sum_high);
        let missed = (n.power >= 0.0) & ((most < 0.0) | (most_b < 0.0));
        let low = outside.pick(near, far) * n.scale;
        // A smaller bound of the kernel may have been flushed to zero.
        let low = (low < c(VANISH)).pick(f64::NEG_INFINITY, low);
        let sure = (n.power < 0.0) | ((least_b > 0.0) & ((n.power == 0.0) | (least > 0.0)));
        let high = outside.pick(near_high, far_high) * n.scale * (1.0 + ROUNDED);
        [missed.pick(f64::INFINITY, low), sure.pick(high, f64::INFINITY)]
    }
}

/// The spheres of a list, eight at a time.
struct Weigh<'a> {
    cell: &'a TileBlock,
    spheres: &'a [General<f64>],
    slots: &'a [u32],
    /// The lower bounds of depth of all of them.
    lows: &'a mut Vec<f64>,
    /// The least of the upper bounds.
    least: &'a mut f64,
}

impl NullaryFnOnce for Weigh<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { cell, spheres, slots, lows, least } = self;
        for slots in slots.chunks(LANES) {
            let mut eight = [spheres[slots[0] as usize]; LANES];
            for (near, slot) in eight.iter_mut().zip(slots) {
                *near = spheres[*slot as usize];
            }
            let mut depths = [[0.0; LANES]; 2];
            for l in 0..LANES {
                let [low, high] = cell.depths(&eight[l]);
                (depths[0][l], depths[1][l]) = (low, high);
            }
            lows.extend(&depths[0][..slots.len()]);
            for high in &depths[1][..slots.len()] {
                *least = smaller(*least, *high);
            }
        }
    }
}
