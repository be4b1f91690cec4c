//! A scene of any size, for examples and benches/; benches/peers/run makes the same scene for other programs.

use glam::DVec3;
use halfline::{Camera, ImagePlane, Lens, Look, Scene, Spheres};

/// xorshift64* (Vigna 2016).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Equal spheres uniform in a unit cube, 3 % of its volume, the whole cube in view.
pub(crate) fn cloud(count: usize) -> Scene {
    let radius = (0.03 / count as f64 * 3.0 / (4.0 * std::f64::consts::PI)).cbrt();
    let mut random = Random(2026);
    let mut spheres = Spheres::default();
    for _ in 0..count {
        spheres.push([0; 3].map(|_| random.unit()), radius, None);
    }
    let camera = Camera {
        eye: DVec3::new(2.2, 1.6, 2.9),
        look: Look::At(DVec3::splat(0.5)),
        up: DVec3::Y,
        lens: Lens::Vfov { degrees: 32.0, distance: 1.0 },
    };
    Scene { camera, image: ImagePlane::default(), spheres, lighting: Default::default() }
}
