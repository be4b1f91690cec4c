//! The place of a point of the scene in an image, for what is drawn over a picture.

use super::{Camera, CameraRecord, Viewport};
use crate::error::Result;
use glam::DVec3;

/// A point as an image shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Columns from the left edge and rows from the top edge: the middle of the first pixel is (0.5, 0.5).
    pub at: [f64; 2],
    /// Pixels across in a unit of length at its depth.
    pub scale: f64,
}

impl Camera {
    /// The place of a point in an image of `size` columns and rows; `None` for one that is not in front of the eye.
    ///
    /// # Errors
    /// Errors of [`Camera::basis`] and [`Camera::viewport`].
    pub fn project(&self, size: [u32; 2], point: DVec3) -> Result<Option<Projected>> {
        let basis = self.basis()?;
        let away = point - basis.e;
        let [x, y, depth] = [away.dot(basis.u), away.dot(basis.v), -away.dot(basis.w)];
        if depth.is_nan() || depth <= 0.0 {
            return Ok(None);
        }
        let Some(lens) = CameraRecord::new(self, size, None)?.intrinsics else {
            let Viewport { vw, vh, .. } = self.viewport(size[0], size[1])?;
            let [width, height] = size.map(f64::from);
            let at = [(x / vw + 0.5) * width, (0.5 - y / vh) * height];
            return Ok(Some(Projected { at, scale: width / vw }));
        };
        let at = [lens.cx + lens.fx * x / depth, lens.cy - lens.fy * y / depth];
        Ok(Some(Projected { at, scale: lens.fx / depth }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::Judge;
    use crate::scene::camera::{Lens, Look};
    use crate::scene::{ImagePlane, Scene, Spheres};

    /// A small sphere is hit by the ray of the pixel that it is projected into, and by none of its neighbours but one.
    #[test]
    fn a_sphere_is_where_its_centre_is_projected() {
        let lenses = [
            Lens::Vfov { degrees: 50.0, distance: 1.0 },
            Lens::Orthographic { height: 9.0 },
            Lens::Intrinsics { fx: 70.0, fy: 60.0, cx: 21.5, cy: 33.0 },
        ];
        for lens in lenses {
            let camera = Camera { eye: DVec3::new(1.0, 2.0, 9.0), look: Look::At(DVec3::ZERO), up: DVec3::Y, lens };
            for (n, center) in [[0.0, 0.0, 0.0], [0.7, -0.4, 1.2], [-1.1, 0.8, -2.0]].into_iter().enumerate() {
                let Projected { at: [x, y], scale } =
                    camera.project([64, 48], center.into()).expect("a camera").expect("in front");
                let mut spheres = Spheres::default();
                // Of a diameter of 1.2 pixels: the ray of the pixel's middle meets it if it is within 0.6.
                spheres.push(center, 0.6 / scale, None);
                let image = ImagePlane { width: 64, height: 48, ..ImagePlane::default() };
                let judge =
                    Judge::new(&Scene { camera, image, spheres, lighting: Default::default() }).expect("a scene");
                let [row, column] = [y, x].map(|place| place.floor() as u32);
                let away = (x - f64::from(column) - 0.5).hypot(y - f64::from(row) - 0.5);
                let hit = judge.pixel(row, column).is_some();
                // Pixels of the third lens are not square.
                assert!(hit || away > 0.5, "{lens:?} {n}: {x} {y}");
                assert!(
                    judge.pixel(row + 3, column).is_none() && judge.pixel(row, column - 3).is_none(),
                    "{lens:?} {n}"
                );
            }
            assert_eq!(camera.project([64, 48], DVec3::new(1.0, 2.0, 20.0)).expect("a camera"), None);
        }
    }
}
