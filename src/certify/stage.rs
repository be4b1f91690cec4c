//! What the host prepares for the certified kernel: spheres in one of two forms, each with the bounds of what f32 and
//! the host's own rounding can do to it. docs/certificate.md derives the constants; the tests take them away one by one.

use super::LensRecord;
use super::front::{FrontMoreRecord, FrontRecord};
use super::near::{NORMAL, NearRecord};
use crate::camera::{Basis, Camera, Viewport};
use crate::dd::{self, Dd, Dd3};
use crate::error::Result;
use crate::exact;
use crate::scene::Scene;
use crate::view::View;
use rayon::prelude::*;

/// The unit roundoff of WGSL: 2^-23, since it may round either way.
const U: f64 = 1.0 / (1u64 << 23) as f64;
/// The host's: half an ulp of f64.
const U64: f64 = 1.0 / (1u64 << 53) as f64;
/// Error of c - e rotated in f64, per component, relative to |c - e|_1: subtraction, basis, product, two sums.
const ROTATED: f64 = 5.0 * U64;
/// Largest |d|^2 that the constants of a front sphere's bound were derived for (176 degrees).
const WIDEST: f64 = 1024.0;
/// Largest |d|^2 whose squares a near sphere's bound can hold; a wider lens is judged exactly.
const UNBOUNDED: f64 = (1u64 << 40) as f64;
/// Largest column or row of a projected centre: the integer difference to a pixel stays exact in f32.
const FARTHEST: f64 = (1 << 22) as f64;

/// Parts of the bound that a test may take away: nothing else changes them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Terms {
    /// Roundings of |d|^2 rho^2.
    pub(crate) ball: f64,
    /// Roundings of the offset's square.
    pub(crate) offset: f64,
    /// The same for each unit of |d|^2 - 1.
    pub(crate) slant: f64,
    /// Host's rounding of the projected centre.
    pub(crate) rest: f64,
    /// Roundings of the depth: of its offset, of |d|^2 - 1, of the root, and of the centre's depth.
    pub(crate) depth: [f64; 4],
}

/// The derived constants.
pub(crate) const TERMS: Terms = Terms { ball: 10.6, offset: 9.0, slant: 16.2, rest: 1.0, depth: [13.0, 6.0, 5.2, 1.5] };

/// The scene as the certified kernel sees it.
#[derive(Debug, Clone)]
pub(crate) struct Stage {
    pub(crate) lens: LensRecord,
    pub(crate) fronts: Vec<FrontRecord>,
    pub(crate) mores: Vec<FrontMoreRecord>,
    pub(crate) nears: Vec<NearRecord>,
    /// Depth of each sphere's centre in the scene's unit, 0 for near spheres; by id. A hit's depth is this plus its
    /// offset.
    pub(crate) depths: Vec<f64>,
}

/// A sphere, staged.
enum Staged {
    /// Behind the eye plane: no viewing ray meets it.
    Behind,
    Front {
        projected: Projected,
        depth: f64,
        depth_error: f64,
        size: f64,
        id: u32,
    },
    Near(NearRecord),
}

/// A projected centre in pixels, its radius and its error in the unit of rho.
struct Projected {
    pixel: [i32; 2],
    rest: [f32; 2],
    rho: f64,
    error: f64,
}

/// The numbers of the lens in f64.
struct Lens {
    slope: [f64; 2],
    step: [f64; 2],
    /// Slope per unit of rho: a power of two.
    unit: f64,
    /// Largest |d|^2 of the image.
    widest: f64,
    size: [f64; 2],
}

/// The camera's axes right, up and forward, in double-double.
struct Axes {
    basis: Basis,
    exact: [Dd3; 3],
}

impl Stage {
    /// Prepares `scene`; `None` when its lens is too wide or too narrow for f32, and everything must be judged exactly.
    pub(crate) fn new(scene: &Scene, view: &View, tolerance: f64, terms: &Terms) -> Result<Option<Self>> {
        let viewport = scene.camera.viewport(view.record.width, view.record.height)?;
        let lens = Lens::new(&viewport, view.record.width, view.record.height);
        let narrow = lens.slope.iter().any(|s| *s < f64::from(f32::MIN_POSITIVE) * 2f64.powi(24));
        if narrow || lens.widest > UNBOUNDED {
            return Ok(None);
        }
        let axes = Axes::new(&scene.camera, view.basis)?;
        let spheres = scene.spheres.centers.par_iter().zip(&scene.spheres.radii).enumerate();
        let staged: Vec<Staged> =
            spheres.map(|(id, (c, r))| stage(&axes, &lens, view.unit, id as u32, *c, *r)).collect();
        Ok(Some(Self::gather(&lens, view.unit, staged, tolerance, terms)))
    }

