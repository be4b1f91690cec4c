//! The host's part of the certificate: the camera in f64 and the constants of its bounds. project.rs handles the
//! spheres in front of the eye plane, stage.rs all others, enclose.rs groups, cover.rs occlusion. docs/certificate.md derives the bounds.

pub(super) mod cover;
pub(super) mod enclose;
pub(super) mod project;
pub(super) mod pyramid;
pub(super) mod stage;

use super::answer::ProjectionRecord;
use super::placing_record::{PlacingRecord, words};
use super::terms::Terms;
use crate::double_double::{self as dd, Dd3};
use crate::scene::camera::{Basis, Camera, ExactViewport};
use crate::tile::TILE;
use crate::view::View;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use halfline_ground::error::Result;

/// The unit roundoff of WGSL: 2^-23, since rounding may go in either direction. Section "The model of f32".
const U: f64 = 1.0 / (1u64 << 23) as f64;
/// The unit roundoff of the host: half an ulp of f64. Section 2.
const U64: f64 = 1.0 / (1u64 << 53) as f64;
/// Error of c - e after rotation in f64, per component, relative to |c - e|_1: subtraction, basis, product, two sums.
/// Section 2.
const ROTATED: f64 = 5.0 * U64;
/// Largest |d|^2 for which the constants of a projected sphere's bound are derived (176 degrees). Section 2.
pub(super) const WIDEST: f64 = 1024.0;
/// Largest |d|^2 whose squares fit a general sphere's bound; wider fields of view are decided exactly.
/// Section "The model of f32".
const UNBOUNDED: f64 = (1u64 << 40) as f64;
/// Smallest slope whose square does not underflow. Section "The model of f32".
const NARROWEST: f64 = 1.0 / (1u128 << 100) as f64;
/// Largest pixel distance of a winner's projected centre or a general sphere's start: differences stay exact in f32.
/// Section 3a.
const FARTHEST: f64 = (1 << 22) as f64;
/// Bits of the fixed-point projected centres without the sign; a difference to a pixel needs one more. Section 3a.
const FIXED_BITS: u32 = 29;
/// Smallest fixed-point unit, 2^-25 pixels: half of it exceeds the host's error of little more than 2^-27 pixels.
/// Section 2.
const FINEST: u32 = 25;
/// Largest slope of a projected sphere's depth relative to its centre's; a steeper sphere is treated as near.
/// Section 2.
const STEEPEST: f64 = 0.75;
/// Smallest power of the eye, in a general sphere's own unit, that f32 multiplies and divides without underflow:
/// 2^-100. Section "The model of f32".
const SMALLEST: f64 = 1.0 / (1u128 << 100) as f64;
/// An error of p.d that makes every answer uncertain, with a square in range. Section 3.
pub(super) const UNKNOWN: f32 = (1u64 << 60) as f32;
/// The least promised tolerance that margins depend on: four units of roundoff. Section 11.
const LEAST_TOLERANCE: f64 = 1.0 / (1 << 21) as f64;
/// Factor from the kernel's cull margin to the host's. Its excess over 1 is many times the rounding of f32, 2^-23.
/// Section 11.
const WIDER: f64 = 1.0 + 1.0 / (1u64 << 8) as f64;
/// Factor for the rounding of the bounds themselves, here and in the kernel. Section 2.
const INFLATE: f64 = 1.0 + 1.0 / 512.0;
/// Range of projected radii that f32 squares without underflow or overflow: 2^-60 to 2^60. Section "The model of f32".
const RANGE: [f64; 2] = [1.0 / (1u64 << 60) as f64, (1u64 << 60) as f64];
/// Range of the length of rho's unit in the frame's unit, 2^-80 to 2^80. The part of a product with such a length that
/// f32 flushes is at most 2^-46 of it, which is less than the error of a depth. Section "The model of f32".
const LENGTHS: [f64; 2] = [1.0 / (1u128 << 80) as f64, (1u128 << 80) as f64];
/// The largest depth in the frame's unit, 2^122. Depths of spheres that the unit is chosen for are below 2^121.
/// Section 11.
const DEEPEST: f64 = (1u128 << 122) as f64;
/// Columns run along u, rows against v.
const SIGNS: [f64; 2] = [1.0, -1.0];
/// Largest error of a projected centre in f64, in pixels. Beyond it the centre is computed in double-double. Section 2.
const LONG: f64 = 1.0 / (1u64 << 27) as f64;
/// Largest error of f64, in pixels, that double-double reduces to [`LONG`]: 2^40 times as large. Section 2.
const LONGEST: f64 = (1 << 13) as f64;
/// 1.5 * 2^52: adding it rounds to an integer, which the last bits of the sum hold.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// 2^-124, above the loss of f32 below its normal numbers in a few operations. It is far below `VANISH`, so no certain
/// depth has it. Section 2.
const FLUSHED: f64 = 16.0 / (1u128 << 127) as f64 / 2.0;
/// An upper bound of the rounding of f32 subnormals. Section 4.
const SUBNORMAL: f64 = 1.0 / (1u128 << 120) as f64 / (1u64 << 20) as f64;
/// The margin of a sphere's extent in the image, in pixels and relative to its radius: far larger than the error of the
/// host's f64 (2^-27 pixels, 2^-43), and too small to lengthen lists. Section 4.
const WIDEN: [f64; 2] = [1.0 / (1u64 << 16) as f64, 1.0 + 1.0 / (1u64 << 30) as f64];

