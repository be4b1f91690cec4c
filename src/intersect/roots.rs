//! Shared by the lecture's three forms: the twin of form/roots.wgsl.

use crate::number::Number;
use crate::view::Sphere;
use crate::view::ray::{Ray, center, dot3, minus, negated, times, unit3};

/// The smaller of two ordered roots that lies on the ray.
pub(super) fn closest<R: Number>(near: R, far: R) -> R {
    if near > R::ZERO {
        return near;
    }
    if far > R::ZERO {
        return far;
    }
    R::MISS
}

/// The unit normal, computed as hit point minus centre, facing the ray's origin.
pub(super) fn normal_from_point<R: Number>(ray: &Ray<R>, s: &Sphere<R>, t: R) -> [R; 3] {
    let n = unit3(minus(times(t, ray.d), center(s)));
    if dot3(n, ray.d) > R::ZERO { negated(n) } else { n }
}
