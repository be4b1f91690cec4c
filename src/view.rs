//! The view: the scene moved into the canonical camera (eye at the origin, looking down -z), in f64, rounded once.
//!
//! *Move the world, not the ray*: c - e and the rotation happen here, once per sphere and frame, so a viewing ray has
//! origin 0 and direction (u, v, -d) and small numbers stay small. Powers of two, chosen here and exact, keep every
//! square of the kernels in range: one for the rays (the largest of vw/2, vh/2, d lies in [1, 2)) and one for each sphere
//! (the largest of |p_x|, |p_y|, |p_z|, r lies in [1, 2)).

pub(crate) mod backdrop;
mod curved;
pub(crate) mod directions;
pub(crate) mod given;
mod moved;
pub(crate) mod picture_rays;
pub(crate) mod placement;
pub(crate) mod planes;
pub(crate) mod raster;
pub mod ray;
mod records;

use curved::CurvedView;
pub(crate) use moved::FromEye;
pub use raster::strata_of;
pub(crate) use records::pcg4d;
pub use records::{Sphere, SphereRecord, SphereResiduals, ViewRecord};

use crate::double_double as dd;
use crate::exact::Judge;
use crate::number::Number;
use crate::number::vector::vectorized;
use crate::scene::Scene;
use crate::scene::camera::{Basis, CentredFrame, CurvedFrame, ExactViewport};
use crate::window::Window;
use bytemuck::Zeroable;
use glam::DVec3;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::parallel;
use moved::Moved;
use raster::Raster;

/// Which sphere records a view holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Records {
    /// None: the candidate lists have their own.
    None,
    /// Rounded to f32.
    Rounded,
    /// Rounded to f32, with the rounding errors.
    WithResiduals,
}

/// The scene in the canonical camera.
#[derive(Debug, Clone)]
pub struct View {
    /// The uniform of the kernels.
    pub record: ViewRecord,
    /// One record per sphere in the scene's order; empty where the kernel reads candidate lists.
    pub spheres: Vec<SphereRecord>,
    /// Rounding errors of each sphere, for rays from many points and for arithmetic beyond f32; else empty.
    pub residuals: Vec<SphereResiduals>,
    /// The basis, in f64.
    pub basis: Basis,
    /// vw/(2W), vh/(2H) and d in f64, scaled by the same power of two as the record's; for parallel rays vw/(2W) and
    /// vh/(2H) in the frame's unit, and 1.
    pub pitch: [f64; 3],
    /// Whether the viewing rays are parallel.
    pub parallel: bool,
    /// The viewport of the whole frame, whose size the record has; `None` for given rays and for a curved lens.
    pub(crate) viewport: Option<ExactViewport>,
    /// The viewing rays of a curved lens.
    pub(crate) curved: Option<CurvedView>,
    /// The frame's unit of t is 2^unit: a hit lies at t 2^unit (u, v, -d), with u, v, d as scaled.
    pub unit: i32,
}

/// The viewing rays of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RayKind {
    Perspective,
    Parallel,
    Curved,
}

/// The largest range of exponents in one frame that leaves room for the roots.
/// Section "The model of f32" of docs/certificate.md.
const MAX_EXPONENT_RANGE: i32 = 240;

/// Spheres whose sizes are computed by one job.
const SPHERES_PER_JOB: usize = 1 << 12;

/// The least exponent of a frame's unit: 2^1000 can still be multiplied by subnormal numbers. Those are within 2^-74 of
/// that unit, where f32 holds them too. Section 1 of docs/certificate.md.
const LEAST_UNIT: i32 = -1000;

impl View {
    /// Moves the spheres of `scene` into the canonical camera and computes the pixel pitch.
    ///
    /// # Errors
    /// The errors of [`Scene::check`]; [`Error::Scene`] for numbers so far apart that c - e overflows or that the sizes
    /// span more than 2^240.
    pub fn new(scene: &Scene) -> Result<Self> {
        Self::for_rays(scene, Raster::centres(Window::full(scene.image.width, scene.image.height)), Records::Rounded)
    }

