//! The looks of a picture, and the light that options add to a scene: one rule for the command and the Python package.

use super::Settings;
use crate::frame::Aov;
use crate::scene::{Light, LightSource, Lighting, Materials, Scene, Sky};
use crate::shade::Shade;
use glam::DVec3;
use halfline_ground::error::{Error, Result, named};
use halfline_ground::quote::setting::{AOV, BOUNCES, OCCLUSION, REACH};

/// Samples per pixel of the looks `soft` and `figure`.
const SOFT_SAMPLES: u32 = 4;
const FIGURE_SAMPLES: u32 = 16;

/// A preset: one name for lines, sky, light and samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Look {
    /// No preset.
    #[default]
    Plain,
    /// For particles: a sky, lines, and a light from above left of the camera where the scene has none.
    Soft,
    /// For print: a sky alone, lines, and many samples.
    Figure,
}

named! { Look, "look", Plain "plain" Soft "soft" Figure "figure" }

impl Look {
    /// Whether dark lines are drawn where the depth jumps.
    #[must_use]
    pub fn has_silhouette(self) -> bool {
        self != Self::Plain
    }

    /// The sky that it stands for, if any.
    #[must_use]
    pub fn sky(self) -> Option<Sky> {
        (self != Self::Plain).then_some(Sky::AT_CENTERS)
    }

    /// Samples per pixel that it stands for.
    #[must_use]
    pub fn samples(self) -> u32 {
        match self {
            Self::Plain => 1,
            Self::Soft => SOFT_SAMPLES,
            Self::Figure => FIGURE_SAMPLES,
        }
    }
}

/// The look and the samples that a file asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FileLook {
    /// The file holds particles, not a scene.
    pub is_particles: bool,
    /// The look that a scene file asks for.
    pub look: Option<Look>,
    /// The samples per pixel that a scene file asks for.
    pub samples: Option<u32>,
}

/// The look and the samples of one picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ChosenLook {
    /// The look.
    pub look: Look,
    /// Samples per pixel.
    pub samples: u32,
    /// Whether neither an option nor the file asks for this look: it is the look of particles.
    pub is_default: bool,
}

impl FileLook {
    /// The look of a file of particles.
    pub const PARTICLES: Self = Self { is_particles: true, look: None, samples: None };

    /// The look of a picture for which options ask for this look, these samples and this shading: the options' look, then
    /// the file's. Particles have the look `soft` unless a shading is given. Without a picture nothing of a look is
    /// computed.
    #[must_use]
    pub fn choose(
        self,
        has_picture: bool,
        look: Option<Look>,
        samples: Option<u32>,
        shade: Option<Shade>,
    ) -> ChosenLook {
        let requested = look.or(self.look);
        let is_default = requested.is_none() && self.is_particles && shade.is_none() && has_picture;
        let look = requested.filter(|_| has_picture).unwrap_or(if is_default { Look::Soft } else { Look::Plain });
        let samples = samples.or(self.samples).unwrap_or(look.samples());
        ChosenLook { look, samples, is_default }
    }
}

