//! The host's part of the certificate, sphere by sphere: into the camera in f64, projected centre or power, the bounds of what
//! f32 and the host's own rounding can do to it, and the tiles that its rays lie in. docs/certificate.md derives it all.

use super::front::{FrontMoreRecord, FrontRecord};
use super::near::NearRecord;
use super::tiles::{Bin, Placed, TILE};
use super::{LensRecord, Terms};
use crate::camera::{Basis, Camera, Viewport};
use crate::dd::{self, Dd, Dd3};
use crate::error::Result;
use crate::exact;
use crate::view::View;
use glam::DVec3;

/// The unit roundoff of WGSL: 2^-23, since it may round either way.
const U: f64 = 1.0 / (1u64 << 23) as f64;
/// The host's: half an ulp of f64.
const U64: f64 = 1.0 / (1u64 << 53) as f64;
/// Error of c - e rotated in f64, per component, relative to |c - e|_1: subtraction, basis, product, two sums.
const ROTATED: f64 = 5.0 * U64;
/// Largest |d|^2 that the constants of a front sphere's bound were derived for (176 degrees).
const WIDEST: f64 = 1024.0;
/// Farthest pixel that a winner's projected centre or a near sphere's start may have: differences stay exact in f32.
const FARTHEST: f64 = (1 << 22) as f64;
/// Bits of the fixed-point projected centres, sign excluded; a difference to a pixel needs one more.
const FIXED_BITS: u32 = 29;
/// Finest unit of theirs, 2^-25 pixels: half of it is room for the host's error, 2^-27 pixels and a little.
const FINEST: u32 = 25;
/// Largest slope of a front sphere's depth over its centre's: farther in, it counts as near.
const STEEPEST: f64 = 0.75;
/// Least power of the eye, in a near sphere's own unit, that f32 multiplies and divides without loss: 2^-100.
const SMALLEST: f64 = 1.0 / (1u128 << 100) as f64;
/// Error of p.d beside which nothing is certain; its square is still in range.
const UNKNOWN: f32 = (1u64 << 60) as f32;
/// Relative to its depth, how far behind a winner's lower bound the next list entries must begin to be left out: the
/// promised tolerance, or what keeps its proof possible at little cost.
const SLACK: [f64; 2] = [1.0 / (1 << 20) as f64, 1.0 / (1 << 10) as f64];
/// The bounds' own roundings, here and in the kernel.
const INFLATE: f64 = 1.0 + 1.0 / 512.0;
/// Projected radii, and depths of their unit, that f32 squares without loss: 2^-60 to 2^60.
const RANGE: [f64; 2] = [1.0 / (1u64 << 60) as f64, (1u64 << 60) as f64];
/// Columns go with u, rows against v.
const SIGNS: [f64; 2] = [1.0, -1.0];
/// Pixels of error in a projected centre that f64 may leave; and that double-double may start from, 2^40 of these.
const LONG: f64 = 1.0 / (1u64 << 27) as f64;
const LONGEST: f64 = (1 << 13) as f64;
/// 1.5 * 2^52: a sum with it is rounded to a whole number, which is in its last bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// What a sphere's place in the image is widened by, in pixels and relative to its radius: far more than the host's f64
/// is off by (2^-27 pixels, 2^-43), far less than makes a list longer.
const WIDEN: [f64; 2] = [1.0 / (1u64 << 16) as f64, 1.0 + 1.0 / (1u64 << 30) as f64];

/// c - e in world space and in the camera: right, up, forward; in f64.
pub(super) fn moved(basis: &Basis, center: [f64; 3]) -> (DVec3, [f64; 3]) {
    let p = DVec3::from_array(center) - basis.e;
    (p, [p.dot(basis.u), p.dot(basis.v), -p.dot(basis.w)])
}

/// A sphere, staged.
pub(super) enum Staged {
    /// Behind the eye plane, wholly outside the image or between its pixels: no viewing ray meets it.
    Unseen,
    Front(Projected),
    Near(NearRecord),
}