    /// The view for the rays of `raster`, with these sphere records.
    ///
    /// # Errors
    /// As [`View::new`].
    pub(crate) fn for_rays(scene: &Scene, raster: Raster, records: Records) -> Result<Self> {
        let mut view = Self::in_unit(scene, raster, None)?;
        if records != Records::None {
            view.spheres = view.moved(&scene.spheres.centers, &scene.spheres.radii);
        }
        if records == Records::WithResiduals {
            view.keep_residuals(&scene.spheres.centers, &scene.spheres.radii);
        }
        Ok(view)
    }

    /// The view of a scene's full frame, without spheres: camera, pixels and the frame's unit.
    pub(crate) fn without_spheres(scene: &Scene) -> Result<Self> {
        Self::in_unit(scene, Raster::centres(Window::full(scene.image.width, scene.image.height)), None)
    }

    /// The view of the rays of `raster` without spheres, in the unit 2^`unit`; `None` for the unit of the scene's
    /// spheres. The window selects the rays; no other number depends on it. The unit is a power of two: results do not
    /// depend on it, as far as no number leaves the range of f32.
    ///
    /// # Errors
    /// As [`View::new`]; with a given unit, without the error of sizes that span too much.
    pub(crate) fn in_unit(scene: &Scene, raster: Raster, unit: Option<i32>) -> Result<Self> {
        scene.check()?;
        let size = [scene.image.width, scene.image.height];
        if let Some(frame) = CurvedFrame::new(&scene.camera, size, raster.strata * raster.jitter)? {
            return Self::of_curved(scene, raster, unit, frame);
        }
        let CentredFrame { viewport, size: [width, height], step, shift } =
            scene.camera.centred(size, raster.strata, raster.jitter)?.moved(raster.lens_offset)?;
        let parallel = viewport.is_parallel();
        let basis = scene.camera.basis()?;
        let unit = match unit {
            Some(unit) => unit,
            None => self::unit(basis.e, &scene.spheres.centers, &scene.spheres.radii)?,
        };
        let (pitch, pixel, low) = match parallel {
            // Only the certified kernel has parallel rays, and it does not read the pitch.
            true => (parallel_pitch(&viewport, width, height, unit), [0.0; 3], [0.0; 3]),
            false => scaled_pitch(&viewport, width, height),
        };
        let record = ViewRecord {
            width,
            height,
            step,
            shift_column: shift[0],
            shift_row: shift[1],
            half_du: pixel[0],
            half_dv: pixel[1],
            d: pixel[2],
            half_du_low: low[0],
            half_dv_low: low[1],
            d_low: low[2],
            ..raster.record(scene.image.background)
        };
        let view = Self::of_basis(basis, record, pitch, scene.spheres.len(), unit);
        Ok(Self { parallel, viewport: Some(viewport), ..view })
    }

    /// The view of a curved lens, for the first sample of the raster.
    fn of_curved(scene: &Scene, raster: Raster, unit: Option<i32>, frame: CurvedFrame) -> Result<Self> {
        let basis = scene.camera.basis()?;
        let unit = match unit {
            Some(unit) => unit,
            None => self::unit(basis.e, &scene.spheres.centers, &scene.spheres.radii)?,
        };
        let fine = raster.strata * raster.jitter;
        let [width, height] = [scene.image.width, scene.image.height].map(|side| side * fine);
        let record = ViewRecord { width, height, step: 1, ..raster.record(scene.image.background) };
        let side = frame.pixel() / f64::from(2 * fine);
        let view = Self::of_basis(basis, record, [side, side, 1.0], scene.spheres.len(), unit);
        Ok(Self { curved: Some(CurvedView::new(frame, &view.record)), ..view })
    }

    /// Selects the sample of each pixel whose rays the view has.
    pub(crate) fn set_sample(&mut self, sample: u32) {
        let is_same = std::mem::replace(&mut self.record.sample, sample) == sample;
        if let Some(curved) = self.curved.as_mut().filter(|_| !is_same) {
            *curved = CurvedView::new(curved.frame, &self.record);
        }
    }

    pub(crate) fn kind(&self) -> RayKind {
        match &self.curved {
            Some(_) => RayKind::Curved,
            None if self.parallel => RayKind::Parallel,
            None => RayKind::Perspective,
        }
    }

