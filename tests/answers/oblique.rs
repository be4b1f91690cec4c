//! Scenes whose camera has no axis along one of the world's.

use glam::DVec3;
use halfline::camera::{Camera, Lens, Look};
use halfline::scene::{ImagePlane, Scene, Spheres};

/// The spheres seen from `eye` toward `at`, with a tilted `up`, no lights, and an image of width and height `size`.
pub(crate) fn scene([width, height]: [u32; 2], eye: [f64; 3], at: [f64; 3], lens: Lens, spheres: Spheres) -> Scene {
    Scene {
        camera: Camera { eye: eye.into(), look: Look::At(at.into()), up: DVec3::new(0.1, 1.0, 0.2), lens },
        image: ImagePlane { width, height, background: [0.1, 0.2, 0.3] },
        spheres,
        lighting: Default::default(),
    }
}

/// A lens of this full height in degrees.
pub(crate) fn vfov(degrees: f64) -> Lens {
    Lens::Vfov { degrees, distance: 1.0 }
}
