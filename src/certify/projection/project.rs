//! Spheres in front of the eye plane: projected centre, bounds and tiles, computed eight at a time in loops that
//! compilers vectorize. Spheres that are not clearly in front are handled by [`ProjectionBounds::stage`].

use super::{
    FLUSHED, INFLATE, LONG, LONGEST, LowTerms, ProjectionBounds, RANGE, ROUND, SIGNS, STEEPEST, SUBNORMAL, U, U64,
    WIDEN, WIDEST,
};
use crate::certify::entry::{Bin, Placed};
use crate::certify::projected::{ProjectedDetailRecord, ProjectedRecord};
use crate::double_double::{self as dd, Dd, Dd3};
use crate::number::vector::LANES;
use crate::number::{larger, smaller};
use crate::scene::NumberedBall;
use bytemuck::Zeroable;
use glam::DVec3;
use std::ops::Range;

/// Largest relative error of f64 in the depth of a projected sphere under parallel projection: half of the kernel's
/// bound. Section 3a of docs/certificate.md.
const KNOWN: f64 = 1.0 / (1u64 << 44) as f64;

/// The depth, relative to the reference, of a centre behind all others, which hides nothing. Under parallel projection its hits are never
/// certified: this depth stands for a sphere that may intersect the eye plane. Section 3a of docs/certificate.md.
const NEVER: f64 = -((1u128 << 126) as f64);

/// A sphere before its projection into the image.
#[derive(Default)]
pub(super) struct Aim {
    /// Entirely behind the eye plane.
    pub(super) behind: bool,
    /// Entirely in front of it, with every number in the range of the bounds, in the frame's unit or another.
    pub(super) projected: bool,
    /// The numbers are in the range of the bounds in the frame's unit.
    pub(super) in_range: bool,
    /// Depth of the centre in the frame's unit.
    pub(super) depth: f64,
    /// |x| + |y| + |z| of the centre in the frame's unit, summed in f32 in this order.
    pub(super) coordinates: f32,
    /// The near root is always the hit, and the depth in f64 is as accurate as the kernel assumes.
    pub(super) plain: bool,
    /// Projected radius; square root of twice the bound of the discriminant's error.
    pub(super) rho: f64,
    pub(super) blurred: f32,
    /// Largest slopes of the rays that may hit it.
    pub(super) steepest: [f64; 2],
    /// Projected centre in pixels, and the bound of its f64 error in pixels.
    pub(super) place: [f64; 2],
    pub(super) blur: f64,
}

/// A projected sphere in the image.
pub(in crate::certify) struct Landed {
    /// Some pixel's ray may hit it.
    visible: bool,
    /// The projected centre is too far outside the image for the fixed-point form.
    outside: bool,
    pub(in crate::certify) placed: Placed,
    pub(in crate::certify) bin: Bin,
    pub(in crate::certify) pixels: Pixels,
}

/// The first and last column, and the first and last row, in pixels of the view's frame, of rays that may hit something.
pub(in crate::certify) type Pixels = [[f64; 2]; 2];

/// Eight spheres side by side, as vectors take them.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(in crate::certify) struct LaneBatch {
    /// The number of its spheres. The last one is repeated in the lanes after it, whose results are discarded.
    pub(in crate::certify) count: usize,
    pub(in crate::certify) ids: [u32; LANES],
    pub(in crate::certify) centers: [[f64; 3]; LANES],
    pub(in crate::certify) radii: [f64; LANES],
}

impl LaneBatch {
    /// The batch of no spheres.
    pub(in crate::certify) const NONE: Self =
        Self { count: 0, ids: [0; LANES], centers: [[0.0; 3]; LANES], radii: [0.0; LANES] };

    /// Reads the first eight spheres of a range that is not empty, or all of fewer. Writes them in place: a copy of a batch
    /// waits for the stores of its lanes.
    #[inline(always)]
    pub(in crate::certify) fn fill(&mut self, range: Range<usize>, sphere: impl Fn(usize) -> NumberedBall) {
        self.count = LANES.min(range.len());
        for l in 0..LANES {
            let NumberedBall { id, ball } = sphere(range.start + l.min(self.count - 1));
            (self.ids[l], self.centers[l], self.radii[l]) = (id, ball.center, ball.radius);
        }
    }
}