    fn gather(lens: &Lens, unit: i32, staged: Vec<Staged>, tolerance: f64, terms: &Terms) -> Self {
        let mut stage = Self {
            lens: LensRecord {
                slope_x: lens.slope[0] as f32,
                slope_y: lens.slope[1] as f32,
                step_x: lens.step[0] as f32,
                step_y: lens.step[1] as f32,
                depth: reference(&staged),
                // The width and the comparison are rounded themselves.
                tolerance: (tolerance.min(1.0) * (1.0 - 2f64.powi(-10))) as f32,
                fronts: 0,
                nears: 0,
            },
            fronts: Vec::with_capacity(staged.len()),
            mores: Vec::with_capacity(staged.len()),
            nears: Vec::new(),
            depths: vec![0.0; staged.len()],
        };
        let shared = f64::from(stage.lens.depth);
        for sphere in staged {
            match sphere {
                Staged::Behind => {}
                Staged::Near(record) => stage.nears.push(record),
                Staged::Front { projected, depth, depth_error, size, id } => {
                    stage.depths[id as usize] = dd::ldexp(depth, unit);
                    let bounds = bounds(lens, &projected, depth - shared, depth_error, size, terms);
                    stage.fronts.push(FrontRecord {
                        rest: projected.rest,
                        column: projected.pixel[0],
                        row: projected.pixel[1],
                        rho2: (projected.rho * projected.rho) as f32,
                        error: up(bounds.disc),
                        size: size as f32,
                        low: -up(shared - depth + bounds.depth),
                    });
                    let high = up(depth - shared + bounds.depth);
                    stage.mores.push(FrontMoreRecord { high, least: up(bounds.least), id, unused: 0 });
                }
            }
        }
        (stage.lens.fronts, stage.lens.nears) = (stage.fronts.len() as u32, stage.nears.len() as u32);
        stage
    }
}

/// Bounds of a front sphere, for every ray of the image.
struct Bounds {
    /// Of the discriminant's error.
    disc: f64,
    /// Of the depth's error, frame's unit.
    depth: f64,
    /// Above this discriminant the normal is within its promise.
    least: f64,
}

/// docs/certificate.md, section 2, line by line.
fn bounds(lens: &Lens, p: &Projected, depth: f64, depth_error: f64, size: f64, terms: &Terms) -> Bounds {
    let m = lens.widest;
    let (rho, e) = (p.rho, p.error * terms.rest);
    let inflate = 1.0 + 2f64.powi(-10);
    // Beyond this offset a miss is certain whatever rounds; within it the errors are at most:
    let reach = (1.125 * m).sqrt() * rho + 128.0 * m * e;
    let roundings = terms.ball * m * rho * rho + (terms.offset + terms.slant * (m - 1.0)) * reach * reach;
    let disc = inflate * (U * roundings + 2.0 * m * reach * e + m * e * e) + 2f64.powi(-90);
    let root = m.sqrt() * rho + (2.0 * disc).sqrt();
    let slant = (m - 1.0).sqrt();
    let total = slant * reach + root;
    let [of_offset, of_slant, of_root, of_center] = terms.depth;
    let rounded = U * (of_offset * total + of_slant * slant * reach + of_root * root) + slant * e;
    let depth = inflate * (size * rounded + of_center * U * depth.abs() + depth_error);
    // The normal: what is left of its promise for the root's error, disc / sqrt(D).
    let others = m.sqrt() * rounded + U * (4.0 * reach + 3.5 * m.sqrt() * total) + e;
    let left = f64::from(NORMAL) * rho - others;
    let least = if left > 0.0 { (m.sqrt() * disc / left).powi(2) * inflate } else { f64::from(f32::MAX) };
    Bounds { disc, depth, least }
}

/// The least f32 that is not below x.
fn up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

/// A depth to keep the others relative to: where all spheres are far and close together, so that their order survives.
fn reference(staged: &[Staged]) -> f32 {
    let mut range = (f64::INFINITY, 0.0f64);
    for sphere in staged {
        match sphere {
            Staged::Near(_) => return 0.0,
            Staged::Behind => {}
            Staged::Front { depth, .. } => range = (range.0.min(*depth), range.1.max(*depth)),
        }
    }
    // The nearest surface is at least half the nearest centre's depth away, and stays so.
    if range.0.is_finite() && range.0 > 4.0 * (range.1 - range.0) { range.0 as f32 } else { 0.0 }
}

fn stage(axes: &Axes, lens: &Lens, unit: i32, id: u32, center: [f64; 3], radius: f64) -> Staged {
    let away: Dd3 = std::array::from_fn(|k| Dd::diff(center[k], axes.basis.e[k]));
    let [x, y, z] = axes.rotate(away);
    let reach = away.iter().map(|a| a.hi.abs()).sum::<f64>();
    let error = ROTATED * reach;
    if z + radius + error + U64 * (z.abs() + radius) < 0.0 {
        return Staged::Behind;
    }
    let length2 = x * x + y * y + z * z;
    // Wholly in front, at least two radii away, not far off to the side.
    let front = z > radius * 1.001 && length2 > 4.0 * radius * radius && length2.sqrt() < FARTHEST * z;
    if front
        && lens.widest <= WIDEST
        && let Some(projected) = project(axes, lens, away, [x, y, z], error, radius)
    {
        let depth = dd::ldexp(z, -unit);
        let size = depth * lens.unit;
        if (2f64.powi(-60)..2f64.powi(60)).contains(&size) {
            let depth_error = dd::ldexp(error, -unit) + U64 * depth;
            return Staged::Front { projected, depth, depth_error, size, id };
        }
    }
    near(axes, unit, id, away, [x, y, z], center, radius)
}

