//! Shared by the lecture's three forms: the twin of form/roots.wgsl.

use crate::number::{Arithmetic, Mask, Number};
use crate::view::Sphere;
use crate::view::ray::{Ray, center, dot3, minus, negated, times, unit3};

/// The smaller of two ordered roots that lies on the ray.
#[inline(always)]
pub(super) fn closest<R: Arithmetic>(near: R, far: R) -> R {
    R::ZERO.less(near).pick(near, R::ZERO.less(far).pick(far, R::MISS))
}

/// The unit normal, computed as hit point minus centre, facing the ray's origin.
pub(super) fn normal_from_point<R: Number>(ray: &Ray<R>, s: &Sphere<R>, t: R) -> [R; 3] {
    let n = unit3(minus(times(t, ray.d), center(s)));
    if dot3(n, ray.d) > R::ZERO { negated(n) } else { n }
}
