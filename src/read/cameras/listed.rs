//! A camera of a list.

use super::axes::{AxesProblem, check_axes};
use crate::scene::camera::{Camera, Intrinsics, Lens, Look};
use glam::DVec3;

/// A camera of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListedCamera {
    /// The pose, and the lens that the list gives; the canonical one where it gives none.
    pub camera: Camera,
    /// Whether the list gives a lens other than by intrinsics.
    pub has_lens: bool,
    /// Focal lengths and principal point.
    pub intrinsics: Option<Intrinsics>,
    /// Columns and rows of its image.
    pub size: Option<[u32; 2]>,
}

impl ListedCamera {
    /// A camera at `eye` that looks along `view`.
    pub(super) fn new(eye: [f64; 3], look: Look, up: [f64; 3]) -> Self {
        let camera = Camera { eye: eye.into(), look, up: up.into(), ..Camera::CANONICAL };
        Self { camera, has_lens: false, intrinsics: None, size: None }
    }

    /// The camera of a matrix from camera to world, by rows, whose columns are right, up, back and the eye; for OpenCV's
    /// axes right, down, forward and the eye. The axes may have any length, which all three have.
    pub(super) fn of_matrix(matrix: [[f64; 4]; 3], opencv: bool) -> Result<Self, AxesProblem> {
        let column = |k: usize| DVec3::new(matrix[0][k], matrix[1][k], matrix[2][k]);
        check_axes([0, 1, 2].map(|k| column(k).to_array()), false)?;
        let (view, up) = if opencv { (column(2), -column(1)) } else { (-column(2), column(1)) };
        Ok(Self::new(column(3).to_array(), Look::View(view), up.to_array()))
    }

    /// The same with a lens.
    pub(super) fn with_lens(self, lens: Lens) -> Self {
        Self { camera: Camera { lens, ..self.camera }, has_lens: true, ..self }
    }
}
