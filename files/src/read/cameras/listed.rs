//! A camera of a list.

use super::axes::{AxesProblem, check_axes};
use super::lens::{ListedLens, PixelLens};
use glam::DVec3;
use halfline::scene::camera::{Aperture, Camera, Intrinsics, Lens, Look};

/// A camera of a list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ListedCamera {
    /// The pose, and the lens that the list gives; the canonical one where it gives none.
    pub camera: Camera,
    /// Whether the list gives a lens other than by intrinsics.
    pub has_lens: bool,
    /// Focal lengths and principal point.
    pub intrinsics: Option<PixelLens>,
    /// Columns and rows of its image.
    pub size: Option<[u32; 2]>,
    /// The size of its lens, where it has one.
    pub aperture: Option<Aperture>,
}

impl ListedCamera {
    /// The lens that the list gives, else the lens of `intrinsics`, else `vfov`, the options for cameras without a lens.
    /// `None` where none of these is given.
    #[must_use]
    pub fn lens(&self, intrinsics: Option<Intrinsics>, vfov: Option<Lens>) -> Option<ListedLens> {
        if self.has_lens {
            let lens = self.camera.lens;
            return Some(self.size.map_or(ListedLens::Known(lens), |image| ListedLens::OfImage(lens, image)));
        }
        self.intrinsics.or(intrinsics.map(PixelLens::of)).map(ListedLens::InPixels).or(vfov.map(ListedLens::Known))
    }

    /// A camera at `eye` with this direction of view and this `up`, without a lens.
    pub(super) fn new(eye: [f64; 3], look: Look, up: [f64; 3]) -> Self {
        let camera = Camera { eye: eye.into(), look, up: up.into(), ..Camera::CANONICAL };
        Self { camera, has_lens: false, intrinsics: None, size: None, aperture: None }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// docs/film.md: options give the lens to the cameras of the list that have none.
    #[test]
    fn what_the_list_says_of_a_lens_comes_first() {
        let intrinsics = |fx: f64| Intrinsics { fx, fy: 50.0, cx: 20.0, cy: 15.0 };
        let angle = |degrees: f64| Lens::Vfov { degrees, distance: 1.0 };
        let bare = ListedCamera::new([0.0; 3], Look::View(-DVec3::Z), [0.0, 1.0, 0.0]);
        let in_pixels = ListedCamera { intrinsics: Some(PixelLens::of(intrinsics(40.0))), ..bare };
        let known = in_pixels.with_lens(angle(20.0));
        let (given, vfov) = (Some(intrinsics(60.0)), Some(angle(30.0)));
        for (camera, given, vfov, expected) in [
            (&known, given, vfov, Some(ListedLens::Known(angle(20.0)))),
            (&in_pixels, given, vfov, Some(ListedLens::InPixels(PixelLens::of(intrinsics(40.0))))),
            (&bare, given, vfov, Some(ListedLens::InPixels(PixelLens::of(intrinsics(60.0))))),
            (&bare, None, vfov, Some(ListedLens::Known(angle(30.0)))),
            (&bare, None, None, None),
        ] {
            assert_eq!(camera.lens(given, vfov), expected, "{camera:?}");
        }
        let error = ListedLens::InPixels(PixelLens::of(intrinsics(0.0)))
            .for_image(3, 40, 30)
            .expect_err("no focal length")
            .to_string();
        assert!(error.contains("camera 3: ") && error.contains("not positive"), "{error}");
    }
}