/// A front sphere: depth of its centre in the frame's unit and its host error, projected centre, projected radius.
pub(super) struct Projected {
    pub(super) depth: f64,
    depth_error: f64,
    fixed: [i32; 2],
    rest: [f32; 2],
    rho: f64,
    /// Root of twice the bound of its discriminant's error.
    blurred: f64,
    /// Largest slopes of the rays that may meet it.
    steepest: [f64; 2],
    /// First and last column and row of the tiles in which they are.
    tiles: [[u32; 2]; 2],
}

/// How steep some rays may be: bounds of |(x, y)|, |d| and |d|^2.
struct Steepness {
    slant: f64,
    length: f64,
    square: f64,
}

/// The camera in f64, and the constants of the bounds that are the same for all front spheres.
pub(super) struct Lens {
    basis: Basis,
    /// Right, up and forward in double-double.
    axes: [Dd3; 3],
    size: [f64; 2],
    pub(super) slope: [f64; 2],
    step: [f64; 2],
    /// Slope per unit of rho: a power of two.
    unit: f64,
    /// A pixel is 2^shift units of the fixed-point centres.
    shift: u32,
    /// Largest |d|^2 of the image.
    pub(super) widest: f64,
    all: Steepness,
    /// 1 / (2 slope): pixels for each unit of slope.
    per_slope: [f64; 2],
    /// Largest slopes of the image.
    edge: [f64; 2],
    /// Pixels beyond which a projected centre has no fixed-point form, or differences to it are no longer exact.
    farthest: f64,
    /// 1 / unit; 1 / step and a little more.
    per_unit: f64,
    per_step: [f64; 2],
    /// 2^shift, and 2^-frame.
    fixed: f64,
    to_frame: f64,
    /// Error of a fixed-point centre and of a winner's, unit of rho.
    coarse: f64,
    fine: f64,
    /// Bound of the discriminant's error by powers of rho.
    errors: [f64; 3],
    terms: Terms,
    /// Exponent of the frame's unit.
    frame: i32,
}

impl Lens {
    pub(super) fn new(camera: &Camera, view: &View, viewport: &Viewport, terms: &Terms) -> Result<Self> {
        let [right, up, back] = camera.axes()?;
        let size = [f64::from(view.record.width), f64::from(view.record.height)];
        let slope = [viewport.vw / viewport.d / (2.0 * size[0]), viewport.vh / viewport.d / (2.0 * size[1])];
        let unit = dd::ldexp(1.0, dd::exponent(2.0 * slope[0].max(slope[1])));
        let step = slope.map(|s| 2.0 * s / unit);
        // Centres up to four images away from the image.
        let reach = 4 * view.record.width.max(view.record.height).next_power_of_two();
        let shift = (FIXED_BITS - reach.ilog2()).min(FINEST);
        let edge = [slope[0] * size[0], slope[1] * size[1]];
        let m = (1.0 + edge[0] * edge[0] + edge[1] * edge[1]) * (1.0 + 2f64.powi(-20));
        let host = f64::from(terms.host);
        let diagonal = step[0].hypot(step[1]) * host * (1.0 + 2f64.powi(-20));
        // Rounding to fixed point and what is left of the host's error: half a unit each.
        let coarse = diagonal * 2f64.powi(-(shift as i32));
        // The rest's rounding, 2^-25 since it may be a little more than half, and the host's error, 2^-27 and 2^-28.
        let fine = diagonal * 2.75 * 2f64.powi(-26);
        // Section 2 of docs/certificate.md: R = a1 rho + a2 e, and the roundings within it.
        let [ball, offset] =
            [terms.ball, terms.offset].map(|[alone, each]| f64::from(alone) + f64::from(each) * (m - 1.0));
        let (a1, a2) = ((2.0 * m).sqrt(), 16.0 * m);
        let errors = [
            INFLATE * (U * offset * a2 * a2 + 2.0 * m * a2 + m) * coarse * coarse + 2f64.powi(-90),
            INFLATE * (U * offset * 2.0 * a1 * a2 + 2.0 * m * a1) * coarse,
            INFLATE * U * (ball + offset * a1 * a1),
        ];
        Ok(Self {
            basis: view.basis,
            axes: [right, up, back.map(|x| -x)],
            size,
            slope,
            step,
            unit,
            shift,
            widest: m,
            all: Steepness { slant: (m - 1.0).sqrt(), length: m.sqrt(), square: m },
            per_slope: slope.map(|s| 0.5 / s),
            edge,
            farthest: (dd::ldexp(1.0, (FIXED_BITS - shift) as i32) - 1.0).min(FARTHEST),
            per_unit: 1.0 / unit,
            per_step: step.map(|step| WIDEN[1] / step),
            fixed: dd::ldexp(1.0, shift as i32),
            to_frame: dd::ldexp(1.0, -view.unit),
            coarse,
            fine,
            errors,
            terms: *terms,
            frame: view.unit,
        })
    }

