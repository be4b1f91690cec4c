//! Lights and sky of a scene.

use super::camera::{Basis, Camera};
use super::gradient::SkyColors;
use glam::DVec3;
use halfline_ground::check::check_color;
use halfline_ground::error::{Error, Place, Result};
use serde::{Deserialize, Serialize};
use std::fmt;

/// The lights, shadows, sky and bounces of a scene. The default is the light at the eye alone, which casts no shadow
/// that the camera sees.
///
/// ```
/// use halfline::{Light, LightSource, Lighting, Sky};
///
/// let sun = Light::white(LightSource::Direction([1.0, 2.0, 1.0].into()));
/// let lighting = Lighting { lights: vec![sun], shadows: true, sky: Some(Sky::default()), ..Lighting::default() };
/// assert!(lighting.has_light());
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lighting {
    /// The lights, in the order of the scene file. Without any, and without a sky, the light is at the eye.
    pub lights: Vec<Light>,
    /// Whether the lights cast shadows in the picture. The buffer `shadow` holds them in any case.
    pub shadows: bool,
    /// A sky, a part of it hidden by other spheres (ambient occlusion); `None` for no light from the sky.
    pub sky: Option<Sky>,
    /// The most times that a ray goes on from mirrors and through glass, up to [`MOST_BOUNCES`]; `None` for [`BOUNCES`]
    /// where a material asks for it.
    pub bounces: Option<u32>,
}

/// Bounces of a ray, unless stated otherwise.
pub const BOUNCES: u32 = 6;

/// The most bounces of a ray.
pub const MOST_BOUNCES: u32 = 64;

/// A light. A surface that faces it reflects its own colour times `color` times `intensity`, at any distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// The position or the direction of the light.
    pub source: LightSource,
    /// Linear RGB.
    pub color: [f32; 3],
    /// A factor of the colour.
    pub intensity: f32,
}

/// The position or the direction of a light. All numbers are taken as exact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum LightSource {
    /// Infinitely far in this direction, which points toward the light and has any length but zero.
    Direction(DVec3),
    /// A point.
    Point(DVec3),
    /// A sphere that shines and hides nothing.
    Ball {
        /// Its centre.
        center: DVec3,
        /// Its radius, positive.
        radius: f64,
    },
    /// The sphere of the scene with this index. It hides nothing of its own light, and shines where it is seen.
    Sphere(u32),
}

/// The sky: white, the same light from all directions, unless it has colours.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sky {
    /// Rays for each point, at least 1.
    pub rays: u32,
    /// A sphere farther than this from a point, in the scene's unit of length, hides nothing from it; +inf for any
    /// distance.
    pub reach: f64,
    /// Whether rays leave only from the hits of the centres of pixels, for all samples around. Otherwise rays leave from every
    /// sample. In both cases few rays are joined by the rays of the pixels around that show the same sphere.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub at_centers: bool,
    /// Its colours; `None` for white.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub colors: Option<SkyColors>,
    /// The share of its light that surfaces get: 1 for the sky of a file, which lights with the brightness that it is seen
    /// with; [`Sky::SHARE_WITH_LIGHTS`] for a sky that a look or an option adds where there are lights.
    #[serde(skip)]
    pub share: f32,
}

impl Sky {
    /// The share of an added sky where there are lights. Without lights it is all of the light, so that a white sphere under
    /// an open sky is white.
    pub const SHARE_WITH_LIGHTS: f32 = 0.5;

    /// Few rays from the centres of pixels.
    pub const AT_CENTERS: Self = Self { rays: 3, reach: f64::INFINITY, at_centers: true, colors: None, share: 1.0 };

    /// The rays at a pixel's centre, for pixels of so many samples: no fewer than half of the samples, so that the noise falls with
    /// their number.
    #[must_use]
    pub fn rays_at_center(&self, samples: u32) -> u32 {
        self.rays.max(samples / 2)
    }
}

/// The most rays for a point.
pub const MOST_RAYS: u32 = 1 << 20;

impl Default for Sky {
    /// 16 rays that end nowhere.
    fn default() -> Self {
        Self { rays: 16, reach: f64::INFINITY, at_centers: false, colors: None, share: 1.0 }
    }
}

impl LightSource {
    /// Whether it is more than a point, so that its shadows are soft.
    #[must_use]
    pub fn has_size(&self) -> bool {
        matches!(self, Self::Ball { .. } | Self::Sphere(_))
    }

    /// The direction of length 1 toward a light that is infinitely far.
    pub(crate) fn far(&self) -> Option<DVec3> {
        match *self {
            // The quotient keeps the squares within f64.
            Self::Direction(direction) => Some((direction / direction.abs().max_element()).normalize()),
            _ => None,
        }
    }
}

impl Light {
    /// A white light of intensity 1.
    #[must_use]
    pub fn white(source: LightSource) -> Self {
        Self { source, color: [1.0; 3], intensity: 1.0 }
    }

    /// A white light from above left of the viewer, and from the viewer's side of the scene: infinitely far in the
    /// direction -0.6 u + 0.9 v + w of the camera's basis, about 31 degrees to the left and 38 degrees up.
    ///
    /// # Errors
    /// Errors of [`Camera::basis`].
    pub fn above_left(camera: &Camera) -> Result<Self> {
        let Basis { u, v, w, .. } = camera.basis()?;
        Ok(Self::white(LightSource::Direction((-0.6 * u + 0.9 * v + w).normalize())))
    }