    /// The judge of a scene for rays by their row and column in the record's frame.
    ///
    /// # Errors
    /// Errors of [`Judge::new`].
    pub(crate) fn judge(&self, scene: &Scene) -> Result<Judge> {
        let judge = Judge::new(scene)?;
        let size = [self.record.width, self.record.height];
        Ok(match self.viewport {
            Some(viewport) => judge.in_frame(viewport, size),
            None => match &self.curved {
                Some(curved) => judge.in_curved_frame(curved.frame),
                None => judge,
            },
        })
    }

    /// A view along the world's axes from `eye`, for tracing given rays.
    pub(crate) fn along_axes(eye: DVec3, centers: &[[f64; 3]], radii: &[f64]) -> Result<Self> {
        let basis = Basis { e: eye, u: DVec3::X, v: DVec3::Y, w: DVec3::Z };
        let unit = unit(eye, centers, radii)?;
        let mut view = Self::of_basis(basis, ViewRecord::zeroed(), [0.0; 3], radii.len(), unit);
        view.spheres = view.moved(centers, radii);
        Ok(view)
    }

    /// A view from `basis` for `spheres` spheres, which are not yet moved.
    fn of_basis(basis: Basis, record: ViewRecord, pitch: [f64; 3], spheres: usize, unit: i32) -> Self {
        let axis = |a: DVec3| [a.x as f32, a.y as f32, a.z as f32, 0.0];
        let [right, up, back] = [basis.u, basis.v, basis.w].map(axis);
        let record = ViewRecord { right, up, back, spheres: spheres as u32, ..record };
        let (spheres, residuals) = (Vec::new(), Vec::new());
        Self { record, spheres, residuals, basis, pitch, parallel: false, viewport: None, curved: None, unit }
    }

    /// The spheres in the arithmetic of a CPU twin, with their rounding errors where `wide`.
    pub(crate) fn spheres_in<R: Number>(&self, wide: bool) -> Vec<Sphere<R>> {
        match wide {
            true => self.spheres.iter().zip(&self.residuals).map(|(s, low)| Sphere::with_residuals(s, low)).collect(),
            false => self.spheres.iter().map(Sphere::from).collect(),
        }
    }

    /// Keeps the rounding errors of the records of this view's spheres.
    pub(crate) fn keep_residuals(&mut self, centers: &[[f64; 3]], radii: &[f64]) {
        let (basis, spheres) = (self.basis, &self.spheres);
        let residuals = |n: usize| Moved::new(&basis, centers[n], radii[n]).residuals(&spheres[n]);
        self.residuals = parallel::from_fn(spheres.len(), residuals);
    }

    /// The viewing direction (u, v, -d) of row i and column j of the record's frame in f64, scaled like the record's.
    /// Parallel rays have (0, 0, -1), a curved lens the direction of its model, or zero where it has none.
    pub(crate) fn direction(&self, i: u32, j: u32) -> [f64; 3] {
        match &self.curved {
            Some(curved) => curved.direction(&self.record, [i, j]),
            None if self.parallel => [0.0, 0.0, -1.0],
            None => self.slope_direction(i, j),
        }
    }

    /// The origin of the viewing ray of row i and column j, in the canonical camera.
    pub(crate) fn origin(&self, i: u32, j: u32) -> [f64; 3] {
        let [u, v, _] = self.slope_direction(i, j);
        // In the frame's unit u and v keep their bits, even at the limits of f64.
        if self.parallel { [u, v, 0.0].map(|x| dd::ldexp(x, self.unit)) } else { [0.0; 3] }
    }

    /// (u, v, -d) of row i and column j.
    #[inline(always)]
    fn slope_direction(&self, i: u32, j: u32) -> [f64; 3] {
        let odd = |n: u32, k: u32| 2.0 * f64::from(k) + 1.0 - f64::from(n);
        [odd(self.record.width, j) * self.pitch[0], -odd(self.record.height, i) * self.pitch[1], -self.pitch[2]]
    }

    /// The world point at `t` along a direction of the canonical camera, from an origin in it.
    pub(crate) fn point(&self, origin: [f64; 3], d: [f64; 3], t: f64) -> [f64; 3] {
        let from = self.basis.e + self.to_world(origin);
        (from + self.to_world(d) * t).to_array()
    }

