//! The camera of a film, whose frames are held to the first one that shows something. [`Sequence`](super::Sequence) holds radii
//! and colours.

use super::sequence::SceneFrame;
use glam::DVec3;
use halfline::error::Result;
use halfline::progress::Watch;
use halfline::scene::arrange::Arrangement;
use halfline::scene::camera::Camera;

/// The camera that the frames of a film have. Every frame passes [`FixedCamera::see`] with the spheres of the file and, once
/// they are arranged, [`FixedCamera::apply`]; so do frames that only set what the others are held to
/// ([`Sequence::unselected_first`](super::Sequence::unselected_first)).
#[derive(Debug, Clone)]
pub struct FixedCamera {
    holds: bool,
    /// The camera of all frames, once it is known.
    pub camera: Option<Camera>,
    /// The middle of the spheres of the frame that sets the camera, in a film that is held to one.
    pub middle: Option<DVec3>,
}

impl FixedCamera {
    /// `holds`: whether the first frame with spheres sets the camera of the following ones.
    #[must_use]
    pub fn new(holds: bool) -> Self {
        Self { holds, camera: None, middle: None }
    }

    /// Sets the camera by a frame that the clip planes empty, as it is without them: the camera of a film must not depend on
    /// which of its frames is the first that they leave something of. `point` gives a frame its size and its camera.
    ///
    /// # Errors
    /// As [`Arrangement::apply`], and errors of `point`.
    pub fn see(
        &mut self,
        frame: &mut SceneFrame,
        arrangement: &Arrangement,
        watch: &Watch,
        point: impl FnOnce(&mut SceneFrame) -> Result<()>,
    ) -> Result<()> {
        let is_open = self.holds && self.camera.is_none();
        if !is_open || !arrangement.leaves_nothing(&frame.scene.spheres, frame.cell.as_ref(), watch)? {
            return Ok(());
        }
        let mut whole = frame.copy();
        let unclipped = Arrangement { clip: Vec::new(), ..arrangement.clone() };
        unclipped.apply(&mut whole.scene.spheres, whole.cell.as_ref(), watch)?;
        point(&mut whole)?;
        self.camera = Some(whole.scene.camera);
        self.middle.get_or_insert(whole.scene.spheres.middle());
        Ok(())
    }

    /// Gives a frame the camera of the film, or else its own by `point`, which the following ones then have.
    ///
    /// # Errors
    /// Errors of `point`.
    pub fn apply(&mut self, frame: &mut SceneFrame, point: impl FnOnce(&mut SceneFrame) -> Result<()>) -> Result<()> {
        // A frame without spheres has nothing to hold to.
        let holds = self.holds && !frame.scene.spheres.is_empty();
        if holds && self.middle.is_none() {
            self.middle = Some(frame.scene.spheres.middle());
        }
        match self.camera {
            Some(camera) => frame.scene.camera = camera,
            None => {
                point(frame)?;
                self.camera = holds.then_some(frame.scene.camera);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::scene::{Framing, ImagePlane, Scene, Spheres};

    /// A frame with spheres of radius 1 at these places on the x axis.
    fn frame(number: u64, places: &[f64]) -> SceneFrame {
        let mut spheres = Spheres::default();
        places.iter().for_each(|x| spheres.push([*x, 0.0, 0.0], 1.0, None));
        let scene =
            Scene { camera: Camera::CANONICAL, image: ImagePlane::default(), spheres, lighting: Default::default() };
        SceneFrame::new(number, scene)
    }

    fn framed(frame: &mut SceneFrame) -> Result<()> {
        frame.scene.frame_all(&Framing::default())
    }

    /// The eyes of frames that show the half space x <= 10.
    fn eyes(holds: bool, frames: &[&[f64]]) -> Vec<f64> {
        let arrangement = Arrangement { clip: vec![[1.0, 0.0, 0.0, 10.0]], ..Arrangement::default() };
        let (watch, mut fixed) = (Watch::default(), FixedCamera::new(holds));
        let eye = |(number, places): (u64, &&[f64])| {
            let mut frame = frame(number, places);
            fixed.see(&mut frame, &arrangement, &watch, framed).expect("a camera");
            arrangement.apply(&mut frame.scene.spheres, None, &watch).expect("spheres");
            fixed.apply(&mut frame, framed).expect("a camera");
            frame.scene.camera.eye.x
        };
        (1..).zip(frames).map(eye).collect()
    }

    /// The eye is in front of the middle of what it frames, in exact numbers here.
    #[test]
    fn a_film_has_the_camera_of_the_first_frame_that_has_spheres() {
        let films: [(&[&[f64]], [f64; 3]); 3] = [
            (&[&[0.0, 4.0], &[6.0, 10.0], &[2.0]], [2.0; 3]),
            // Clipped away as a whole.
            (&[&[20.0, 24.0], &[6.0, 10.0], &[2.0]], [22.0; 3]),
            // In part: what is left sets the camera.
            (&[&[4.0, 20.0], &[6.0, 10.0], &[2.0]], [4.0; 3]),
        ];
        let close = |found: &[f64], expected: &[f64]| {
            // A distance of some 10 radii is rounded some times.
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}, not {expected:?}");
        };
        for (frames, expected) in films {
            close(&eyes(true, frames), &expected);
        }
        close(&eyes(true, &[&[], &[6.0, 10.0], &[2.0]])[1..], &[8.0, 8.0]);
        close(&eyes(false, films[0].0), &[2.0, 8.0, 2.0]);
    }
}
