//! The host's part of the certificate: the camera in f64 and the constants of its bounds. project.rs has the spheres in
//! front, this file the others, cover.rs what hides what. docs/certificate.md derives it all.

pub(super) mod cover;
pub(super) mod project;

use super::general::GeneralRecord;
use super::{ProjectionRecord, Terms};
use crate::camera::{Basis, Camera, Viewport};
use crate::dd::{self, Dd3};
use crate::error::Result;
use crate::tile::TILE;
use crate::view::{FromEye, View};
use glam::DVec3;
use project::Landed;

/// The unit roundoff of WGSL: 2^-23, since it may round either way.
const U: f64 = 1.0 / (1u64 << 23) as f64;
/// The host's: half an ulp of f64.
const U64: f64 = 1.0 / (1u64 << 53) as f64;
/// Error of c - e rotated in f64, per component, relative to |c - e|_1: subtraction, basis, product, two sums.
const ROTATED: f64 = 5.0 * U64;
/// Largest |d|^2 that the constants of a projected sphere's bound were derived for (176 degrees).
const WIDEST: f64 = 1024.0;
/// Largest |d|^2 whose squares a general sphere's bound can hold; a wider lens is judged exactly.
const UNBOUNDED: f64 = (1u64 << 40) as f64;
/// Least slope that is squared without loss.
const NARROWEST: f64 = 1.0 / (1u128 << 100) as f64;
/// Farthest pixel that a winner's projected centre or a general sphere's start may have: differences stay exact in f32.
const FARTHEST: f64 = (1 << 22) as f64;
/// Bits of the fixed-point projected centres, sign excluded; a difference to a pixel needs one more.
const FIXED_BITS: u32 = 29;
/// Finest unit of theirs, 2^-25 pixels: half of it is room for the host's error, 2^-27 pixels and a little.
const FINEST: u32 = 25;
/// Largest slope of a projected sphere's depth over its centre's: farther in, it counts as near.
const STEEPEST: f64 = 0.75;
/// Least power of the eye, in a general sphere's own unit, that f32 multiplies and divides without loss: 2^-100.
const SMALLEST: f64 = 1.0 / (1u128 << 100) as f64;
/// Error of p.d beside which nothing is certain; its square is still in range.
const UNKNOWN: f32 = (1u64 << 60) as f32;
/// Relative to its depth, how far behind a winner's lower bound the next list entries must begin to be left out: the
/// promised tolerance, or what keeps its proof possible at little cost.
const CULL_MARGIN: [f64; 2] = [1.0 / (1 << 20) as f64, 1.0 / (1 << 10) as f64];
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
/// What f32 rounds subnormals by, and more.
const SUBNORMAL: f64 = 1.0 / (1u128 << 120) as f64 / (1u64 << 20) as f64;
/// What a sphere's place in the image is widened by, in pixels and relative to its radius: far more than the host's f64
/// is off by (2^-27 pixels, 2^-43), far less than makes a list longer.
const WIDEN: [f64; 2] = [1.0 / (1u64 << 16) as f64, 1.0 + 1.0 / (1u64 << 30) as f64];

/// From the world into the camera, in f64 and in the frame's unit.
///
/// The unit is multiplied into the axes: so sums and products are of numbers within 2^122 of 1, whatever the scene's own
/// unit, and what they round is relative to them. (Axes so small that they lose bits below the normal numbers lose 2^-75 of
/// the largest, where their own rounding is 2^-53.)
#[derive(Debug, Clone, Copy)]
pub(super) struct Rotation {
    eye: DVec3,
    /// Right, up, ahead.
    axes: [DVec3; 3],
}

impl Rotation {
    /// For a frame whose unit is 2^`frame`.
    pub(super) fn new(basis: &Basis, frame: i32) -> Self {
        let scaled = |axis: DVec3| DVec3::from_array(axis.to_array().map(|x| dd::ldexp(x, -frame)));
        Self { eye: basis.e, axes: [basis.u, basis.v, -basis.w].map(scaled) }
    }

    /// c - e in world space; and right, up and ahead in the frame's unit.
    #[inline(always)]
    pub(super) fn of(&self, center: [f64; 3]) -> (DVec3, [f64; 3]) {
        let p = DVec3::from_array(center) - self.eye;
        (p, self.axes.map(|axis| p.dot(axis)))
    }
}

/// A sphere, staged.
pub(super) enum Staged {
    /// Behind the eye plane, wholly outside the image or between its pixels: no viewing ray meets it.
    Unseen,
    Projected(Landed),
    General(GeneralRecord),
}

/// How steep the rays of the image are: bounds of |(x, y)|, |d| and |d|^2.
struct Steepness {
    slant: f64,
    length: f64,
    square: f64,
}

