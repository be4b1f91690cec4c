//! A beam that widens to a cone, and what a scanner measures of its echoes.

use glam::DVec3;
use std::f64::consts::TAU;

/// The properties of each beam of a scanner that measures echoes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// The full angle of the cone in degrees; 0 for a beam that is one ray.
    pub divergence: f64,
    /// The most echoes of a beam.
    pub returns: u8,
    /// The standard deviation of the range noise, in units of the scene.
    pub noise: f64,
    /// The seed of the noise.
    pub seed: u32,
}

impl Default for Beam {
    fn default() -> Self {
        Self { divergence: 0.0, returns: 1, noise: 0.0, seed: 0 }
    }
}

/// The most echoes of a beam, as in LAS 1.4.
pub(super) const MAX_RETURNS: u8 = 15;

/// The rings of rays round the axis: their number of rays, the part of the cone's solid angle inside of the ring, in
/// shares of a ray, and the first angle round the axis in turns.
const RINGS: [(u32, f64, f64); 2] = [(6, 4.0, 0.0), (12, 13.0, 1.0 / 24.0)];

/// The rays of a cone: its axis and the rays of the rings.
const RAYS: u32 = 1 + RINGS[0].0 + RINGS[1].0;

impl Beam {
    /// The number of rays of a beam.
    #[must_use]
    pub fn rays(&self) -> u32 {
        if self.divergence > 0.0 { RAYS } else { 1 }
    }

    /// The directions of the rays beside the axis: the parts along the axis and along two directions across it. With the
    /// axis they stand for equal shares of the cone's solid angle, so each ring divides the solid angle of its rays into
    /// halves. The solid angle inside an angle a from the axis is 4 pi sin^2(a/2).
    pub(super) fn cone(&self) -> Vec<[f64; 3]> {
        if self.rays() == 1 {
            return Vec::new();
        }
        let edge = (self.divergence.to_radians() / 4.0).sin();
        let ring = |(count, inside, first): (u32, f64, f64)| {
            let (out, along) = (2.0 * (edge * (inside / f64::from(RAYS)).sqrt()).asin()).sin_cos();
            (0..count).map(move |n| {
                let (up, across) = (TAU * (first + f64::from(n) / f64::from(count))).sin_cos();
                [along, out * across, out * up]
            })
        };
        RINGS.into_iter().flat_map(ring).collect()
    }
}

/// The rays of a beam: its axis, and the rays of its cone. `frame` is the axis and two directions across it.
pub(super) fn rays(frame: [DVec3; 3], cone: &[[f64; 3]]) -> impl Iterator<Item = [f64; 3]> + '_ {
    let [axis, across, up] = frame;
    let direction = move |[a, b, c]: &[f64; 3]| a * axis + b * across + c * up;
    std::iter::once(axis).chain(cone.iter().map(direction)).map(|ray| ray.to_array())
}
