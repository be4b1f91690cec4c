//! The looks of a picture, and the light that options add to a scene: one rule for the command and the Python package.

use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::scene::{Light, LightSource, Lighting, Materials, Scene, Sky};
use crate::shade::Shade;
use glam::DVec3;
use std::str::FromStr;

/// Rays to the sky for each pixel in the look `soft`. They leave from the pixel's centre, and each sample takes the mean of the
/// pixels around it: about as little noise as from 8 times 4 rays, in the time of these.
const SOFT_RAYS: u32 = 4;

/// A name for several options.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Look {
    /// Nothing.
    #[default]
    Plain,
    /// For particles: a sky, lines, and a light from above left of the camera where the scene has none.
    Soft,
    /// For print: flat colours, lines, and depth that fades.
    Figure,
}

impl Look {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Plain, Self::Soft, Self::Figure];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Soft => "soft",
            Self::Figure => "figure",
        }
    }

    /// The shading that it stands for, if any.
    #[must_use]
    pub fn shade(self) -> Option<Shade> {
        (self == Self::Figure).then_some(Shade::Flat)
    }

    /// Whether dark lines are drawn where the depth jumps.
    #[must_use]
    pub fn has_silhouette(self) -> bool {
        self != Self::Plain
    }

    /// Whether colours fade with depth.
    #[must_use]
    pub fn has_depth_cue(self) -> bool {
        self == Self::Figure
    }

    /// Rays to the sky for each pixel of so many samples; `None` without a sky. Without samples their noise would not average
    /// out, and they are as many as usual.
    #[must_use]
    pub fn sky_rays(self, samples: u32) -> Option<u32> {
        (self == Self::Soft).then(|| if samples > 1 { SOFT_RAYS } else { Sky::default().rays })
    }
}

impl FromStr for Look {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        crate::error::by_name("look", name, Self::ALL, Self::name)
    }
}

/// What options add to the light of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AddedLight {
    /// The look of the picture.
    pub look: Look,
    /// Samples per pixel.
    pub samples: u32,
    /// White lights infinitely far in these directions.
    pub suns: Vec<DVec3>,
    /// Whether lights cast shadows. In a scene without lights there is then one from above left of the camera.
    pub shadows: bool,
    /// A sky with so many rays for each point; `Some(None)` for as many as the scene's, else the usual number.
    pub occlusion: Option<Option<u32>>,
    /// The reach of the sky.
    pub reach: Option<f64>,
    /// The most bounces of a ray.
    pub bounces: Option<u32>,
}

impl AddedLight {
    /// Adds it to a scene, whose camera is final. Bounces are set where a material asks for any.
    ///
    /// # Errors
    /// Those of [`Light::above_left`].
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        if let Some(bounces) = self.bounces.filter(|_| bounces_at_all(scene)) {
            scene.lighting.bounces = Some(bounces);
        }
        let Lighting { lights, shadows, sky, .. } = &mut scene.lighting;
        lights.extend(self.suns.iter().map(|sun| Light::white(LightSource::Direction(*sun))));
        if lights.is_empty() && (self.shadows || self.look == Look::Soft) {
            lights.push(Light::above_left(&scene.camera)?);
        }
        *shadows |= self.shadows;
        // The sky of the scene comes before that of the look.
        let own = sky.map(|sky| sky.rays);
        let of_look = self.look.sky_rays(self.samples);
        let rays = match self.occlusion {
            Some(rays) => rays.or(own).or(Some(Sky::default().rays)),
            None => own.or(of_look),
        };
        let at_centers = of_look.is_some() && self.samples > 1 && self.occlusion.is_none() && sky.is_none();
        *sky = rays.map(|rays| Sky { rays, at_centers, ..sky.unwrap_or_default() });
        if let (Some(reach), Some(sky)) = (self.reach, sky) {
            sky.reach = reach;
        }
        Ok(())
    }

    /// The sky of the buffer `occlusion` in a scene without one.
    #[must_use]
    pub fn buffer_sky(&self) -> Sky {
        let usual = Sky::default();
        Sky { reach: self.reach.unwrap_or(usual.reach), ..usual }
    }

    /// Whether it has a reach, but neither the scene, once it is applied, nor the buffers have a sky.
    #[must_use]
    pub fn lacks_sky(&self, scene: &Scene, aovs: &[Aov]) -> bool {
        self.reach.is_some() && scene.lighting.sky.is_none() && !aovs.contains(&Aov::Occlusion)
    }

    /// The bounces, where they change nothing of a scene although they are more than 0.
    #[must_use]
    pub fn idle_bounces(&self, scene: &Scene) -> Option<u32> {
        self.bounces.filter(|bounces| *bounces > 0 && !bounces_at_all(scene))
    }
}

/// Whether some material reflects or refracts light like a mirror or glass.
fn bounces_at_all(scene: &Scene) -> bool {
    scene.spheres.materials.as_ref().is_some_and(Materials::bounce)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Camera;
    use crate::scene::{ImagePlane, Skipped, Spheres};

    fn scene(sky: Option<Sky>) -> Scene {
        Scene {
            camera: Camera::CANONICAL,
            image: ImagePlane::default(),
            spheres: Spheres::default(),
            skipped: Skipped::default(),
            lighting: Lighting { sky, ..Lighting::default() },
        }
    }

    /// The sky of a scene file is what its author chose; options say more than looks.
    #[test]
    fn the_sky_is_the_option_s_then_the_scene_s_then_the_look_s() {
        let own = Some(Sky { rays: 32, reach: 7.0, at_centers: false });
        let soft = AddedLight { look: Look::Soft, samples: 4, ..AddedLight::default() };
        for (light, sky, expected) in [
            (AddedLight::default(), None, None),
            (AddedLight::default(), own, Some((32, 7.0, false))),
            (soft.clone(), None, Some((4, f64::INFINITY, true))),
            (AddedLight { samples: 1, ..soft.clone() }, None, Some((16, f64::INFINITY, false))),
            (soft.clone(), own, Some((32, 7.0, false))),
            (AddedLight { occlusion: Some(None), ..soft.clone() }, None, Some((16, f64::INFINITY, false))),
            (AddedLight { occlusion: Some(None), ..soft.clone() }, own, Some((32, 7.0, false))),
            (AddedLight { occlusion: Some(Some(9)), reach: Some(2.0), ..soft.clone() }, own, Some((9, 2.0, false))),
            (AddedLight { reach: Some(2.0), ..soft.clone() }, None, Some((4, 2.0, true))),
        ] {
            let mut scene = scene(sky);
            light.apply(&mut scene).expect("a camera");
            let found = scene.lighting.sky.map(|sky| (sky.rays, sky.reach, sky.at_centers));
            assert_eq!(found, expected, "{light:?} on {sky:?}");
            assert_eq!(scene.lighting.lights.len(), usize::from(light.look == Look::Soft), "{light:?}");
        }
    }

    #[test]
    fn a_reach_needs_a_sky_and_bounces_a_material() {
        let light = AddedLight { reach: Some(2.0), bounces: Some(3), ..AddedLight::default() };
        let mut bare = scene(None);
        light.apply(&mut bare).expect("a camera");
        assert!(light.lacks_sky(&bare, &[Aov::Color]) && !light.lacks_sky(&bare, &[Aov::Occlusion]));
        assert_eq!((light.buffer_sky().reach, bare.lighting.bounces, light.idle_bounces(&bare)), (2.0, None, Some(3)));
        assert!(!light.lacks_sky(&scene(Some(Sky::default())), &[]));
    }
}