/// The camera in f64, and the constants of the bounds that are the same for all projected spheres.
pub(super) struct ProjectionBounds {
    basis: Basis,
    rotation: Rotation,
    /// [`ROTATED`] in the frame's unit.
    rotated: f64,
    /// Right, up and forward in double-double.
    axes: [Dd3; 3],
    size: [f64; 2],
    /// Whether all rays are parallel: slopes are then lengths in the frame's unit, and rays have none.
    parallel: bool,
    pub(super) slope: [f64; 2],
    step: [f64; 2],
    /// Slope per unit of rho: a power of two.
    unit: f64,
    /// Length of the unit of rho in the frame's unit: for each unit of depth, and alone.
    scale: [f64; 2],
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
    /// Pixels of the view's frame along a side of one of the image's; tiles for each of the former.
    per_pixel: f64,
    per_tile: f64,
    /// Error of a fixed-point centre and of a winner's, unit of rho.
    coarse: f64,
    fine: f64,
    /// Bound of the discriminant's error by powers of rho.
    errors: [f64; 3],
    /// The roundings of a candidate's depth: of the total, the slope along the offset, the root and the centre.
    roundings: [f64; 4],
    /// Exponent of the frame's unit.
    frame: i32,
}

impl ProjectionBounds {
    pub(super) fn new(camera: &Camera, view: &View, viewport: &Viewport, terms: &Terms) -> Result<Self> {
        let [right, up, back] = camera.axes()?;
        let size = [f64::from(view.record.width), f64::from(view.record.height)];
        let parallel = viewport.is_parallel();
        let extent = [viewport.vw, viewport.vh].map(|side| match parallel {
            true => dd::ldexp(side, -view.unit),
            false => side / viewport.d,
        });
        let slope = [0, 1].map(|k| extent[k] / (2.0 * size[k]));
        let unit = dd::ldexp(1.0, dd::exponent(2.0 * slope[0].max(slope[1])));
        let step = slope.map(|s| 2.0 * s / unit);
        // Centres up to four images away from the image.
        let reach = 4 * view.record.width.max(view.record.height).next_power_of_two();
        let shift = (FIXED_BITS - reach.ilog2()).min(FINEST);
        let edge = if parallel { [0.0; 2] } else { [slope[0] * size[0], slope[1] * size[1]] };
        let m = match parallel {
            true => 1.0,
            false => (1.0 + edge[0] * edge[0] + edge[1] * edge[1]) * (1.0 + 2f64.powi(-20)),
        };
        let to_frame = dd::ldexp(1.0, -view.unit);
        let host = f64::from(terms.host);
        let diagonal = step[0].hypot(step[1]) * host * (1.0 + 2f64.powi(-20));
        // Rounding to fixed point and what is left of the host's error: half a unit each.
        let coarse = diagonal * 2f64.powi(-(shift as i32));
        // The rest's rounding, 2^-25 since it may be a little more than half, and the host's error, 2^-27 and 2^-28.
        let fine = diagonal * 2.75 * 2f64.powi(-26);
        // Section 2 of docs/certificate.md: R = a1 rho + a2 e, and the roundings within it.
        let [rho2, offset2] =
            [terms.rho2, terms.offset2].map(|[alone, each]| f64::from(alone) + f64::from(each) * (m - 1.0));
        let (a1, a2) = ((2.0 * m).sqrt(), 16.0 * m);
        let errors = [
            INFLATE * (U * offset2 * a2 * a2 + 2.0 * m * a2 + m) * coarse * coarse + 2f64.powi(-90),
            INFLATE * (U * offset2 * 2.0 * a1 * a2 + 2.0 * m * a1) * coarse,
            INFLATE * U * (rho2 + offset2 * a1 * a1),
        ];
        let [whole, each, along, of_root, of_center] = terms.depth.map(f64::from);
        Ok(Self {
            basis: view.basis,
            rotation: Rotation::new(&view.basis, view.unit),
            rotated: ROTATED * to_frame,
            axes: [right, up, back.map(|x| -x)],
            size,
            parallel,
            slope,
            step,
            unit,
            scale: if parallel { [0.0, unit] } else { [unit, 0.0] },
            shift,
            widest: m,
            all: Steepness { slant: (m - 1.0).sqrt(), length: m.sqrt(), square: m },
            per_slope: slope.map(|s| 0.5 / s),
            edge,
            farthest: (dd::ldexp(1.0, (FIXED_BITS - shift) as i32) - 1.0).min(FARTHEST),
            per_unit: 1.0 / unit,
            per_step: step.map(|step| WIDEN[1] / step),
            fixed: dd::ldexp(1.0, shift as i32),
            to_frame,
            per_pixel: view.record.fine().into(),
            per_tile: 1.0 / f64::from(TILE * view.record.fine()),
            coarse,
            fine,
            errors,
            roundings: [whole + each * (m - 1.0), along, of_root, of_center],
            frame: view.unit,
        })
    }

