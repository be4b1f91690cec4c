//! The middle of a picture as text, small enough for a record.

use super::Score;
use crate::record::Crop;
use glam::DVec3;
use halfline::error::Result;
use halfline::frame::{Aov, Frame};
use halfline::scene::Scene;

/// The most pixels along a side.
const SIDE: u32 = 64;

impl Score {
    /// The middle of the frame that was scored: the headlight brightness of each pixel, without colours, and the
    /// verdict on it.
    ///
    /// # Errors
    /// Errors of [`halfline::scene::camera::Camera::basis`] and of [`halfline::scene::camera::Camera::viewport`].
    pub fn crop(&self, scene: &Scene, frame: &Frame) -> Result<Crop> {
        let [width, height] = self.size;
        let size = self.size.map(|side| side.min(SIDE));
        let [left, top] = [(width - size[0]) / 2, (height - size[1]) / 2];
        let (basis, lens) = (scene.camera.basis()?, scene.camera.viewport(width, height)?);
        let normals = frame.f32(Aov::Normal).unwrap_or_default();
        let mut crop = Crop { size, ..Crop::default() };
        for i in top..top + size[1] {
            for j in left..left + size[0] {
                let k = i as usize * width as usize + j as usize;
                let part = |n: u32, side: u32| (f64::from(n) + 0.5) / f64::from(side) - 0.5;
                let ray =
                    basis.u * (part(j, width) * lens.vw) - basis.v * (part(i, height) * lens.vh) - basis.w * lens.d;
                let normal = normals.get(3 * k..3 * k + 3).unwrap_or(&[0.0; 3]);
                let normal = DVec3::from_array(std::array::from_fn(|c| f64::from(normal[c])));
                crop.shade.push(shade(frame.ids()[k] >= 0, -normal.dot(ray.normalize())));
                crop.verdict.push(self.pixels[k].verdict.letter());
            }
        }
        Ok(crop)
    }
}

/// One of 16 levels of brightness; NaN is dark.
fn shade(hit: bool, cosine: f64) -> char {
    let level = (16.0 * cosine).clamp(0.0, 15.0) as u32;
    if hit { char::from_digit(level, 16).unwrap_or('0') } else { '.' }
}