/// The coefficients of the bound of all errors of a candidate's depth. [`Self::error`] combines them; devices do the
/// same (shaders/place/low.wgsl).
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct LowTerms {
    /// The square of `blurred`, by powers of rho.
    pub(crate) blurred: [f32; 3],
    /// The error in the unit of rho: constant, by rho, by `blurred`.
    pub(crate) offset: [f32; 3],
    /// Upper bound of |slope along the offset| + root: constant, and by rho. `blurred` has the factor 1.
    pub(crate) total: [f32; 2],
    /// The length of rho's unit: per unit of depth, and constant.
    pub(crate) scale: [f32; 2],
    /// Factor of the size of the depth relative to the reference.
    pub(crate) center: f32,
    /// Factor of |x| + |y| + |z| of the centre.
    pub(crate) coordinates: f32,
}

/// The camera in f64, and the constants of the bounds that all projected spheres share.
#[derive(Clone)]
pub(super) struct ProjectionBounds {
    basis: Basis,
    /// Right, up and forward with the frame's unit as a factor. So sums and products are of numbers within 2^122 of 1 for any
    /// unit of the scene, and their rounding is relative to them. (Axes that underflow lose 2^-75 of the largest axis, less than
    /// their own rounding of 2^-53.)
    scaled_axes: [DVec3; 3],
    /// [`ROTATED`] in the frame's unit.
    rotated: f64,
    /// Right, up and forward in double-double.
    axes: [Dd3; 3],
    size: [f64; 2],
    /// Whether all rays are parallel. Slopes are then lengths in the frame's unit, and the rays themselves have none.
    pub(super) parallel: bool,
    pub(super) slope: [f64; 2],
    step: [f64; 2],
    /// Slope per unit of rho: a power of two.
    unit: f64,
    /// Length of the unit of rho in the frame's unit: per unit of depth, and constant.
    scale: [f64; 2],
    /// A pixel is 2^shift units of the fixed-point centres.
    shift: u32,
    /// Largest |d|^2 of the image.
    pub(super) widest: f64,
    /// Bounds of |(x, y)| and of |d| of all rays.
    slant: f64,
    steep: f64,
    /// 1 / (2 slope): pixels per unit of slope.
    per_slope: [f64; 2],
    /// Largest slopes of the image.
    pub(super) edge: [f64; 2],
    /// Pixel distance beyond which a projected centre has no fixed-point form, or differences to it are inexact.
    farthest: f64,
    /// 1 / unit; 1 / step, rounded up.
    per_unit: f64,
    per_step: [f64; 2],
    /// 2^shift, and 2^-frame.
    fixed: f64,
    to_frame: f64,
    /// Pixels of the view's frame per side of an image pixel, tiles per pixel of the view's frame, and column and row of
    /// the image's corner in that frame.
    pub(super) per_pixel: f64,
    per_tile: f64,
    corner: [f64; 2],
    /// One past the last column and row of the image in the view's frame.
    end: [f64; 2],
    /// Error of a fixed-point centre, and of a winner's, in the unit of rho.
    coarse: f64,
    fine: f64,
    /// Bound of the discriminant's error, by powers of rho.
    errors: [f64; 3],
    /// Added to rho for a sphere's rectangle, in the unit of rho. Outside the rectangle the kernel's discriminant is a
    /// certain miss.
    wider: f64,
    /// The error of a candidate's depth in f32.
    pub(super) low: LowTerms,
    /// Depths in the frame's unit, from the first to below the second, at which f32 holds the length of rho's unit.
    depths: [f64; 2],
    /// Exponent of the frame's unit.
    pub(super) frame: i32,
}