    pub(super) fn record(&self, reference: f32, tolerance: f64) -> ProjectionRecord {
        let fixed = self.step.map(|step| dd::ldexp(step, -(self.shift as i32)));
        let of_rays = if self.parallel { [0.0; 2] } else { self.slope };
        let [unit, alone] = self.scale;
        ProjectionRecord {
            slope_x: of_rays[0] as f32,
            slope_y: of_rays[1] as f32,
            step_x: self.step[0] as f32,
            step_y: self.step[1] as f32,
            fixed_x: fixed[0] as f32,
            fixed_y: fixed[1] as f32,
            shift: self.shift,
            unit: unit as f32,
            error0: not_below(self.errors[0]),
            error1: not_below(self.errors[1]),
            error2: not_below(self.errors[2]),
            edge: not_below(self.fine),
            depth: reference,
            // The width and the comparison are rounded themselves.
            tolerance: (tolerance.min(1.0) * (1.0 - 2f64.powi(-10))) as f32,
            generals: 0,
            cull_margin: tolerance.clamp(CULL_MARGIN[0], CULL_MARGIN[1]) as f32,
            size: (f64::from(reference) * unit + alone) as f32,
        }
    }

    /// Whether f32 can hold the rays and what a general sphere's bound squares.
    pub(super) fn is_bounded(&self) -> bool {
        match self.parallel {
            true => (RANGE[0]..RANGE[1]).contains(&self.scale[1]),
            false => self.slope.iter().all(|slope| *slope >= NARROWEST) && self.widest <= UNBOUNDED,
        }
    }

    /// What a sphere is to the viewing rays, whatever it is; depths are kept relative to `reference`.
    pub(super) fn stage(&self, id: u32, center: [f64; 3], radius: f64, reference: f64) -> Staged {
        match self.project(center, radius, reference) {
            Ok(None) => Staged::Unseen,
            Ok(Some(mut landed)) => {
                landed.placed.detail.id = id;
                Staged::Projected(landed)
            }
            Err(()) if self.parallel => Staged::General(GeneralRecord { id, ..UNKNOWN_SPHERE }),
            Err(()) => Staged::General(self.general(id, center, radius)),
        }
    }

    pub(super) fn general(&self, id: u32, center: [f64; 3], radius: f64) -> GeneralRecord {
        let FromEye { k, offset, radius: r, power } = FromEye::new(self.basis.e, center, radius);
        let power = power.value();
        // Too small for products in f32, yet not zero: the record says nothing but "perhaps, from depth 0 on".
        let unknown = power != 0.0 && power.abs() < SMALLEST;
        let power = if unknown { 0.0 } else { power };
        let away = DVec3::from_array(offset.map(|x| x.hi));
        // The camera looks down -z.
        let p = [self.basis.u, self.basis.v, self.basis.w].map(|axis| away.dot(axis));
        // p.d at a pixel is start + by_column columns + by_row rows from the pixel nearest to where it vanishes.
        let by = [2.0 * self.slope[0] * p[0], -2.0 * self.slope[1] * p[1]];
        let middle = self.size.map(|n| (n - 1.0) / 2.0);
        let back = p[2] / (by[0] * by[0] + by[1] * by[1]).max(f64::MIN_POSITIVE);
        let pixel = [0, 1].map(|k| (middle[k] + by[k] * back).clamp(-FARTHEST, FARTHEST).round());
        let along = [0, 1].map(|k| (pixel[k] - middle[k]) * by[k]);
        let start = along[0] + along[1] - p[2];
        let slopes = [0, 1].map(|k| (2.0 * self.slope[k] * (pixel[k] - middle[k])).abs());
        GeneralRecord {
            center_radius: [p[0] as f32, p[1] as f32, p[2] as f32, r as f32],
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

/// A record that says "perhaps, from depth 0 on" to every ray.
const UNKNOWN_SPHERE: GeneralRecord = GeneralRecord {
    center_radius: [0.0, 0.0, 0.0, 1.0],
    power: 0.0,
    scale: 1.0,
    form: 1,
    id: 0,
    column: 0,
    row: 0,
    start: 0.0,
    by_column: 0.0,
    by_row: 0.0,
    blur: UNKNOWN,
    unused: [0.0; 2],
};

/// The least f32 that is not below x.
fn not_below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}
