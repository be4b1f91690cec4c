//! The surface at a hit, as shading sees it.

use crate::certify::surface::SurfacePoint;
use glam::DVec3;

/// The properties of a hit that decide its colour under given light.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    pub(super) id: u32,
    /// The ray comes from outside.
    pub(super) outside: bool,
    /// The hit is on a plane that cuts the sphere.
    pub(super) is_face: bool,
    /// Of length 1, against the ray.
    pub(super) normal: DVec3,
}

impl From<&SurfacePoint> for Surface {
    fn from(point: &SurfacePoint) -> Self {
        Self { id: point.id, outside: point.outside, is_face: point.is_face, normal: point.normal.into() }
    }
}