    pub(super) fn record(&self, reference: f32, tolerance: f64) -> LensRecord {
        let fixed = self.step.map(|step| dd::ldexp(step, -(self.shift as i32)));
        LensRecord {
            slope_x: self.slope[0] as f32,
            slope_y: self.slope[1] as f32,
            step_x: self.step[0] as f32,
            step_y: self.step[1] as f32,
            fixed_x: fixed[0] as f32,
            fixed_y: fixed[1] as f32,
            shift: self.shift,
            unit: self.unit as f32,
            error0: not_below(self.errors[0]),
            error1: not_below(self.errors[1]),
            error2: not_below(self.errors[2]),
            edge: not_below(self.fine),
            depth: reference,
            // The width and the comparison are rounded themselves.
            tolerance: (tolerance.min(1.0) * (1.0 - 2f64.powi(-10))) as f32,
            nears: 0,
            slack: tolerance.clamp(SLACK[0], SLACK[1]) as f32,
        }
    }

    pub(super) fn place(&self, id: u32, p: &Projected, reference: f32) -> (Placed, Bin) {
        let center = p.depth - f64::from(reference);
        let low = not_above(center - self.depth_error(p, center));
        // The kernel's lower bound is low minus total times size: at most these, and what rounds.
        let size = (f64::from(low) + f64::from(reference)) * self.unit;
        // Bounds of its own rays, without roots: |(x, y)| <= |x| + |y|, sqrt(1 + x) <= 1 + x / 2.
        let [x, y] = p.steepest;
        let square = (x * x + y * y).min(self.widest - 1.0);
        let rays = Steepness { slant: (x + y).min(self.all.slant), length: 1.0 + 0.5 * square, square: 1.0 + square };
        let most = INFLATE * self.total(p.rho, p.blurred, &rays)[0] * size;
        let sill = f64::from(low) - most - 2.0 * U * (f64::from(low).abs() + most);
        let bin = Bin { sill: not_above(sill), tiles: p.tiles };
        let placed = Placed {
            front: FrontRecord { x: p.fixed[0], y: p.fixed[1], rho: p.rho as f32, low },
            more: FrontMoreRecord { rest: p.rest, center: center as f32, id },
        };
        (placed, bin)
    }

    /// Beyond this offset from the projected centre a miss is certain for `rays`, whatever rounds.
    fn reach(&self, rho: f64, rays: &Steepness) -> f64 {
        std::f64::consts::SQRT_2 * rays.length * rho + 16.0 * rays.square * self.coarse
    }

    /// |slope along the offset| + root of a candidate, at most; and the root alone.
    fn total(&self, rho: f64, blurred: f64, rays: &Steepness) -> [f64; 2] {
        let root = rays.length * rho + blurred;
        [rays.slant * self.reach(rho, rays) + root, root]
    }

    /// Bound of all errors of a candidate's depth, frame's unit.
    fn depth_error(&self, p: &Projected, center: f64) -> f64 {
        let [total, root] = self.total(p.rho, p.blurred, &self.all);
        let slant = self.all.slant;
        let [whole, each, along, of_root, of_center] = self.terms.depth.map(f64::from);
        let roundings = (whole + each * (self.widest - 1.0)) * total
            + along * slant * self.reach(p.rho, &self.all)
            + of_root * root;
        let size = p.depth * self.unit;
        let error = size * (U * roundings + slant * self.coarse) + U * of_center * center.abs() + p.depth_error;
        // The kernel takes the size from the lower bound of the depth, which makes it smaller by this very error.
        INFLATE * error / (1.0 - total * self.unit)
    }