    /// Checks the light with this index, in a scene of that many spheres.
    ///
    /// # Errors
    /// [`Error::Scene`] at `place`, with the name of the field appended.
    pub fn check(&self, spheres: usize, place: impl Fn(&str) -> Place) -> Result<()> {
        let wrong = |field: &str, problem: String, mend: &str| Err(Error::scene(place(field), problem, mend));
        let finite = |field: &str, vector: DVec3| match vector.is_finite() {
            true => Ok(()),
            false => wrong(field, format!("{vector} is not finite"), "give three finite numbers"),
        };
        match self.source {
            LightSource::Direction(direction) => {
                finite("direction", direction)?;
                if direction == DVec3::ZERO {
                    return wrong("direction", "the direction has length zero".into(), "use a vector toward the light");
                }
            }
            LightSource::Point(position) => finite("position", position)?,
            LightSource::Ball { center, radius } => {
                finite("position", center)?;
                if !(radius > 0.0 && radius.is_finite()) {
                    return wrong("radius", format!("the radius is {radius}"), "give a positive finite number");
                }
            }
            LightSource::Sphere(id) if id as usize >= spheres => {
                return wrong("sphere", format!("there is no sphere {id}"), "give the index of a sphere, from 0");
            }
            LightSource::Sphere(_) => {}
        }
        check_color(self.color, || place("color"))?;
        if !(self.intensity >= 0.0 && self.intensity.is_finite()) {
            return wrong(
                "intensity",
                format!("the intensity is {}", self.intensity),
                "give a finite number, 0 or more",
            );
        }
        Ok(())
    }
}

impl fmt::Display for Light {
    /// The position or direction in words, the colour unless it is white, and the intensity unless it is 1.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.source {
            LightSource::Direction(DVec3 { x, y, z }) => write!(f, "infinitely far in the direction {x}, {y}, {z}")?,
            LightSource::Point(DVec3 { x, y, z }) => write!(f, "a point at {x}, {y}, {z}")?,
            LightSource::Ball { center: DVec3 { x, y, z }, radius } => {
                write!(f, "a ball at {x}, {y}, {z} of radius {radius}")?;
            }
            LightSource::Sphere(id) => write!(f, "sphere {id}")?,
        }
        let [r, g, b] = self.color;
        if self.color != [1.0; 3] {
            write!(f, ", colour {r}, {g}, {b}")?;
        }
        if self.intensity != 1.0 {
            write!(f, ", intensity {}", self.intensity)?;
        }
        Ok(())
    }
}

impl Sky {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Scene`] at `place`, with the name of the field appended.
    pub fn check(&self, place: impl Fn(&str) -> Place) -> Result<()> {
        if !(1..=MOST_RAYS).contains(&self.rays) {
            let problem = format!("the sky cannot have {} rays", self.rays);
            return Err(Error::scene(place("rays"), problem, format!("give a whole number between 1 and {MOST_RAYS}")));
        }
        if self.reach.is_nan() || self.reach <= 0.0 {
            let problem = format!("the reach is {}", self.reach);
            return Err(Error::scene(place("reach"), problem, "give a positive length, or remove it"));
        }
        self.colors.map_or(Ok(()), |colors| colors.check(place))
    }
}

impl Lighting {
    /// The light at the eye alone: no lights, no sky, and no bounces.
    #[must_use]
    pub fn from_the_eye() -> Self {
        Self { bounces: Some(0), ..Self::default() }
    }

    /// Whether lights or a sky light the scene, not only the light at the eye.
    #[must_use]
    pub fn has_light(&self) -> bool {
        !self.lights.is_empty() || self.sky.is_some()
    }

    /// Checks every light, the sky and the bounces.
    pub(super) fn check(&self, spheres: usize) -> Result<()> {
        if let Some(bounces) = self.bounces.filter(|bounces| *bounces > MOST_BOUNCES) {
            let mend = format!("give a whole number between 0 and {MOST_BOUNCES}");
            return Err(Error::scene("lighting.bounces", format!("a ray cannot bounce {bounces} times"), mend));
        }
        for (index, light) in self.lights.iter().enumerate() {
            light.check(spheres, |field| Place::field(format!("light {index} {field}")))?;
        }
        self.sky.map_or(Ok(()), |sky| sky.check(|field| Place::field(format!("occlusion.{field}"))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Look;

    #[test]
    fn a_light_from_above_left_turns_with_the_camera() {
        let toward = |camera: &Camera| match Light::above_left(camera).expect("a camera").source {
            LightSource::Direction(direction) => direction,
            other => panic!("{other:?}"),
        };
        let expected = DVec3::new(-0.6, 0.9, 1.0).normalize();
        assert!((toward(&Camera::CANONICAL) - expected).length() < 1e-15);
        let turned = Camera { look: Look::View(DVec3::X), up: DVec3::Z, ..Camera::CANONICAL };
        // The basis is u = -y, v = z, w = -x.
        let expected = DVec3::new(-1.0, 0.6, 0.9).normalize();
        assert!((toward(&turned) - expected).length() < 1e-15);
        Light::above_left(&Camera { up: DVec3::ZERO, ..turned }).expect_err("no basis");
    }
}
