//! The viewing rays of a camera in world space, rounded: for pictures while the camera moves, and to find the spheres that a
//! ray may hit.

use glam::DVec3;
use halfline::camera::{Basis, Camera, Viewport};
use halfline::error::Result;

/// The rays through the centres of the pixels.
pub(super) struct ViewingRays {
    basis: Basis,
    viewport: Viewport,
    size: [u32; 2],
    is_parallel: bool,
}

impl ViewingRays {
    /// # Errors
    /// Those of the camera.
    pub(super) fn new(camera: &Camera, size: [u32; 2]) -> Result<Self> {
        let viewport = camera.viewport(size[0], size[1])?;
        Ok(Self { basis: camera.basis()?, viewport, size, is_parallel: camera.lens.is_orthographic() })
    }

    pub(super) fn len(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Origin and direction of the ray through pixel (column, row), as in the lecture.
    pub(super) fn ray(&self, column: u32, row: u32) -> [DVec3; 2] {
        let (Basis { e, u, v, w }, [width, height]) = (&self.basis, self.size.map(f64::from));
        let right = ((f64::from(column) + 0.5) / width - 0.5) * self.viewport.vw;
        let up = (0.5 - (f64::from(row) + 0.5) / height) * self.viewport.vh;
        let across = *u * right + *v * up;
        if self.is_parallel { [*e + across, -*w] } else { [*e, across - *w * self.viewport.d] }
    }

    /// The ray of pixel `n`, row by row from the top.
    pub(super) fn nth(&self, n: usize) -> [DVec3; 2] {
        let width = self.size[0] as usize;
        self.ray((n % width) as u32, (n / width) as u32)
    }
}