/// Eight projected spheres, one array per component.
#[derive(Zeroable)]
pub(in crate::certify) struct Eight {
    /// Nonzero if the sphere has a projected record, and some pixel's ray may hit it.
    pub(in crate::certify) projected: [u32; LANES],
    /// Nonzero if [`ProjectionBounds::stage`] has to classify the sphere.
    pub(in crate::certify) other: [u32; LANES],
    pub(in crate::certify) depth: [f64; LANES],
    chunk_min_depth: [f32; LANES],
    tiles: [[u32; LANES]; 4],
    fixed: [[i32; LANES]; 2],
    numbers: [[f32; LANES]; 5],
}

impl Eight {
    pub(in crate::certify) fn bin(&self, l: usize) -> Bin {
        let [left, right, top, bottom] = self.tiles.map(|tile| tile[l]);
        Bin { chunk_min_depth: self.chunk_min_depth[l], tiles: [[left, right], [top, bottom]] }
    }

    /// The bins of all eight; [`Bin::NOWHERE`] for spheres that are not projected.
    #[inline(always)]
    pub(in crate::certify) fn bins(&self) -> [Bin; LANES] {
        let Bin { chunk_min_depth, tiles: [[left, right], [top, bottom]] } = Bin::NOWHERE;
        let mut bins = [Bin::NOWHERE; LANES];
        for (l, bin) in bins.iter_mut().enumerate() {
            let is_projected = self.projected[l] != 0;
            *bin = Bin {
                chunk_min_depth: if is_projected { self.chunk_min_depth[l] } else { chunk_min_depth },
                tiles: [
                    [
                        if is_projected { self.tiles[0][l] } else { left },
                        if is_projected { self.tiles[1][l] } else { right },
                    ],
                    [
                        if is_projected { self.tiles[2][l] } else { top },
                        if is_projected { self.tiles[3][l] } else { bottom },
                    ],
                ],
            };
        }
        bins
    }

    /// The entries of a projected sphere in lists of single tiles.
    #[inline(always)]
    pub(in crate::certify) fn entries(&self, l: usize) -> u64 {
        let [left, right, top, bottom] = [0, 1, 2, 3].map(|k| u64::from(self.tiles[k][l]));
        (right - left + 1) * (bottom - top + 1)
    }

    pub(in crate::certify) fn placed(&self, l: usize, id: u32) -> Placed {
        let [x, y] = self.fixed.map(|fixed| fixed[l]);
        let [rho, low, right, down, center] = self.numbers.map(|number| number[l]);
        Placed {
            record: ProjectedRecord { x, y, rho, low },
            detail: ProjectedDetailRecord { subpixel_offset: [right, down], center, id },
            depth: self.depth[l],
        }
    }
}

impl ProjectionBounds {
    /// Eight spheres, with depths relative to `reference`.
    #[inline(always)]
    pub(in crate::certify) fn eight(&self, batch: &LaneBatch, reference: f64) -> Eight {
        self.eight_and(batch, reference, |_, _| ())
    }

    /// [`Self::eight`], which calls `and` with each lane and its projection.
    #[inline(always)]
    pub(in crate::certify) fn eight_and(
        &self,
        batch: &LaneBatch,
        reference: f64,
        mut and: impl FnMut(usize, &Landed),
    ) -> Eight {
        let mut e = Eight::zeroed();
        for l in 0..LANES {
            let aim = self.aim(batch.centers[l], batch.radii[l]);
            let landed = self.land(&aim, aim.place, [0.0; 2], reference);
            let plain = aim.projected & aim.in_range & (aim.blur <= LONG);
            e.projected[l] = u32::from(plain & landed.visible & !landed.outside);
            e.other[l] = u32::from(!aim.behind & (!plain | landed.visible & landed.outside));
            e.depth[l] = landed.placed.depth;
            e.chunk_min_depth[l] = landed.bin.chunk_min_depth;
            let [[left, right], [top, bottom]] = landed.bin.tiles;
            (e.tiles[0][l], e.tiles[1][l], e.tiles[2][l], e.tiles[3][l]) = (left, right, top, bottom);
            and(l, &landed);
            let (record, detail) = (landed.placed.record, landed.placed.detail);
            (e.fixed[0][l], e.fixed[1][l]) = (record.x, record.y);
            (e.numbers[0][l], e.numbers[1][l]) = (record.rho, record.low);
            (e.numbers[2][l], e.numbers[3][l]) = (detail.subpixel_offset[0], detail.subpixel_offset[1]);
            e.numbers[4][l] = detail.center;
        }
        e
    }

