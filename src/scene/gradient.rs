//! The colours of a sky: a gradient from the horizon to the zenith.

use super::Scene;
use super::check::check_color;
use crate::error::{Place, Result};
use glam::DVec3;
use serde::Serialize;

/// The colours of a sky, linear RGB.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SkyColors {
    /// Along the camera's `up`.
    pub zenith: [f32; 3],
    /// At right angles to it, and below.
    pub horizon: [f32; 3],
    /// Whether rays that hit nothing show the sky; else they show the background of the image. It lights surfaces either way.
    pub is_shown: bool,
}

impl SkyColors {
    /// Checks the colours.
    pub(super) fn check(&self, place: impl Fn(&str) -> Place) -> Result<()> {
        check_color(self.zenith, || place("zenith"))?;
        check_color(self.horizon, || place("horizon"))
    }
}

/// The colours of a scene's sky by direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gradient {
    up: DVec3,
    horizon: DVec3,
    /// From the horizon to the zenith.
    change: DVec3,
    pub(crate) is_shown: bool,
}

impl Gradient {
    /// That of a scene; `None` where its sky has no colours.
    pub(crate) fn of(scene: &Scene) -> Option<Self> {
        let SkyColors { zenith, horizon, is_shown } = scene.lighting.sky?.colors?;
        let [horizon, zenith] = [horizon, zenith].map(|color| DVec3::from_array(color.map(f64::from)));
        let up = scene.camera.up;
        // The quotient keeps the squares within f64.
        let up = (up / up.abs().max_element()).normalize();
        Some(Self { up, horizon, change: zenith - horizon, is_shown })
    }

    /// The colour in a direction of length 1. With s the sine of its elevation above the horizon, the zenith has the share
    /// 1 - (1 - s)^8, and none below: as in a clear sky, most of the change is near the horizon. Multiplications and sums alone, so that the
    /// bits are the same on every machine.
    pub(crate) fn toward(&self, direction: DVec3) -> DVec3 {
        let below = 1.0 - direction.dot(self.up).clamp(0.0, 1.0);
        let square = below * below;
        let fourth = square * square;
        self.horizon + self.change * (1.0 - fourth * fourth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Camera;
    use crate::scene::{ImagePlane, Lighting, Skipped, Sky, Spheres};

    fn gradient(up: DVec3) -> Gradient {
        let colors = SkyColors { zenith: [0.0, 0.25, 1.0], horizon: [1.0, 0.5, 0.5], is_shown: true };
        let sky = Some(Sky { colors: Some(colors), ..Sky::default() });
        let scene = Scene {
            camera: Camera { up, ..Camera::CANONICAL },
            image: ImagePlane::default(),
            spheres: Spheres::default(),
            skipped: Skipped::default(),
            lighting: Lighting { sky, ..Lighting::default() },
        };
        Gradient::of(&scene).expect("colours")
    }

    #[test]
    fn the_colour_follows_the_elevation_against_the_camera_s_up() {
        let sky = gradient(DVec3::new(0.0, 0.0, 1e-300));
        for (direction, share) in [
            (DVec3::Z, 1.0),
            (DVec3::X, 0.0),
            (DVec3::NEG_Z, 0.0),
            (DVec3::new(0.6, 0.0, -0.8), 0.0),
            // The sine 1/2: 1 - 2^-8.
            (DVec3::new(0.75f64.sqrt(), 0.0, 0.5), 0.99609375),
        ] {
            let expected = DVec3::new(1.0 - share, 0.5 - 0.25 * share, 0.5 + 0.5 * share);
            // A few roundings of numbers up to 1.
            assert!((sky.toward(direction) - expected).abs().max_element() < 1e-15, "{direction}");
        }
        let rising: Vec<f64> = (0..=90).map(|angle| f64::from(angle).to_radians()).map(|angle| sky.toward(DVec3::new(angle.cos(), 0.0, angle.sin())).z).collect();
        assert!(rising.windows(2).all(|pair| pair[0] <= pair[1]) && rising[2] > 0.6, "most of the change is low: {rising:?}");
    }
}
