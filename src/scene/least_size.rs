//! A least size of spheres in a picture, so that what would be smaller than a pixel is seen: planets of a system, far particles.

use super::Scene;
use glam::DVec3;
use halfline_ground::check::is_radius;
use halfline_ground::error::Result;
use halfline_ground::parallel;

impl Scene {
    /// Enlarges each sphere in front of the camera that would be less than so many pixels wide, at the depth of its centre; returns
    /// their number. What is rendered then are the enlarged spheres, in every buffer.
    ///
    /// # Errors
    /// Errors of [`Camera::projector`](super::camera::Camera::projector).
    pub fn enlarge_to(&mut self, pixels: f64) -> Result<u64> {
        let projector = self.camera.projector([self.image.width, self.image.height])?;
        let spheres = &self.spheres;
        let least = |n: usize| {
            let placed = projector.place(DVec3::from_array(spheres.centers[n]));
            placed
                .map(|placed| 0.5 * pixels / placed.scale)
                .filter(|radius| is_radius(radius) && *radius > spheres.radii[n])
        };
        let enlarged = parallel::count(spheres.len(), |n| least(n).is_some());
        if enlarged > 0 {
            let radii = parallel::from_fn(spheres.len(), |n| least(n).unwrap_or(spheres.radii[n]));
            self.spheres.radii = radii.into();
        }
        Ok(enlarged as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::super::camera::{Camera, Lens};
    use super::super::{ImagePlane, Lighting, Spheres};
    use super::*;

    /// 100 pixels for 1 at distance 1: a radius of 0.01 at distance 10 is a tenth of a pixel.
    #[test]
    fn small_spheres_in_front_of_the_eye_are_enlarged() {
        let mut spheres = Spheres::default();
        for (center, radius) in
            [([0.0, 0.0, -10.0], 0.01), ([3.0, 0.0, -100.0], 0.01), ([0.0, 0.0, -5.0], 1.0), ([0.0, 0.0, 9.0], 0.01)]
        {
            spheres.push(center, radius, None);
        }
        let image = ImagePlane { width: 100, height: 100, ..ImagePlane::default() };
        let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Lighting::default() };
        let radii = |scene: &Scene, pixels: f64| {
            let mut scene = scene.clone();
            let enlarged = scene.enlarge_to(pixels).expect("a camera");
            (enlarged, scene.spheres.radii.to_vec())
        };
        assert_eq!(radii(&scene, 4.0), (2, vec![0.2, 2.0, 1.0, 0.01]));
        assert_eq!(radii(&scene, 0.01), (0, vec![0.01, 0.01, 1.0, 0.01]));
        // Parallel rays: 100 pixels for 50 at any depth.
        let parallel = Camera { lens: Lens::Orthographic { height: 50.0 }, ..scene.camera };
        assert_eq!(radii(&Scene { camera: parallel, ..scene }, 4.0), (2, vec![1.0, 1.0, 1.0, 0.01]));
    }
}
