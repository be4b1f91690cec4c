//! A scene of any size, for price.rs and benches/; benches/peers/run makes the same scene for other programs.

use glam::DVec3;
use halfline::{Camera, ImagePlane, Lens, Look, Scene, Spheres};

/// Equal spheres uniform in a unit cube, 3 % of its volume, the whole cube in view.
pub(crate) fn cloud(count: usize) -> Scene {
    let radius = (0.03 / count as f64 * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    let mut state = 2026u64;
    // xorshift64* (Vigna 2016).
    let mut next = || {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut spheres = Spheres::default();
    for _ in 0..count {
        spheres.push([next(), next(), next()], radius, None);
    }
    let camera = Camera {
        eye: DVec3::new(2.2, 1.6, 2.9),
        look: Look::At(DVec3::splat(0.5)),
        up: DVec3::Y,
        lens: Lens::Vfov { degrees: 32.0, distance: 1.0 },
    };
    Scene { camera, image: ImagePlane::default(), spheres, lighting: Default::default() }
}
