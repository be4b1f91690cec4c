//! The viewing rays of a curved lens by the places of a frame of samples, as [`CentredFrame`](super::CentredFrame) has the rays of a plane.

use super::{Basis, Camera, CurvedRays, Lens};
use glam::DVec3;
use halfline_ground::error::Result;

/// A camera whose lens is curved, and the places of its rays.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvedFrame {
    rays: CurvedRays,
    basis: Basis,
    /// Places along a side of a pixel.
    fine: u32,
}

impl CurvedFrame {
    /// The rays of an image of `size` pixels; `None` for a lens that is not curved.
    ///
    /// # Errors
    /// Errors of [`Camera::check`] and of [`Camera::basis`].
    pub(crate) fn new(camera: &Camera, size: [u32; 2], fine: u32) -> Result<Option<Self>> {
        let Lens::Curved { curve, fx, fy, cx, cy } = camera.lens else { return Ok(None) };
        let rays = CurvedRays::new(curve, [fx, fy, cx, cy], size)?;
        Ok(Some(Self { rays, basis: camera.basis()?, fine }))
    }

    /// The direction of the ray of a row and a column in the canonical camera, of any length; zero where the lens's model gives the place
    /// none.
    pub(crate) fn direction(&self, [row, column]: [u32; 2]) -> [f64; 3] {
        let at = [column, row].map(|at| (f64::from(at) + 0.5) / f64::from(self.fine));
        self.rays.direction(at).map_or([0.0; 3], |DVec3 { x, y, z }| [x, -y, -z])
    }

    /// The same direction in the world: this is the exact ray.
    pub(crate) fn in_world(&self, place: [u32; 2]) -> DVec3 {
        self.basis.to_world(self.direction(place))
    }

    /// The angle of a pixel at the lens's axis, radians.
    pub(crate) fn pixel(&self) -> f64 {
        1.0 / self.rays.scale(DVec3::Z)
    }
}