    /// A direction of the canonical camera in world space.
    #[inline(always)]
    pub(crate) fn to_world(&self, d: [f64; 3]) -> DVec3 {
        self.basis.to_world(d)
    }

    /// The records of these spheres, moved into the canonical camera, in their order.
    pub(crate) fn moved(&self, centers: &[[f64; 3]], radii: &[f64]) -> Vec<SphereRecord> {
        parallel::from_fn(radii.len(), |n| Moved::new(&self.basis, centers[n], radii[n]).record(self.unit))
    }
}

/// The middle of the exponents of all sizes and of all distances from `eye`: the exponent of the frame's unit.
pub(crate) fn unit(eye: DVec3, centers: &[[f64; 3]], radii: &[f64]) -> Result<i32> {
    let jobs = parallel::blocks(0..radii.len(), SPHERES_PER_JOB, &|ids, _| {
        let (centers, radii) = (&centers[ids.clone()], &radii[ids]);
        vectorized!(sizes(eye, centers, radii))
    });
    let Some(range) = jobs.into_iter().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]) else {
        return Ok(0);
    };
    let [least, most] = range.map(|bits| dd::exponent(f64::from_bits(bits as u64)));
    // c - e must not overflow, and squares of numbers scaled by 2^-k must not underflow in double-double.
    if most >= 1000 || most - least > MAX_EXPONENT_RANGE {
        let problem = format!("sizes and distances from 2^{least} to 2^{most} exceed the range of one frame");
        let mend = format!("keep them within 2^{MAX_EXPONENT_RANGE} of each other and below 2^1000");
        return Err(Error::scene(Place::field("spheres"), problem, mend));
    }
    Ok(middle([least, most]))
}

/// The exponent of the unit for sizes whose exponents lie between the two given: their middle.
pub(crate) fn middle([least, most]: [i32; 2]) -> i32 {
    (least + (most - least) / 2).max(LEAST_UNIT)
}

/// The least and the largest size of some spheres, as bits.
#[inline(always)]
fn sizes(eye: DVec3, centers: &[[f64; 3]], radii: &[f64]) -> [i64; 2] {
    // Bits of positive numbers are in their order, and compilers make vectors of integers' minima alone.
    centers.iter().zip(radii).fold([i64::MAX, 0], |[least, most], (center, radius)| {
        let size = size_from(eye, *center, *radius).to_bits() as i64;
        [least.min(size), most.max(size)]
    })
}

/// The size of a sphere that a frame's unit must cover: the radius or, if larger, the largest coordinate of the centre
/// relative to the eye, without its sign.
#[inline(always)]
pub(crate) fn size_from(eye: DVec3, center: [f64; 3], radius: f64) -> f64 {
    let away = (DVec3::from_array(center) - eye).abs();
    away.x.max(away.y).max(away.z.max(radius))
}

/// vw/(2W), vh/(2H), d times the power of two that brings the largest of vw/2, vh/2, d into [1, 2): in f64, in f32, and
/// the rounding errors.
fn scaled_pitch(viewport: &ExactViewport, width: u32, height: u32) -> ([f64; 3], [f32; 3], [f32; 3]) {
    let largest = (viewport.vw / 2.0).max(viewport.height_over(0, 2.0)).max(viewport.d);
    let shift = -dd::exponent(largest);
    let pitch = [
        dd::ldexp(viewport.vw, shift) / (2.0 * f64::from(width)),
        viewport.height_over(-shift, 2.0 * f64::from(height)),
        dd::ldexp(viewport.d, shift),
    ];
    (pitch, pitch.map(|x| x as f32), pitch.map(|x| (x - f64::from(x as f32)) as f32))
}

/// vw/(2W), vh/(2H) in the frame's unit, and 1. Scaling comes first, since a subnormal number would lose bits in the
/// quotient.
fn parallel_pitch(viewport: &ExactViewport, width: u32, height: u32, unit: i32) -> [f64; 3] {
    let [width, height] = [width, height].map(|count| 2.0 * f64::from(count));
    [dd::ldexp(viewport.vw, -unit) / width, viewport.height_over(unit, height), 1.0]
}
