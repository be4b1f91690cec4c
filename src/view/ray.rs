//! Viewing rays and hits: the twin of ray.wgsl.

use super::records::{Sphere, ViewRecord};
use crate::number::{Arithmetic, Mask, Number};
use bytemuck::{Pod, Zeroable};

/// A viewing ray in the canonical camera: origin 0, direction d of any length. Only t > 0 counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray<R> {
    /// Direction.
    pub d: [R; 3],
}

/// A given ray as the kernel reads it; declared in main/given_rays.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub struct RayRecord {
    /// Direction, with its largest component in [1, 2). The fourth components of this and the next two fields are the
    /// rounding errors of its x, y, z.
    pub direction: [f32; 4],
    /// Origin minus the view's eye, in the frame's unit.
    pub origin: [f32; 4],
    /// Rounding errors of the origin.
    pub origin_low: [f32; 4],
}

/// The closest hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit<R> {
    /// t in the frame's unit; [`Arithmetic::MISS`] on a miss.
    pub t: R,
    /// Index of the sphere in the scene's order; [`NONE`] on a miss.
    pub id: u32,
}

/// The id of a miss.
pub const NONE: u32 = u32::MAX;

/// The id where a certified kernel could not prove its answer and the host decides.
pub(crate) const UNSURE: u32 = u32::MAX - 1;

impl<R: Number> Hit<R> {
    /// No hit.
    pub const NONE: Self = Self { t: R::MISS, id: NONE };
}

/// The viewing ray of row `i` and column `j`, both from 0: u = (2j + 1 - W) vw/(2W), v = (H - 1 - 2i) vh/(2H), -d.
#[must_use]
pub fn viewing_ray<R: Number>(view: &ViewRecord, i: u32, j: u32) -> Ray<R> {
    let odd = |x: i64| R::from_f32(x as f32);
    let u = odd(2 * i64::from(j) + 1 - i64::from(view.width)) * R::from_hi_lo(view.half_du, view.half_du_low);
    let v = odd(i64::from(view.height) - 1 - 2 * i64::from(i)) * R::from_hi_lo(view.half_dv, view.half_dv_low);
    Ray { d: [u, v, -R::from_hi_lo(view.d, view.d_low)] }
}

/// x where it is positive, else 0.
#[inline(always)]
pub fn positive<R: Arithmetic>(x: R) -> R {
    R::ZERO.less(x).pick(x, R::ZERO)
}

/// a . b, summed in the order x, y, z, which determines the last bit.
#[inline(always)]
pub fn dot3<R: Arithmetic>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b
#[inline(always)]
pub fn cross3<R: Arithmetic>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a / |a|
#[inline(always)]
pub fn unit3<R: Arithmetic>(a: [R; 3]) -> [R; 3] {
    let length = dot3(a, a).sqrt();
    [a[0] / length, a[1] / length, a[2] / length]
}

/// s a
#[inline(always)]
pub fn times<R: Arithmetic>(s: R, a: [R; 3]) -> [R; 3] {
    [s * a[0], s * a[1], s * a[2]]
}

/// a - b
#[inline(always)]
pub fn minus<R: Arithmetic>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// -a
#[inline(always)]
pub fn negated<R: Arithmetic>(a: [R; 3]) -> [R; 3] {
    [-a[0], -a[1], -a[2]]
}

/// The centre of a sphere's record.
#[inline(always)]
pub fn center<R: Arithmetic>(s: &Sphere<R>) -> [R; 3] {
    [s.center_radius[0], s.center_radius[1], s.center_radius[2]]
}

/// The radius of a sphere's record.
#[inline(always)]
pub fn radius<R: Arithmetic>(s: &Sphere<R>) -> R {
    s.center_radius[3]
}