/// The projected centre; `None` where pixels or rho leave the range of the bounds.
fn project(axes: &Axes, lens: &Lens, away: Dd3, p: [f64; 3], error: f64, radius: f64) -> Option<Projected> {
    let [x, y, z] = p;
    // Pixels of error that the f64 rotation leaves in the projected centre.
    let blur = |q: f64, slope: f64| (error * (1.0 + q.abs()) / z + 4.0 * U64 * q.abs()) / (2.0 * slope);
    let mut q = [x / z, y / z].map(Dd::from);
    let mut blurred = [blur(q[0].hi, lens.slope[0]), blur(q[1].hi, lens.slope[1])];
    if blurred.iter().any(|b| *b > 2f64.powi(-27)) {
        // A long lens: once more in double-double.
        let [x, y, z] = axes.exact.map(|axis| dd::dot(axis, away));
        q = [x / z, y / z];
        blurred = blurred.map(|b| b * 2f64.powi(-40));
    }
    let mut projected = Projected { pixel: [0; 2], rest: [0.0; 2], rho: radius / (z * lens.unit), error: 0.0 };
    let mut errors = [0.0; 2];
    for k in 0..2 {
        let slope: Dd = lens.slope[k].into();
        // u = (2 j + 1 - W) slope, v = (H - 1 - 2 i) slope: rows count down.
        let sign = if k == 0 { 1.0 } else { -1.0 };
        let at = (q[k] / slope * sign.into() + (lens.size[k] - 1.0).into()) * 0.5.into();
        let whole = at.value().round();
        if whole.abs() > FARTHEST {
            return None;
        }
        let rest = (at - whole.into()).value();
        projected.pixel[k] = whole as i32;
        projected.rest[k] = (rest * sign) as f32;
        // The pixel's own slope was rounded once: the same relative error in every offset from the axis.
        errors[k] = lens.step[k] * (2f64.powi(-26) + blurred[k] + 2.0 * U64 * (whole.abs() + lens.size[k]));
    }
    projected.error = errors[0].hypot(errors[1]) * (1.0 + 2f64.powi(-20));
    (2f64.powi(-40)..2f64.powi(40)).contains(&projected.rho).then_some(projected)
}

fn near(axes: &Axes, unit: i32, id: u32, away: Dd3, p: [f64; 3], center: [f64; 3], radius: f64) -> Staged {
    let largest = away.iter().fold(radius, |m, a| m.max(a.hi.abs()));
    let k = dd::exponent(largest);
    let shrink = |x: f64| dd::ldexp(x, -k) as f32;
    let scaled = away.map(|a| a.ldexp(-k));
    let r = dd::ldexp(radius, -k);
    let power = dd::dot(scaled, scaled) - Dd::product(r, r);
    // Double-double is within 2^-96 of the terms, which are below 16; nearer to zero only exact arithmetic tells.
    let power = match power.value() {
        sure if sure.abs() > 2f64.powi(-90) => sure,
        _ => exact::power(center, axes.basis.e.to_array(), radius, -k),
    };
    let form = u32::from(power.abs() <= r * r);
    Staged::Near(NearRecord {
        // The camera looks down -z.
        ball: [shrink(p[0]), shrink(p[1]), -shrink(p[2]), shrink(radius)],
        power: crate::view::nonzero_f32(power),
        scale: f32::from_bits(((k - unit + 127) as u32) << 23),
        form,
        id,
    })
}

impl Lens {
    fn new(viewport: &Viewport, width: u32, height: u32) -> Self {
        let size = [f64::from(width), f64::from(height)];
        let slope = [viewport.vw / viewport.d / (2.0 * size[0]), viewport.vh / viewport.d / (2.0 * size[1])];
        let unit = dd::ldexp(1.0, dd::exponent(2.0 * slope[0].max(slope[1])));
        let largest = [slope[0] * size[0], slope[1] * size[1]];
        let widest = (1.0 + largest[0] * largest[0] + largest[1] * largest[1]) * (1.0 + 2f64.powi(-20));
        Self { slope, step: slope.map(|s| 2.0 * s / unit), unit, widest, size }
    }
}

impl Axes {
    fn new(camera: &Camera, basis: Basis) -> Result<Self> {
        let [right, up, back] = camera.axes()?;
        Ok(Self { basis, exact: [right, up, back.map(|x| -x)] })
    }

    /// Right, up and forward of a difference, in f64.
    fn rotate(&self, away: Dd3) -> [f64; 3] {
        let p = glam::DVec3::from_array(away.map(|a| a.hi));
        [p.dot(self.basis.u), p.dot(self.basis.v), -p.dot(self.basis.w)]
    }
}