/// The lights, sky and bounces that options add to a scene.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AddedLight {
    /// The look of the picture.
    pub look: Look,
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
    /// Adds it to a scene, whose camera is final, for frames with these buffers. Bounces are set where a material asks for any. Returns
    /// warnings about what changes nothing.
    ///
    /// The lights and the sky that are added share one white light among them, so that a white sphere is at most white: half of it
    /// is an added sky's where there are lights. The lights and the sky of the scene are as bright as it says.
    ///
    /// # Errors
    /// [`Error::Settings`] for the buffer `shadow` where neither the scene nor an option has a light, since buffers do not depend on
    /// looks, and for a reach without a sky; errors of [`Light::above_left`].
    pub fn apply(&self, scene: &mut Scene, aovs: &[Aov]) -> Result<Vec<String>> {
        let has_light = !(scene.lighting.lights.is_empty() && self.suns.is_empty()) || self.shadows;
        if aovs.contains(&Aov::Shadow) && !has_light {
            return Err(Settings::no_light());
        }
        if let Some(bounces) = self.bounces.filter(|_| bounces_at_all(scene)) {
            scene.lighting.bounces = Some(bounces);
        }
        let Lighting { lights, shadows, sky, .. } = &mut scene.lighting;
        let own_lights = lights.len();
        lights.extend(self.suns.iter().map(|sun| Light::white(LightSource::Direction(*sun))));
        if lights.is_empty() && (self.shadows || self.look == Look::Soft) {
            lights.push(Light::above_left(&scene.camera)?);
        }
        *shadows |= self.shadows;
        // The sky of the scene comes before the sky of the look.
        let own = *sky;
        *sky = match self.occlusion {
            Some(Some(rays)) => Some(Sky { rays, at_centers: false, ..own.unwrap_or_default() }),
            Some(None) => own.or(Some(Sky::default())),
            None => own.or(self.look.sky()),
        };
        if let (Some(reach), Some(sky)) = (self.reach, sky.as_mut()) {
            sky.reach = reach;
        }
        let mut left = 1.0;
        if let (None, Some(sky), false) = (own, sky.as_mut(), lights.is_empty()) {
            sky.share = Sky::SHARE_WITH_LIGHTS;
            left -= Sky::SHARE_WITH_LIGHTS;
        }
        if own_lights == 0 {
            let each = left / lights.len() as f32;
            lights.iter_mut().for_each(|light| light.intensity = each);
        }
        if self.reach.is_some() && sky.is_none() && !aovs.contains(&Aov::Occlusion) {
            let mend = format!("add {OCCLUSION} or {AOV} occlusion, or remove {REACH}");
            return Err(Error::settings(format!("{REACH} applies to a sky, and there is none"), mend));
        }
        let idle = self.bounces.filter(|bounces| *bounces > 0 && !bounces_at_all(scene));
        let why = "no sphere has a material that reflects or refracts light like a mirror or glass";
        Ok(idle.map(|bounces| format!("{BOUNCES} {bounces} changes nothing: {why}")).into_iter().collect())
    }

    /// The sky of the buffer `occlusion` in a scene without one.
    #[must_use]
    pub fn buffer_sky(&self) -> Sky {
        let usual = Sky::default();
        Sky { reach: self.reach.unwrap_or(usual.reach), ..usual }
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
    use crate::scene::{ImagePlane, Spheres};

    fn scene(sky: Option<Sky>) -> Scene {
        Scene {
            camera: Camera::CANONICAL,
            image: ImagePlane::default(),
            spheres: Spheres::default(),
            lighting: Lighting { sky, ..Lighting::default() },
        }
    }

    /// The sky of a scene file is what its author chose; options say more than looks.
    #[test]
    fn the_sky_is_the_option_s_then_the_scene_s_then_the_look_s() {
        let own = Some(Sky { rays: 32, reach: 7.0, ..Sky::default() });
        let soft = AddedLight { look: Look::Soft, ..AddedLight::default() };
        for (light, sky, expected) in [
            (AddedLight::default(), None, None),
            (AddedLight::default(), own, Some((32, 7.0, false))),
            (soft.clone(), None, Some((3, f64::INFINITY, true))),
            (soft.clone(), own, Some((32, 7.0, false))),
            (AddedLight { occlusion: Some(None), ..soft.clone() }, None, Some((16, f64::INFINITY, false))),
            (AddedLight { occlusion: Some(None), ..soft.clone() }, own, Some((32, 7.0, false))),
            (AddedLight { occlusion: Some(Some(9)), reach: Some(2.0), ..soft.clone() }, own, Some((9, 2.0, false))),
            (AddedLight { reach: Some(2.0), ..soft.clone() }, None, Some((3, 2.0, true))),
        ] {
            let mut scene = scene(sky);
            light.apply(&mut scene, &[]).expect("a camera");
            let found = scene.lighting.sky.map(|sky| (sky.rays, sky.reach, sky.at_centers));
            assert_eq!(found, expected, "{light:?} on {sky:?}");
            assert_eq!(scene.lighting.lights.len(), usize::from(light.look == Look::Soft), "{light:?}");
        }
    }

    /// A white sphere that faces all of the added light under an open sky is white; the lights of a file are the author's.
    #[test]
    fn what_is_added_is_one_white_light_in_all() {
        let soft = AddedLight { look: Look::Soft, ..AddedLight::default() };
        let suns = |count: usize| AddedLight { suns: vec![DVec3::Z; count], ..AddedLight::default() };
        let with_sky = |light: AddedLight| AddedLight { occlusion: Some(None), ..light };
        let own = Light { intensity: 3.0, ..Light::white(LightSource::Point(DVec3::Y)) };
        for (light, lights, expected) in [
            (soft.clone(), vec![], vec![0.5]),
            (suns(1), vec![], vec![1.0]),
            (suns(2), vec![], vec![0.5; 2]),
            (with_sky(suns(1)), vec![], vec![0.5]),
            (with_sky(suns(4)), vec![], vec![0.125; 4]),
            (AddedLight { shadows: true, ..AddedLight::default() }, vec![], vec![1.0]),
            (soft, vec![own], vec![3.0]),
            (with_sky(suns(1)), vec![own], vec![3.0, 1.0]),
        ] {
            let mut scene = scene(None);
            scene.lighting.lights = lights;
            light.apply(&mut scene, &[]).expect("a camera");
            let found: Vec<f32> = scene.lighting.lights.iter().map(|light| light.intensity).collect();
            assert_eq!(found, expected, "{light:?}");
        }
    }

    /// The sky of a file lights as brightly as it is seen; an added sky shares one light with the lights.
    #[test]
    fn only_an_added_sky_gives_half_of_the_light_to_lights() {
        let soft = AddedLight { look: Look::Soft, ..AddedLight::default() };
        let open = AddedLight { occlusion: Some(Some(9)), ..AddedLight::default() };
        let sunny = AddedLight { suns: vec![DVec3::Z; 2], ..open.clone() };
        let file = Some(Sky { rays: 32, ..Sky::default() });
        for (light, own, share, lights) in [
            (&soft, None, 0.5, vec![0.5]),
            (&soft, file, 1.0, vec![1.0]),
            (&open, None, 1.0, vec![]),
            (&open, file, 1.0, vec![]),
            (&sunny, None, 0.5, vec![0.25; 2]),
            (&sunny, file, 1.0, vec![0.5; 2]),
        ] {
            let mut scene = scene(own);
            light.apply(&mut scene, &[]).expect("a camera");
            let found: Vec<f32> = scene.lighting.lights.iter().map(|light| light.intensity).collect();
            assert_eq!((scene.lighting.sky.expect("a sky").share, found), (share, lights), "{light:?} on {own:?}");
        }
        let mut with_light = scene(None);
        with_light.lighting.lights = vec![Light::white(LightSource::Point(DVec3::Y))];
        open.apply(&mut with_light, &[]).expect("a camera");
        assert_eq!(with_light.lighting.sky.expect("a sky").share, 0.5, "beside the lights of a file");
    }

    /// Samples and all other options leave the look of particles as it is.
    #[test]
    fn a_look_is_the_option_s_then_the_file_s_then_that_of_particles() {
        let particles = FileLook::PARTICLES;
        let file = FileLook { look: Some(Look::Soft), samples: Some(9), ..FileLook::default() };
        let flat = Some(Shade::Flat);
        for (from, has_picture, look, samples, shade, expected) in [
            (particles, true, None, None, None, (Look::Soft, 4, true)),
            (particles, true, None, Some(1), None, (Look::Soft, 1, true)),
            (particles, true, None, Some(16), None, (Look::Soft, 16, true)),
            (particles, true, Some(Look::Soft), None, None, (Look::Soft, 4, false)),
            (particles, true, Some(Look::Plain), None, None, (Look::Plain, 1, false)),
            (particles, true, None, None, flat, (Look::Plain, 1, false)),
            (particles, true, Some(Look::Soft), None, flat, (Look::Soft, 4, false)),
            (particles, false, None, None, None, (Look::Plain, 1, false)),
            (particles, false, Some(Look::Soft), None, None, (Look::Plain, 1, false)),
            (FileLook::default(), true, None, None, None, (Look::Plain, 1, false)),
            (FileLook::default(), true, Some(Look::Soft), None, None, (Look::Soft, 4, false)),
            (file, true, None, None, None, (Look::Soft, 9, false)),
            (file, true, Some(Look::Plain), Some(2), None, (Look::Plain, 2, false)),
        ] {
            let ChosenLook { look: found, samples: count, is_default } = from.choose(has_picture, look, samples, shade);
            assert_eq!((found, count, is_default), expected, "{from:?} {has_picture} {look:?} {samples:?} {shade:?}");
        }
    }

    #[test]
    fn a_reach_needs_a_sky_shadows_a_light_and_bounces_a_material() {
        let reach = AddedLight { reach: Some(2.0), bounces: Some(3), ..AddedLight::default() };
        reach.apply(&mut scene(None), &[Aov::Color]).expect_err("no sky");
        let mut bare = scene(None);
        let warnings = reach.apply(&mut bare, &[Aov::Occlusion]).expect("the sky of the buffer");
        assert!(matches!(&warnings[..], [one] if one.contains("3 changes nothing")), "{warnings:?}");
        assert_eq!((reach.buffer_sky().reach, bare.lighting.bounces), (2.0, None));
        reach.apply(&mut scene(Some(Sky::default())), &[]).expect("the sky of the scene");
        let none = AddedLight { bounces: Some(0), ..AddedLight::default() };
        assert_eq!(none.apply(&mut bare, &[]).expect("nothing to add"), [""; 0]);
        let soft = AddedLight { look: Look::Soft, ..AddedLight::default() };
        soft.apply(&mut bare, &[Aov::Shadow]).expect_err("the light of a look casts none");
        AddedLight { shadows: true, ..soft }.apply(&mut bare, &[Aov::Shadow]).expect("a light");
    }
}