impl ProjectionBounds {
    /// The bounds for the rays of a view of an image of this size.
    pub(super) fn new(camera: &Camera, view: &View, image: [u32; 2], terms: &Terms) -> Result<Self> {
        let viewport =
            view.viewport.map_or_else(|| camera.viewport(image[0], image[1]).map(ExactViewport::from), Ok)?;
        let corner = [view.record.shift_column, view.record.shift_row].map(f64::from);
        let [right, up, back] = camera.axes()?;
        let size = [f64::from(view.record.width), f64::from(view.record.height)];
        let parallel = viewport.is_parallel();
        let extent = match parallel {
            true => [dd::ldexp(viewport.vw, -view.unit), viewport.height_over(view.unit, 1.0)],
            false => [viewport.vw / viewport.d, viewport.height_over(0, viewport.d)],
        };
        let slope = [0, 1].map(|k| extent[k] / (2.0 * size[k]));
        let unit = dd::ldexp(1.0, dd::exponent(2.0 * slope[0].max(slope[1])));
        let step = slope.map(|s| 2.0 * s / unit);
        // Centres within four image sizes of the image.
        let reach = 4 * view.record.width.max(view.record.height).next_power_of_two();
        let shift = (FIXED_BITS - reach.ilog2()).min(FINEST);
        let edge = if parallel { [0.0; 2] } else { [slope[0] * size[0], slope[1] * size[1]] };
        let m = match parallel {
            true => 1.0,
            false => (1.0 + edge[0] * edge[0] + edge[1] * edge[1]) * (1.0 + 2f64.powi(-20)),
        };
        let to_frame = dd::ldexp(1.0, -view.unit);
        let scaled = |axis: DVec3| DVec3::from_array(axis.to_array().map(|x| dd::ldexp(x, -view.unit)));
        let scaled_axes = [view.basis.u, view.basis.v, -view.basis.w].map(scaled);
        let host = f64::from(terms.host);
        let diagonal = step[0].hypot(step[1]) * host * (1.0 + 2f64.powi(-20));
        // Rounding to fixed point, and the remaining error of the host: half a unit each.
        let coarse = diagonal * 2f64.powi(-(shift as i32));
        // The rounding of the remainder, 2^-25 since it may slightly exceed half a unit, and the host's errors, 2^-27
        // and 2^-28.
        let fine = diagonal * 2.75 * 2f64.powi(-26);
        // Section 2 of docs/certificate.md: R = a1 rho + a2 e, and its own rounding.
        let [rho2, offset2] =
            [terms.rho2, terms.offset2].map(|[alone, each]| f64::from(alone) + f64::from(each) * (m - 1.0));
        let (a1, a2) = ((2.0 * m).sqrt(), 16.0 * m);
        let errors = [
            INFLATE * (U * offset2 * a2 * a2 + 2.0 * m * a2 + m) * coarse * coarse + 2f64.powi(-90),
            INFLATE * (U * offset2 * 2.0 * a1 * a2 + 2.0 * m * a1) * coarse,
            INFLATE * U * (rho2 + offset2 * a1 * a1),
        ];
        let [whole, each, along, of_root, of_center] = terms.depth.map(f64::from);
        let scale = if parallel { [0.0, unit] } else { [unit, 0.0] };
        let (slant, steep) = ((m - 1.0).sqrt(), m.sqrt());
        // R and T of a candidate by powers of rho; T has `blurred` besides.
        let reach = [16.0 * m * coarse, std::f64::consts::SQRT_2 * steep];
        let total = [slant * reach[0], slant * reach[1] + steep];
        let whole = whole + each * (m - 1.0);
        let offset = |k: usize, root: f64| U * (whole * total[k] + along * slant * reach[k] + of_root * root);
        let bound = |x: f64| not_below(INFLATE * x);
        let low = LowTerms {
            blurred: errors.map(|x| bound(2.0 * x)),
            offset: [offset(0, 0.0) + slant * coarse, offset(1, steep), U * (whole + of_root)].map(bound),
            total: total.map(bound),
            scale: scale.map(|x| x as f32),
            // Its rounding to f32, and the rounding of the difference.
            center: bound(U * (of_center + 1.5)),
            // |c - e|_1 is at most sqrt(3) |c - e|; the last is the rounding of the depth itself.
            coordinates: bound((1.7321 * ROTATED + U64) * (1.0 + 2f64.powi(-20))),
        };
        let depths = match parallel {
            false => [LENGTHS[0] / unit, (LENGTHS[1] / unit).min(DEEPEST)],
            // One length at every depth.
            true if (LENGTHS[0]..LENGTHS[1]).contains(&unit) => [f64::NEG_INFINITY, DEEPEST],
            true => [f64::INFINITY; 2],
        };
        let few = errors[0].sqrt();
        let wider = (2.0 * (errors[0] + few * (errors[1] + few * errors[2]))).sqrt() + errors[1];
        Ok(Self {
            basis: view.basis,
            scaled_axes,
            rotated: ROTATED * to_frame,
            axes: [right, up, back.map(|x| -x)],
            size,
            parallel,
            slope,
            step,
            unit,
            scale,
            shift,
            widest: m,
            slant,
            steep,
            per_slope: slope.map(|s| 0.5 / s),
            edge,
            farthest: (dd::ldexp(1.0, (FIXED_BITS - shift) as i32) - 1.0).min(FARTHEST),
            per_unit: 1.0 / unit,
            per_step: step.map(|step| WIDEN[1] * (1.0 + errors[2]) / step),
            fixed: dd::ldexp(1.0, shift as i32),
            to_frame,
            per_pixel: view.record.fine().into(),
            per_tile: 1.0 / f64::from(TILE * view.record.fine()),
            corner,
            end: [0, 1].map(|k| corner[k] + f64::from(image[k] * view.record.fine())),
            coarse,
            fine,
            errors,
            wider,
            low,
            depths,
            frame: view.unit,
        })
    }

