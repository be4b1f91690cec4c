//! A lens with a size: what lies off its plane of focus is blurred.
//!
//! A point L of the lens is an eye of its own. The ray of the pinhole through the point (u, v, -d) of the viewport meets the
//! plane of focus, at distance F, in (F/d) (u, v, -d). From L = e + a u + b v the same point is seen in the direction
//! (u - a d/F, v - b d/F, -d): the viewport of that eye is moved by a d/F to the left and b d/F down. The move is a whole
//! number of the places that rays go through, rounded to the nearest. So every ray belongs to a pixel of a frame whose
//! numbers are exact.

use super::{Basis, CURVED, Camera, CentredFrame, Look, Viewport, wrong};
use halfline_ground::error::Result;

/// A round lens around the eye, perpendicular to the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aperture {
    /// Diameter, in the scene's unit.
    pub diameter: f64,
    /// Distance of the plane in focus from the eye along the view, in the scene's unit; `None` for the plane of the point
    /// that the camera looks at.
    pub focus: Option<f64>,
}

impl Aperture {
    /// Samples of a picture unless a number is given: discs of blur of 16 pixels have no visible steps.
    pub const SAMPLES: u32 = 64;

    /// The distance of the plane in focus.
    ///
    /// # Errors
    /// [`Error::Scene`](crate::Error::Scene) for a diameter or a distance that is not positive and finite, for parallel rays and curved lenses, and where neither a
    /// distance nor a point to look at is given.
    pub fn distance(&self, camera: &Camera) -> Result<f64> {
        if camera.lens.is_orthographic() {
            let problem = "an orthographic camera has no lens, as its rays do not meet";
            return Err(wrong("aperture", problem, "remove the aperture, or use vfov"));
        }
        if camera.lens.is_curved() {
            let problem = format!("a lens with a size is one of a plane, and this lens has {CURVED}");
            return Err(wrong("aperture", problem, "remove the aperture, or use vfov"));
        }
        if !(self.diameter > 0.0 && self.diameter.is_finite()) {
            let problem = format!("the diameter of the lens is {}", self.diameter);
            return Err(wrong("aperture", problem, "use a positive length, or remove it"));
        }
        let focus = match (self.focus, camera.look) {
            (Some(focus), _) => focus,
            (None, Look::At(at)) => (at - camera.eye).length(),
            (None, Look::View(_)) => {
                let problem = "the camera has an aperture and looks at no point, so no plane is in focus";
                return Err(wrong("focus", problem, "give the distance in focus, or a point `at` to look at"));
            }
        };
        if !(focus > 0.0 && focus.is_finite()) {
            return Err(wrong("focus", format!("the distance in focus is {focus}"), "use a positive length"));
        }
        Ok(focus)
    }

    /// The camera at a point of the lens, which is given in the unit disc, and the offset of its frame from the frame
    /// of the eye: columns to the right and rows down, in places of `frame`.
    ///
    /// The eye is the point rounded to f64, and exact from here on; the move is computed from the rounded point.
    ///
    /// # Errors
    /// Errors of [`Aperture::distance`] and of [`Camera::basis`].
    pub(crate) fn at(&self, [x, y]: [f64; 2], camera: &Camera, frame: &CentredFrame) -> Result<(Camera, [f64; 2])> {
        let focus = self.distance(camera)?;
        let Basis { e, u, v, .. } = camera.basis()?;
        let radius = self.diameter / 2.0;
        let eye = e + u * (radius * x) + v * (radius * y);
        let look = match camera.look {
            Look::At(at) => at - e,
            Look::View(view) => view,
        };
        let ([vw, vh], d) = (frame.viewport.rounded(), frame.viewport.d);
        let places = |along: f64, side: f64, count: u32| (along / focus * (d / side) * f64::from(count)).round();
        let lens_offset = [places((eye - e).dot(u), vw, frame.size[0]), -places((eye - e).dot(v), vh, frame.size[1])];
        Ok((Camera { eye, look: Look::View(look), ..*camera }, lens_offset))
    }