    /// The projection of one sphere; `None` if no ray can hit it; an error if it cannot be represented as a projected
    /// sphere.
    pub(super) fn project(&self, center: [f64; 3], radius: f64, reference: f64) -> Result<Option<Landed>, ()> {
        let aim = self.aim(center, radius);
        if !aim.behind && !aim.in_range { Err(()) } else { self.project_in_any_unit(&aim, center, reference) }
    }

    /// The depth, in the frame's unit, of a sphere that is projected in some unit; else as [`Self::project`].
    pub(in crate::certify) fn depth_in_any_unit(&self, center: [f64; 3], radius: f64) -> Result<Option<f64>, ()> {
        let aim = self.aim(center, radius);
        Ok(self.project_in_any_unit(&aim, center, 0.0)?.map(|landed| landed.placed.depth))
    }

    /// The projection of a sphere, whose numbers in f32 may be out of range.
    fn project_in_any_unit(&self, aim: &Aim, center: [f64; 3], reference: f64) -> Result<Option<Landed>, ()> {
        if aim.behind {
            return Ok(None);
        }
        if !aim.projected {
            return Err(());
        }
        let (mut place, mut low) = (aim.place, [0.0; 2]);
        if aim.blur > LONG {
            // For a narrow field of view, recomputes in double-double, whose error is below 2^-40 of the error of f64.
            if aim.blur > LONGEST {
                return Err(());
            }
            let away: Dd3 = std::array::from_fn(|k| Dd::diff(center[k], self.basis.e[k]).ldexp(-self.frame));
            let [x, y, z] = self.axes.map(|axis| dd::dot(axis, away));
            let q = if self.parallel { [x, y] } else { [x / z, y / z] };
            for k in 0..2 {
                let at = q[k] / self.slope[k].into() * SIGNS[k].into() + (self.size[k] - 1.0).into();
                (place[k], low[k]) = (0.5 * at.hi, 0.5 * at.lo);
            }
        }
        let landed = self.land(aim, place, low, reference);
        match (landed.visible, landed.outside) {
            (false, _) => Ok(None),
            (true, true) => Err(()),
            (true, false) => Ok(Some(landed)),
        }
    }

    /// The centre in camera space, in f64 and the frame's unit, and its error bound.
    #[inline(always)]
    fn aim(&self, center: [f64; 3], radius: f64) -> Aim {
        let away = DVec3::from_array(center) - self.basis.e;
        let [x, y, z] = self.scaled_axes.map(|axis| away.dot(axis));
        let radius = radius * self.to_frame;
        let error = self.rotated * (away.x.abs() + away.y.abs() + away.z.abs());
        let length2 = x * x + y * y + z * z;
        let in_front = (z > 1.001 * radius)
            & (length2 > 4.0 * radius * radius)
            & (length2 < 4096.0 * z * z)
            & (self.widest <= WIDEST);
        let inverse = if self.parallel { 1.0 } else { 1.0 / z };
        let rho = radius * inverse * self.per_unit;
        #[expect(clippy::manual_range_contains, reason = "both are evaluated, so that there is no branch")]
        let small = |x: f64| (x >= RANGE[0]) & (x < RANGE[1]);
        let blurred = self.low.blurred(rho as f32);
        let ranged = small(rho) & (self.total(rho, blurred) * self.scale[0] <= STEEPEST);
        let q = [x * inverse, y * inverse];
        let reach = self.reach(rho);
        let behind = z + radius + error + 2.0 * U64 * (z.abs() + radius) < 0.0;
        Aim {
            behind,
            projected: (in_front | self.parallel & !behind) & ranged,
            in_range: self.is_in_range(z),
            depth: z,
            coordinates: (x as f32).abs() + (y as f32).abs() + (z as f32).abs(),
            plain: !self.parallel | ((z - radius > 2.0 * error + 4.0 * U64 * z) & (error < KNOWN * z)),
            rho,
            blurred,
            // Slopes of the rays that may hit it: the slopes of its centre plus its extent.
            steepest: [0, 1].map(|k| smaller(q[k].abs() + reach * self.unit, self.edge[k])),
            // u = (2 j + 1 - W) slope, v = (H - 1 - 2 i) slope, with rows counted downwards. The rounding error is at
            // most 2^-29 pixels, for centres up to 2^22 pixels from the image.
            place: [0, 1].map(|k| self.place(q[k], k)),
            blur: self.blur(error * inverse, q.map(f64::abs)),
        }
    }