    pub(super) fn record(&self, reference: f32, tolerance: f64, generals: usize) -> ProjectionRecord {
        let fixed = self.step.map(|step| dd::ldexp(step, -(self.shift as i32)));
        let of_rays = if self.parallel { [0.0; 2] } else { self.slope };
        let [unit, alone] = self.scale;
        ProjectionRecord {
            slope: of_rays.map(|slope| slope as f32),
            step: self.step.map(|step| step as f32),
            fixed: fixed.map(|step| step as f32),
            shift: self.shift,
            unit: unit as f32,
            errors: self.errors.map(not_below),
            edge: not_below(self.fine),
            depth: reference,
            // The width and the comparison are rounded too.
            tolerance: (tolerance.min(1.0) * (1.0 - 2f64.powi(-10))) as f32,
            generals: generals as u32,
            cull_margin: cull_margin(tolerance) as f32,
            size: (f64::from(reference) * unit + alone) as f32,
            unused: [0.0; 3],
        }
    }

    /// The uniform from which devices place the spheres of an image, with depths relative to `reference`. Records are
    /// computed from its numbers of f64. Its numbers of f32 decide whether the device places a sphere, and in which
    /// pixels.
    pub(super) fn placing_record(&self, reference: f32, image: [u32; 2]) -> PlacingRecord {
        let LowTerms { blurred, offset, total, scale, center, coordinates } = self.low;
        let of_rays = if self.parallel { [0.0; 2] } else { self.slope };
        let above = |x: f64| not_below(x * INFLATE);
        let middle = self.size.map(|size| 0.5 * (size - 1.0));
        PlacingRecord {
            eye: self.basis.e.to_array().map(words),
            axes: self.scaled_axes.map(|axis| axis.to_array().map(words)),
            per_slope: self.per_slope.map(words),
            middle: middle.map(words),
            reference: words(reference.into()),
            low_blurred: blurred,
            low_center: center,
            low_offset: offset,
            low_coordinates: coordinates,
            low_total: total,
            low_scale: scale,
            per_step: self.per_step.map(not_below),
            slope: of_rays.map(|slope| above(2.0 * slope)),
            edge: self.edge.map(not_below),
            reach: [16.0 * self.widest * self.coarse, std::f64::consts::SQRT_2 * self.steep].map(above),
            per_slope_f32: self.per_slope.map(|x| x as f32),
            middle_f32: middle.map(|x| x as f32),
            corner: self.corner.map(|x| x as f32),
            end: self.end.map(|x| x as f32),
            rotated: above(ROTATED),
            wider: above(self.wider),
            farthest: self.farthest as f32,
            per_unit: -dd::exponent(self.unit),
            to_frame: -self.frame,
            shift: self.shift,
            fine: self.per_pixel as u32,
            parallel: u32::from(self.parallel),
            columns: image[0],
            rows: image[1],
            narrow: u32::from(self.is_narrow()),
            unused_a: 0,
        }
    }