    pub(super) fn stage(&self, id: u32, center: [f64; 3], radius: f64) -> Staged {
        let (away, p) = moved(&self.basis, center);
        let error = ROTATED * (away.x.abs() + away.y.abs() + away.z.abs());
        let [x, y, z] = p;
        if z + radius + error + 2.0 * U64 * (z.abs() + radius) < 0.0 {
            return Staged::Unseen;
        }
        let length2 = x * x + y * y + z * z;
        let front = z > 1.001 * radius && length2 > 4.0 * radius * radius && length2 < 4096.0 * z * z;
        if front
            && self.widest <= WIDEST
            && let Some(staged) = self.project(center, p, error, radius)
        {
            return staged;
        }
        Staged::Near(self.near(id, p, center, radius))
    }

    /// The projected centre; `None` where a number leaves the range of the bounds.
    fn project(&self, center: [f64; 3], [x, y, z]: [f64; 3], error: f64, radius: f64) -> Option<Staged> {
        let inverse = 1.0 / z;
        let rho = radius * inverse * self.per_unit;
        let depth = z * self.to_frame;
        let small = |x: f64| (RANGE[0]..RANGE[1]).contains(&x);
        // The discriminant's bound, as a root.
        let blurred = (2.0 * (self.errors[0] + rho * (self.errors[1] + rho * self.errors[2]))).sqrt();
        if !small(rho) || !small(depth * self.unit) || self.total(rho, blurred, &self.all)[0] * self.unit > STEEPEST {
            return None;
        }
        // Pixels of error that the f64 rotation leaves in the projected centre.
        let far = error * inverse;
        let blur = |q: f64, k: usize| (far * (1.0 + q.abs()) + 4.0 * U64 * q.abs()) * self.per_slope[k];
        let q = [x * inverse, y * inverse];
        // u = (2 j + 1 - W) slope, v = (H - 1 - 2 i) slope: rows count down. 2^-29 pixels are lost here, 2^22 from the
        // image at most.
        let mut place = [0, 1].map(|k| 0.5 * (self.size[k] - 1.0) + SIGNS[k] * q[k] * self.per_slope[k]);
        let mut low = [0.0; 2];
        if blur(q[0], 0).max(blur(q[1], 1)) > LONG {
            // A long lens: once more in double-double, which leaves less than 2^-40 of it.
            let away: Dd3 = std::array::from_fn(|k| Dd::diff(center[k], self.basis.e[k]));
            let [x, y, z] = self.axes.map(|axis| dd::dot(axis, away));
            let q = [x / z, y / z];
            if blur(q[0].hi, 0).max(blur(q[1].hi, 1)) > LONGEST {
                return None;
            }
            for k in 0..2 {
                let at = q[k] / self.slope[k].into() * SIGNS[k].into() + (self.size[k] - 1.0).into();
                (place[k], low[k]) = (0.5 * at.hi, 0.5 * at.lo);
            }
        }
        let reach = self.reach(rho, &self.all);
        // Slopes of the rays that may meet it: those of its centre, and as far beyond as it reaches.
        let steepest = [0, 1].map(|k| (q[k].abs() + reach * self.unit).min(self.edge[k]));
        let mut p = Projected {
            depth,
            depth_error: error * self.to_frame + U64 * depth,
            fixed: [0; 2],
            rest: [0.0; 2],
            rho,
            blurred,
            steepest,
            tiles: [[0; 2]; 2],
        };
        let mut seen = true;
        for k in 0..2 {
            // Where a ray hits, |o|^2 + (slopes x o)^2 <= a rho^2, so that o_k^2 <= (1 + slope_k^2) rho^2; and
            // sqrt(1 + x) <= 1 + x / 2.
            let half = rho * (1.0 + 0.5 * steepest[k] * steepest[k]) * self.per_step[k] + WIDEN[0];
            let (from, to) = (place[k] - half, place[k] + half);
            seen &= to >= 0.0 && from <= self.size[k] - 1.0;
            if place[k].abs() >= self.farthest {
                return (!seen).then_some(Staged::Unseen);
            }
            // Conversions cut off; the first pixel inside is one more, except at a pixel.
            let first = from.max(0.0) as i64;
            let first = first + i64::from((first as f64) < from);
            let last = to.min(self.size[k] - 1.0) as i64;
            seen &= first <= last;
            // Fixed-point centres are far smaller than 2^51.
            let fixed = (place[k] * self.fixed + ROUND).to_bits() as i32;
            let whole = fixed.wrapping_add(1 << (self.shift - 1)) >> self.shift;
            p.fixed[k] = fixed;
            p.rest[k] = (SIGNS[k] * ((place[k] - f64::from(whole)) + low[k])) as f32;
            p.tiles[k] = [first, last].map(|pixel| pixel as u32 / TILE);
        }
        Some(if seen { Staged::Front(p) } else { Staged::Unseen })
    }

