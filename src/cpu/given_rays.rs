//! Given rays in the arithmetic of a twin, and the spheres as they see them.

use crate::number::Number;
use crate::view::ray::{Ray, RayRecord, dot3};
use crate::view::{Sphere, SphereRecord, SphereResiduals};

/// A sphere moved to the origin of a ray; the twin of search/moved_origin.wgsl.
pub(super) fn moved<R: Number>(s: &SphereRecord, residuals: &SphereResiduals, ray: &RayRecord) -> Sphere<R> {
    let shrink = 1.0 / s.scale;
    let part = |k: usize| [s.center_radius[k], residuals.center_radius[k]];
    let p = [0, 1, 2].map(|k| R::difference(part(k), [ray.origin[k], ray.origin_low[k]], shrink));
    let radius = R::from_hi_lo(s.center_radius[3], residuals.center_radius[3]);
    Sphere {
        center_radius: [p[0], p[1], p[2], radius],
        power: dot3(p, p) - radius * radius,
        scale: R::from_f32(s.scale),
    }
}

/// The direction in the arithmetic of a twin.
pub(super) fn direction<R: Number>(r: &RayRecord) -> Ray<R> {
    let low = [r.direction[3], r.origin[3], r.origin_low[3]];
    Ray { d: std::array::from_fn(|k| R::from_hi_lo(r.direction[k], low[k])) }
}