    /// First and last column and row, in the view's frame, of the pixels of the tiles from `first` up to `ends`; the
    /// frame's size; and half a pixel's steps of the slopes, which are 0 for parallel rays.
    pub(super) fn cell(&self, first: [u32; 2], ends: [u32; 2]) -> ([[f64; 2]; 2], [f64; 2], [f64; 2]) {
        let pixel = |k: usize, tile: u32| self.corner[k] + f64::from(tile) * f64::from(TILE) * self.per_pixel;
        let pixels = [0, 1].map(|k| [pixel(k, first[k]), pixel(k, ends[k]).min(self.end[k]) - 1.0]);
        (pixels, self.size, if self.parallel { [0.0; 2] } else { self.slope })
    }

    /// Whether f32 can represent depths of this size and the length of rho's unit there. No other condition on a sphere depends on the
    /// frame's unit.
    #[inline(always)]
    pub(super) fn is_in_range(&self, depth: f64) -> bool {
        (depth >= self.depths[0]) & (depth < self.depths[1])
    }

    /// Whether the choice of the unit decides nothing: spheres whose sizes have exponents from -`span` to `span` in the
    /// frame's unit are in the range of the bounds in every unit between the least and the largest size.
    pub(super) fn is_same_in_units(&self, span: i32) -> bool {
        // The depth of a projected centre is at least 2^-7 of its largest coordinate.
        let most = 2 * span + 8;
        let unit = self.scale[0] + self.scale[1];
        [-most, most].into_iter().all(|k| (LENGTHS[0]..LENGTHS[1]).contains(&dd::ldexp(unit, k)))
    }

    /// Whether f32 can represent the rays and the squares in a general sphere's bound.
    pub(super) fn is_bounded(&self) -> bool {
        match self.parallel {
            true => self.is_in_range(0.0),
            false => self.slope.iter().all(|slope| *slope >= NARROWEST) && self.widest <= UNBOUNDED,
        }
    }
}

/// The cull margin: the distance behind a hit, relative to its depth, beyond which spheres are left out of lists and of
/// blocks, and beyond which a ray skips the rest of its list. An answer whose bounds reach farther back is not
/// certified. So no certificate depends on the spheres that are left out. The margin is eight times the promised
/// tolerance: answers within the tolerance lie in front of it, unless the lower bound of the search is much coarser
/// than theirs.
fn cull_margin(tolerance: f64) -> f64 {
    8.0 * tolerance.clamp(LEAST_TOLERANCE, 0.125)
}

/// The cull margin of the host, which is larger than the kernel's by the factor [`WIDER`].
pub(super) fn host_cull_margin(tolerance: f64) -> f64 {
    cull_margin(tolerance) * WIDER
}

/// The smallest f32 that is at least x.
fn not_below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}
