//! The parts of hard cases: cameras, lenses, clouds of spheres.

use crate::suite::Random;
use glam::DVec3;
use halfline::scene::camera::{Camera, Lens, Look};
use halfline::scene::{ImagePlane, Scene, Skipped, Spheres};

/// The oblique direction of the measurements, of unit length within rounding.
pub(super) fn aslant() -> DVec3 {
    DVec3::new(1.0, 2.0, 3.0).normalize()
}

/// A picture of `spheres` from `eye`, slightly rolled.
pub(super) fn picture(eye: DVec3, look: Look, lens: Lens, size: [u32; 2], spheres: Spheres) -> Scene {
    let camera = Camera { eye, look, up: DVec3::new(0.1, 1.0, 0.2), lens };
    let image = ImagePlane { width: size[0], height: size[1], background: [0.0; 3] };
    Scene { camera, image, spheres, lighting: Default::default(), skipped: Skipped::default() }
}

/// The lens of a 4:3 picture that is half filled by a sphere whose angular radius has the tangent `tangent`: the radius
/// of its disc is 0.46 of the height.
pub(super) fn filled_by(tangent: f64) -> Lens {
    let vh = tangent / 0.46;
    Lens::Viewport { vw: vh * 4.0 / 3.0, vh, distance: 1.0 }
}

/// Tangent of the angular radius of a sphere of radius 1 whose centre is `distance` away.
pub(super) fn tangent(distance: f64) -> f64 {
    1.0 / ((distance - 1.0) * (distance + 1.0)).sqrt()
}

/// `count` spheres of radius `radii` in a cube of half side `side` about `at`.
pub(super) fn cloud(random: &mut Random, count: usize, at: DVec3, side: f64, radii: [f64; 2]) -> Spheres {
    let mut spheres = Spheres::default();
    for _ in 0..count {
        let center = at + side * DVec3::from_array(random.cube());
        spheres.push(center.to_array(), radii[0] + (radii[1] - radii[0]) * random.unit(), None);
    }
    spheres
}

/// One sphere.
pub(super) fn one(center: DVec3, radius: f64) -> Spheres {
    let mut spheres = Spheres::default();
    spheres.push(center.to_array(), radius, None);
    spheres
}

/// 10^k for k from `from` in steps of `step` up to `to`.
pub(super) fn decades(from: i32, to: i32, step: usize) -> impl Iterator<Item = f64> {
    (from..=to).step_by(step).map(|k| 10f64.powi(k))
}
