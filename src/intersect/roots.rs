//! Shared by the lecture's three forms: the twin of form/roots.wgsl.

use crate::number::{Arithmetic, Mask};

/// The smaller of two ordered roots that lies on the ray.
#[inline(always)]
pub(super) fn closest<R: Arithmetic>(near: R, far: R) -> R {
    R::ZERO.less(near).pick(near, R::ZERO.less(far).pick(far, R::MISS))
}