    /// The largest offset of the frame of a point of the lens from the frame of the eye, in pixels of an image of
    /// `width` x `height`.
    ///
    /// # Errors
    /// Errors of [`Aperture::distance`] and of [`Camera::viewport`].
    pub(crate) fn reach(&self, camera: &Camera, [width, height]: [u32; 2]) -> Result<f64> {
        let Viewport { vw, vh, d } = camera.viewport(width, height)?;
        let pitch = (vw / f64::from(width)).min(vh / f64::from(height));
        Ok(self.diameter / 2.0 / self.distance(camera)? * (d / pitch))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Lens;
    use glam::DVec3;

    fn camera(look: Look, lens: Lens) -> Camera {
        Camera { eye: DVec3::new(1.0, 2.0, 3.0), look, up: DVec3::new(0.1, 1.0, 0.2), lens }
    }

    #[test]
    fn the_plane_in_focus_is_that_of_the_point_looked_at_unless_it_is_given() {
        let lens = Lens::Vfov { degrees: 40.0, distance: 1.0 };
        let (at, view) = (camera(Look::At(DVec3::new(1.0, 5.0, -1.0)), lens), camera(Look::View(DVec3::X), lens));
        let aperture = |diameter, focus| Aperture { diameter, focus };
        assert_eq!(aperture(0.5, None).distance(&at).expect("a point"), 5.0);
        assert_eq!(aperture(0.5, Some(7.0)).distance(&at).expect("a distance"), 7.0);
        assert_eq!(aperture(0.5, Some(7.0)).distance(&view).expect("a distance"), 7.0);
        let parallel = camera(at.look, Lens::Orthographic { height: 1.0 });
        for (aperture, camera, field) in [
            (aperture(0.5, None), &view, "focus"),
            (aperture(0.5, Some(0.0)), &at, "focus"),
            (aperture(0.5, Some(f64::INFINITY)), &at, "focus"),
            (aperture(0.0, None), &at, "aperture"),
            (aperture(f64::NAN, None), &at, "aperture"),
            (aperture(0.5, None), &parallel, "aperture"),
        ] {
            let error = aperture.distance(camera).expect_err(field).to_string();
            assert!(error.contains(&format!("camera.{field}")), "{error}");
        }
    }

    /// Every ray of a point of the lens passes the place in focus of the same ray of the eye, within half a place.
    #[test]
    fn what_is_in_focus_stays_in_place() {
        let lenses = [
            Lens::Vfov { degrees: 40.0, distance: 2.5 },
            Lens::Viewport { vw: 3.0, vh: 1.0, distance: 2.0 },
            Lens::Intrinsics { fx: 70.0, fy: 90.0, cx: 11.25, cy: 40.5 },
        ];
        for lens in lenses {
            let camera = camera(Look::At(DVec3::new(-4.0, 3.0, 9.0)), lens);
            let frame = camera.centred([60, 40], 2, 16).expect("a frame");
            let aperture = Aperture { diameter: 1.5, focus: Some(6.0) };
            for point in [[0.3, -0.8], [-0.9, 0.1], [0.0, 0.0], [0.5, 0.5]] {
                let (other, lens_offset) = aperture.at(point, &camera, &frame).expect("a camera");
                let (b, basis) = (camera.basis().expect("a basis"), other.basis().expect("a basis"));
                assert!((basis.u - b.u).length() + (basis.w - b.w).length() < 1e-15);
                let off = other.eye - camera.eye - 0.75 * (point[0] * b.u + point[1] * b.v);
                assert!(off.length() < 1e-15, "{point:?}: {off}");
                let moved = frame.moved(lens_offset).expect("a frame");
                // Where the ray of a place of a frame meets the plane in focus.
                let meets = |camera: &Camera, frame: &CentredFrame, [column, row]: [u32; 2]| {
                    let ([vw, vh], d) = (frame.viewport.rounded(), frame.viewport.d);
                    let part = |n: u32, count: u32| (f64::from(n) + 0.5) / f64::from(count) - 0.5;
                    let x = part(column * frame.step + frame.shift[0], frame.size[0]) * vw;
                    let y = -part(row * frame.step + frame.shift[1], frame.size[1]) * vh;
                    camera.eye + 6.0 / d * (x * b.u + y * b.v) - 6.0 * b.w
                };
                let place = 6.0 / frame.viewport.d * frame.viewport.vw / f64::from(frame.size[0]);
                let tall = 6.0 / frame.viewport.d * frame.viewport.rounded()[1] / f64::from(frame.size[1]);
                for at in [[0, 0], [777, 3], [1919, 1279]] {
                    let between = meets(&other, &moved, at) - meets(&camera, &frame, at);
                    let [right, up] = [between.dot(b.u) / place, between.dot(b.v) / tall];
                    // Half a place, and the roundings of f64.
                    assert!(right.abs() < 0.5 + 1e-9 && up.abs() < 0.5 + 1e-9, "{lens:?} {point:?}: {right} {up}");
                }
                let reach = aperture.reach(&camera, [60, 40]).expect("a lens") * f64::from(frame.size[0]) / 60.0;
                assert!(
                    lens_offset.iter().all(|n| n.abs() <= reach.max(f64::from(frame.size[1]) / 40.0 * reach) + 1.0)
                );
            }
        }
    }
}