    /// The pixel of a slope along an axis.
    #[inline(always)]
    pub(super) fn place(&self, slope: f64, axis: usize) -> f64 {
        0.5 * (self.size[axis] - 1.0) + SIGNS[axis] * slope * self.per_slope[axis]
    }

    /// The bound in pixels of the error of a projected centre with slopes of these sizes, whose coordinates have an error of `far`
    /// per depth.
    #[inline(always)]
    pub(super) fn blur(&self, far: f64, slopes: [f64; 2]) -> f64 {
        // The error of a quotient includes the error of its divisor.
        let tilt = if self.parallel { 0.0 } else { 1.0 };
        let blur = [0, 1].map(|k| (far * (1.0 + tilt * slopes[k]) + 4.0 * U64 * slopes[k]) * self.per_slope[k]);
        larger(blur[0], blur[1])
    }

    /// The record, the bin and the pixels of a sphere whose projected centre is at `place` + `low`, in pixels.
    #[inline(always)]
    fn land(&self, aim: &Aim, place: [f64; 2], low: [f64; 2], reference: f64) -> Landed {
        let mut visible = true;
        let mut outside = false;
        let (mut fixed, mut subpixel_offset) = ([0; 2], [0.0; 2]);
        let (mut tiles, mut pixels) = ([[0; 2]; 2], [[0.0; 2]; 2]);
        for k in 0..2 {
            let half = self.extent(aim.rho, aim.steepest[k], k);
            let first = -floor(-larger(place[k] - half, self.corner[k]));
            let last = floor(smaller(place[k] + half, self.end[k] - 1.0));
            visible &= first <= last;
            outside |= place[k].abs() >= self.farthest;
            fixed[k] = whole(place[k] * self.fixed);
            let pixel = fixed[k].wrapping_add(1 << (self.shift - 1)) >> self.shift;
            subpixel_offset[k] = (SIGNS[k] * ((place[k] - f64::from(pixel)) + low[k])) as f32;
            pixels[k] = [first, last];
            // Adding half a pixel keeps the quotient far from integers, so its rounding does not matter.
            tiles[k] = [first, last].map(|pixel| whole(floor((pixel - self.corner[k] + 0.5) * self.per_tile)) as u32);
        }
        let center = aim.depth - reference;
        let more = if aim.plain { center } else { NEVER };
        let rho = aim.rho as f32;
        let low = self.low.of(rho, aim.blurred, aim.depth as f32, center as f32, aim.coordinates);
        // The kernel's lower bound is low minus T size / a. Unless it is a miss, m^2/s^2 + D <= a rho^2 + 2 E, so T/a =
        // (m + sqrt D)/a <= rho + sqrt(2 E) by Cauchy-Schwarz for every ray of the image.
        let size = self.length(f64::from(low) + reference);
        let most = INFLATE * (aim.rho + f64::from(aim.blurred)) * size;
        let chunk_min_depth = f64::from(low) - most - 2.0 * U * (f64::from(low).abs() + most);
        Landed {
            visible,
            outside,
            placed: Placed {
                record: ProjectedRecord { x: fixed[0], y: fixed[1], rho, low },
                detail: ProjectedDetailRecord { subpixel_offset, center: more as f32, id: 0 },
                depth: aim.depth,
            },
            bin: Bin { chunk_min_depth: below(chunk_min_depth), tiles },
            pixels,
        }
    }

