//! The colours of a sky: a gradient from the horizon to the zenith.

use super::Scene;
use glam::DVec3;
use halfline_ground::check::check_color;
use halfline_ground::error::{Place, Result};
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
    pub(crate) up: DVec3,
    pub(crate) horizon: DVec3,
    /// From the horizon to the zenith.
    pub(crate) change: DVec3,
    pub(crate) is_shown: bool,
}

impl Gradient {
    /// The gradient of a scene's sky; `None` where the sky has no colours.
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
        self.horizon + self.change * self.zenith(direction)
    }

    /// The zenith's share of the colour in a direction of length 1.
    pub(crate) fn zenith(&self, direction: DVec3) -> f64 {
        zenith_share(direction.dot(self.up))
    }
}

/// The zenith's share at the sine of an elevation.
fn zenith_share(sine: f64) -> f64 {
    let below = 1.0 - sine.clamp(0.0, 1.0);
    let square = below * below;
    let fourth = square * square;
    1.0 - fourth * fourth
}

/// Cells of the table of [`SkyLight`], and points of its sums: elevations, and angles of half a turn about the zenith.
pub(crate) const CELLS: usize = 32;
const ELEVATIONS: usize = 64;
const ANGLES: usize = 16;

/// The light of an open sky on a surface: the mean of its colours over the half space of the normal, weighted by the
/// cosine. Rays have to find only the hidden share, and where nothing hides the sky there is no noise.
#[derive(Debug, Clone)]
pub(crate) struct SkyLight {
    pub(crate) gradient: Gradient,
    /// Its directions and colours in f32.
    up: [f32; 3],
    horizon: [f32; 3],
    change: [f32; 3],
    /// The zenith's share for normals whose product with `up` is -1, -1 + 2/CELLS, .. 1.
    pub(crate) shares: [f32; CELLS + 1],
}

impl SkyLight {
    pub(crate) fn new(gradient: Gradient) -> Self {
        // Half of an angle below a half turn, from its cosine; 45 degrees first.
        let half = |[cosine, _]: [f64; 2]| [1.0, -1.0].map(|sign| ((1.0 + sign * cosine) / 2.0).sqrt());
        let step = half(half([0.5f64.sqrt(); 2]));
        let next = |[x, y]: &[f64; 2]| Some([x * step[0] - y * step[1], x * step[1] + y * step[0]]);
        let angles: Vec<[f64; 2]> = std::iter::successors(Some(half(step)), next).take(ANGLES).collect();
        let share = |cell: usize| {
            let high = 2.0 * cell as f64 / CELLS as f64 - 1.0;
            let horizontal = (1.0 - high * high).sqrt();
            let (mut sum, mut all) = (0.0, 0.0);
            for k in 0..ELEVATIONS {
                let sine = (2.0 * k as f64 + 1.0) / ELEVATIONS as f64 - 1.0;
                let along = (1.0 - sine * sine).sqrt();
                let cosines = angles.iter().map(|[x, _]| (high * sine + horizontal * along * x).max(0.0));
                let weight: f64 = cosines.sum();
                sum += weight * zenith_share(sine);
                all += weight;
            }
            (sum / all) as f32
        };
        let [up, horizon, change] =
            [gradient.up, gradient.horizon, gradient.change].map(|vector| vector.as_vec3().to_array());
        Self { gradient, up, horizon, change, shares: std::array::from_fn(share) }
    }

    /// The light that an open sky gives to a surface with this normal of length 1.
    #[inline(always)]
    pub(crate) fn open(&self, normal: [f32; 3]) -> [f32; 3] {
        let [[x, y, z], up] = [normal, self.up];
        let sine = x * up[0] + y * up[1] + z * up[2];
        let place = (sine.clamp(-1.0, 1.0) + 1.0) / 2.0 * CELLS as f32;
        let cell = (place as usize).min(CELLS - 1);
        let part = place - cell as f32;
        self.sum(1.0, self.shares[cell] + (self.shares[cell + 1] - self.shares[cell]) * part)
    }

    /// The sum of the colours in directions with weights: from the sum of the weights, and the sum of the weights times
    /// [`Gradient::zenith`].
    #[inline(always)]
    pub(crate) fn sum(&self, weights: f32, zenith: f32) -> [f32; 3] {
        [0, 1, 2].map(|k| self.horizon[k] * weights + self.change[k] * zenith)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Camera;
    use crate::scene::{ImagePlane, Lighting, Sky, Spheres};
    use glam::Vec3;

    fn gradient(up: DVec3) -> Gradient {
        let colors = SkyColors { zenith: [0.0, 0.25, 1.0], horizon: [1.0, 0.5, 0.5], is_shown: true };
        let sky = Some(Sky { colors: Some(colors), ..Sky::default() });
        let scene = Scene {
            camera: Camera { up, ..Camera::CANONICAL },
            image: ImagePlane::default(),
            spheres: Spheres::default(),
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
        let toward = |angle: f64| sky.toward(DVec3::new(angle.cos(), 0.0, angle.sin()));
        let rising: Vec<f64> = (0..=90).map(|angle| toward(f64::from(angle).to_radians()).z).collect();
        assert!(
            rising.windows(2).all(|pair| pair[0] <= pair[1]) && rising[2] > 0.6,
            "most of the change is low: {rising:?}"
        );
    }

    /// Against the mean over a million independent directions.
    #[test]
    fn an_open_sky_gives_the_mean_of_its_colours() {
        let light = SkyLight::new(gradient(DVec3::Y));
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for normal in [DVec3::Y, DVec3::X, DVec3::NEG_Y, DVec3::new(0.6, 0.8, 0.0), DVec3::new(0.28, -0.96, 0.0)] {
            let (mut sum, mut all) = (DVec3::ZERO, 0.0);
            for _ in 0..1_000_000 {
                let (z, angle) = (2.0 * random() - 1.0, std::f64::consts::TAU * random());
                let across = (1.0 - z * z).sqrt();
                let direction = DVec3::new(across * angle.cos(), z, across * angle.sin());
                let weight = direction.dot(normal).max(0.0);
                sum += light.gradient.toward(direction) * weight;
                all += weight;
            }
            // The mean over n random directions has an error of at most about 1/sqrt n, and the table's sums and its
            // interpolation were seen to err by at most 0.002.
            let found = Vec3::from_array(light.open(normal.as_vec3().to_array())).as_dvec3();
            let error = (found - sum / all).abs().max_element();
            assert!(error < 4e-3, "{normal}: {error}");
        }
    }
}