    fn near(&self, id: u32, p: [f64; 3], center: [f64; 3], radius: f64) -> NearRecord {
        let away: Dd3 = std::array::from_fn(|k| Dd::diff(center[k], self.basis.e[k]));
        let largest = away.iter().fold(radius, |m, a| m.max(a.hi.abs()));
        let k = dd::exponent(largest);
        let r = dd::ldexp(radius, -k);
        let scaled = away.map(|a| a.ldexp(-k));
        let power = dd::dot(scaled, scaled) - Dd::product(r, r);
        // Double-double is within 2^-92, since the terms are below 16: 2^-32 of a power above 2^-60, far below an ulp of
        // f32. Nearer to the surface only exact arithmetic tells.
        let power = match power.value() {
            sure if sure.abs() > 2f64.powi(-60) => sure,
            _ => exact::power(center, self.basis.e.to_array(), radius, -k),
        };
        // Too small for products in f32, yet not zero: the record says nothing but "perhaps, from depth 0 on".
        let unknown = power != 0.0 && power.abs() < SMALLEST;
        let power = if unknown { 0.0 } else { power };
        // The camera looks down -z.
        let p = [p[0], p[1], -p[2]].map(|x| dd::ldexp(x, -k));
        // p.d at a pixel is start + by_column columns + by_row rows from the pixel nearest to where it vanishes.
        let by = [2.0 * self.slope[0] * p[0], -2.0 * self.slope[1] * p[1]];
        let middle = self.size.map(|n| (n - 1.0) / 2.0);
        let back = p[2] / (by[0] * by[0] + by[1] * by[1]).max(f64::MIN_POSITIVE);
        let pixel = [0, 1].map(|k| (middle[k] + by[k] * back).clamp(-FARTHEST, FARTHEST).round());
        let along = [0, 1].map(|k| (pixel[k] - middle[k]) * by[k]);
        let start = along[0] + along[1] - p[2];
        let slopes = [0, 1].map(|k| (2.0 * self.slope[k] * (pixel[k] - middle[k])).abs());
        NearRecord {
            ball: [p[0] as f32, p[1] as f32, p[2] as f32, r as f32],
            power: power as f32,
            scale: f32::from_bits(((k - self.frame + 127) as u32) << 23),
            form: u32::from(power.abs() <= r * r),
            id,
            column: pixel[0] as i32,
            row: pixel[1] as i32,
            start: start as f32,
            by_column: by[0] as f32,
            by_row: by[1] as f32,
            // 2^-48 of p in every component, and the roundings of start.
            blur: if unknown { UNKNOWN } else { not_below(2f64.powi(-46) * (1.0 + slopes[0] + slopes[1])) },
            unused: [0.0; 2],
        }
    }
}

/// The least f32 that is not below x.
fn not_below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

/// The largest f32 that is not above x.
fn not_above(x: f64) -> f32 {
    -not_below(-x)
}