    /// Half the extent in the image of a sphere whose rays are no steeper than this along an axis, in pixels: a ray that
    /// hits has |o|^2 + (slopes x o)^2 <= a rho^2, so o_k^2 <= (1 + slope_k^2) rho^2; and sqrt(1 + x) <= 1 + x / 2. Beyond
    /// it the kernel's discriminant is a certain miss, so no answer depends on which rays near it test the sphere.
    #[inline(always)]
    pub(super) fn extent(&self, rho: f64, steepest: f64, axis: usize) -> f64 {
        (rho + self.wider) * (1.0 + 0.5 * steepest * steepest) * self.per_step[axis] + WIDEN[0]
    }

    /// The unit of rho as a length at that depth.
    #[inline(always)]
    pub(super) fn length(&self, depth: f64) -> f64 {
        depth * self.scale[0] + self.scale[1]
    }

    /// The offset from the projected centre beyond which a miss is certain with any rounding.
    #[inline(always)]
    pub(super) fn reach(&self, rho: f64) -> f64 {
        std::f64::consts::SQRT_2 * self.steep * rho + 16.0 * self.widest * self.coarse
    }

    /// An upper bound of |slope along the offset| + root of a candidate.
    #[inline(always)]
    pub(super) fn total(&self, rho: f64, blurred: f32) -> f64 {
        self.slant * self.reach(rho) + self.steep * rho + f64::from(blurred)
    }
}

impl LowTerms {
    /// A lower bound of the depth from which the kernel subtracts the hit's offset, relative to the reference: the centre's
    /// depth minus the bound of all errors. `depth` is the centre's own; `coordinates` are |x| + |y| + |z|. The twin of
    /// shaders/place/low.wgsl; a bound under any rounding.
    #[inline(always)]
    pub(super) fn of(&self, rho: f32, blurred: f32, depth: f32, center: f32, coordinates: f32) -> f32 {
        center - self.error(rho, blurred, depth, center.abs(), coordinates)
    }

    /// The square root of twice the bound of the discriminant's error.
    #[inline(always)]
    pub(super) fn blurred(&self, rho: f32) -> f32 {
        (self.blurred[0] + rho * (self.blurred[1] + rho * self.blurred[2])).sqrt()
    }

    /// The bound of all errors of that depth. It grows with every argument.
    #[inline(always)]
    pub(super) fn error(&self, rho: f32, blurred: f32, depth: f32, center: f32, coordinates: f32) -> f32 {
        let size = depth * self.scale[0] + self.scale[1];
        let offset = self.offset[0] + rho * self.offset[1] + blurred * self.offset[2];
        let error = size * offset + center * self.center + coordinates * self.coordinates;
        // The kernel takes the size from this bound, which makes it smaller by the error.
        let total = self.total[0] + rho * self.total[1] + blurred;
        error / (1.0 - total * self.scale[0]) + FLUSHED as f32
    }
}

/// The largest integer not above x, for |x| < 2^51. Without an instruction for it, `floor` would be a function call.
#[inline(always)]
pub(super) fn floor(x: f64) -> f64 {
    let near = (x + ROUND) - ROUND;
    if near > x { near - 1.0 } else { near }
}

/// x rounded to an integer, for |x| < 2^31.
#[inline(always)]
pub(super) fn whole(x: f64) -> i32 {
    (x + ROUND).to_bits() as i32
}

/// An f32 that is at most x, and close to it: one ulp is subtracted before the rounding, which adds at most half an
/// ulp.
#[inline(always)]
pub(super) fn below(x: f64) -> f32 {
    (x - (x.abs() * U + SUBNORMAL)) as f32
}
