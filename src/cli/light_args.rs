//! Lights, sky and lines of the picture as options, and the looks that stand for several of them.

use super::read_args::numbers;
use clap::{Args, ValueEnum};
use glam::DVec3;
use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::scene::{Light, LightSource, Lighting, MOST_BOUNCES, MOST_RAYS, Materials, Scene, Sky, Spheres};
use halfline::settings::Settings;
use halfline::shade::Shade;
use std::fmt;

/// The options for light.
#[derive(Debug, Args)]
#[command(next_help_heading = "Light")]
pub(super) struct LightArgs {
    /// Look of the picture, to which other options add: plain (nothing), soft (--occlusion, --silhouette, and a light
    /// from above left if the scene has none), figure (--shade flat --silhouette --depth-cue) [default: plain; for a
    /// picture of a particle file without --aov, --accuracy, --method, --samples and --shade: soft with 4 samples].
    #[arg(long, value_name = "L", value_enum, hide_possible_values = true)]
    look: Option<Look>,
    /// Ambient occlusion: a white sky, part of which other spheres hide; N rays for each point [default: the scene
    /// file's, else 16].
    #[arg(long, value_name = "N", value_parser = rays, num_args = 0..=1)]
    occlusion: Option<Option<u32>>,
    /// Spheres farther than this from a point, in scene units, hide nothing of the sky [default: the scene file's, else
    /// no limit].
    #[arg(long, value_name = "R", value_parser = reach, allow_negative_numbers = true)]
    reach: Option<f64>,
    /// Adds a white light infinitely far in this direction; may be repeated.
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    sun: Vec<DVec3>,
    /// Lights cast shadows, as those of scene files always do; without any light, adds one from above left of the camera.
    #[arg(long)]
    shadows: bool,
    /// The most bounces of a ray at mirrors and in glass, up to 64; 0 switches them off [default: 6].
    #[arg(long, value_name = "N", value_parser = bounces)]
    bounces: Option<u32>,
    /// Draws dark lines where the depth jumps.
    #[arg(long)]
    silhouette: bool,
    /// Fades colours to the background with depth.
    #[arg(long)]
    depth_cue: bool,
}

/// A name for several options.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Look {
    /// Nothing.
    Plain,
    /// For particles: depth is visible without any setting.
    Soft,
    /// For print: flat colours and lines.
    Figure,
}

/// What decides about the default look.
#[derive(Debug, Clone, Copy)]
pub(super) struct LookRequest {
    /// Whether the file has particles and no camera.
    pub(super) is_particles: bool,
    /// Whether a picture is written and no option asks for anything else: buffers, accuracy, method, samples, shading.
    pub(super) is_plain_picture: bool,
    /// The samples and the shading that options ask for.
    pub(super) samples: Option<u32>,
    pub(super) shade: Option<Shade>,
}

/// Samples of the default look.
const SAMPLES: u32 = 4;

/// Rays to the sky for each pixel in the look `soft`. They leave from the pixel's centre, and each sample takes the mean of the
/// pixels around it: about as little noise as from 8 times 4 rays, in the time of these.
const SOFT_RAYS: u32 = 4;

/// The look of one picture: what its options stand for.
#[derive(Debug, Clone, Copy)]
pub(super) struct PictureLook {
    look: Look,
    /// Whether no option asks for this look.
    is_default: bool,
    shade: Option<Shade>,
    samples: u32,
    silhouette: bool,
    depth_cue: bool,
    /// The sky of the buffer `occlusion` in a scene without one.
    buffer_sky: Sky,
}

impl LightArgs {
    /// The look of a picture; without buffers that depend on the scene.
    fn look(&self, request: LookRequest) -> PictureLook {
        let is_default = self.look.is_none();
        let soft = is_default && request.is_particles && request.is_plain_picture;
        let look = self.look.unwrap_or(if soft { Look::Soft } else { Look::Plain });
        PictureLook {
            look,
            is_default,
            shade: request.shade.or((look == Look::Figure).then_some(Shade::Flat)),
            samples: request.samples.unwrap_or(if soft { SAMPLES } else { 1 }),
            silhouette: self.silhouette || look != Look::Plain,
            depth_cue: self.depth_cue || look == Look::Figure,
            buffer_sky: Sky::default(),
        }
    }

    /// Applies the options to the scene, whose camera is final.
    ///
    /// # Errors
    /// [`Error::Settings`] for a reach without a sky; the camera's.
    pub(super) fn apply(&self, scene: &mut Scene, aovs: &[Aov], request: LookRequest) -> Result<PictureLook> {
        let mut picture = self.look(request);
        self.apply_bounces(scene);
        let Lighting { lights, shadows, sky, .. } = &mut scene.lighting;
        lights.extend(self.sun.iter().map(|sun| Light::white(LightSource::Direction(*sun))));
        if lights.is_empty() && (self.shadows || picture.look == Look::Soft) {
            lights.push(Light::above_left(&scene.camera)?);
        }
        *shadows |= self.shadows;
        let rays = match (self.occlusion, &sky) {
            (Some(Some(rays)), _) => Some(rays),
            (Some(None), Some(sky)) => Some(sky.rays),
            (Some(None), None) => Some(Sky::default().rays),
            (None, None) if picture.look == Look::Soft => Some(picture.soft_rays()),
            (None, sky) => sky.map(|sky| sky.rays),
        };
        let at_centers = picture.look == Look::Soft && picture.samples > 1 && self.occlusion.is_none() && sky.is_none();
        *sky = rays.map(|rays| Sky { rays, at_centers, ..sky.unwrap_or_default() });
        match (self.reach, sky) {
            (None, _) => {}
            (Some(reach), Some(sky)) => sky.reach = reach,
            (Some(reach), None) if aovs.contains(&Aov::Occlusion) => picture.buffer_sky.reach = reach,
            (Some(_), None) => {
                let mend = "add --occlusion or --aov occlusion=FILE, or remove --reach";
                return Err(Error::settings("--reach applies to a sky, and there is none", mend));
            }
        }
        Ok(picture)
    }

    /// Sets the number of bounces where a material asks for any, and else warns.
    fn apply_bounces(&self, scene: &mut Scene) {
        let Some(bounces) = self.bounces else { return };
        if scene.spheres.materials.as_ref().is_some_and(Materials::bounce) {
            scene.lighting.bounces = Some(bounces);
        } else if bounces > 0 {
            let what = "no sphere has a material that reflects or refracts light like a mirror or glass";
            scene.skipped.assumed.push(format!("--bounces {bounces} changes nothing: {what}"));
        }
    }
}

impl PictureLook {
    /// The settings with this look.
    pub(super) fn settings(&self, settings: &Settings) -> Settings {
        Settings {
            shade: self.shade.unwrap_or(settings.shade),
            samples: self.samples,
            silhouette: self.silhouette,
            depth_cue: self.depth_cue,
            sky: self.buffer_sky,
            ..settings.clone()
        }
    }

    /// Rays for each pixel in the look `soft`: as many as usual without samples, whose noise would average out.
    fn soft_rays(&self) -> u32 {
        if self.samples > 1 { SOFT_RAYS } else { Sky::default().rays }
    }

    /// The options that the look stands for, in a sentence; `None` for the plain one.
    pub(super) fn words(&self) -> Option<String> {
        let stands_for = match self.look {
            Look::Plain => return None,
            Look::Soft => {
                let samples = if self.is_default { format!(" --samples {}", self.samples) } else { String::new() };
                let light = "a light from above left without shadows if the scene has no light";
                let at = if self.samples > 1 { " at every second pixel's centre" } else { "" };
                format!("--occlusion {}{at}, --silhouette{samples}, and {light}", self.soft_rays())
            }
            Look::Figure => "--shade flat --silhouette --depth-cue".to_owned(),
        };
        let default = if self.is_default { " (the default for particles; see --look plain)" } else { "" };
        Some(format!("look {self}{default}: {stands_for}"))
    }
}

impl fmt::Display for PictureLook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.look {
            Look::Plain => "plain",
            Look::Soft => "soft",
            Look::Figure => "figure",
        })
    }
}

/// The spheres that are lights. Clip planes may remove them and change the ids of those that stay.
pub(super) struct SphereLights(Vec<SphereLight>);

struct SphereLight {
    /// The index of the light.
    light: usize,
    center: [f64; 3],
    radius: f64,
    /// The number of equal spheres before it: a plane removes all of them or none.
    before: usize,
}

impl SphereLights {
    /// The lights of a scene that are spheres.
    pub(super) fn of(scene: &Scene) -> Self {
        let Spheres { centers, radii, .. } = &scene.spheres;
        let sphere = |(light, found): (usize, &Light)| {
            let LightSource::Sphere(id) = found.source else { return None };
            let (center, radius) = (*centers.get(id as usize)?, *radii.get(id as usize)?);
            let before = equal(&scene.spheres, center, radius).take_while(|other| *other < id as usize).count();
            Some(SphereLight { light, center, radius, before })
        };
        Self(scene.lighting.lights.iter().enumerate().filter_map(sphere).collect())
    }

    /// Gives the lights their new ids. A light whose sphere was removed shines from the same place.
    pub(super) fn follow(&self, scene: &mut Scene) {
        for SphereLight { light, center, radius, before } in &self.0 {
            let id = equal(&scene.spheres, *center, *radius).nth(*before).and_then(|id| u32::try_from(id).ok());
            let gone = LightSource::Ball { center: DVec3::from_array(*center), radius: *radius };
            scene.lighting.lights[*light].source = id.map_or(gone, LightSource::Sphere);
        }
    }
}

/// The spheres with this centre and radius.
fn equal(spheres: &Spheres, center: [f64; 3], radius: f64) -> impl Iterator<Item = usize> {
    let all = spheres.centers.iter().zip(&spheres.radii).enumerate();
    all.filter(move |(_, (c, r))| **c == center && **r == radius).map(|(id, _)| id)
}

fn direction(text: &str) -> Result<DVec3, String> {
    let vector = numbers(text).map(DVec3::from_array).filter(|sun| *sun != DVec3::ZERO);
    vector.ok_or_else(|| "expected three finite numbers, not all 0, that point toward the light, such as -1,2,1".into())
}

fn rays(text: &str) -> Result<u32, String> {
    let rays = text.parse().ok().filter(|rays| (1..=MOST_RAYS).contains(rays));
    rays.ok_or_else(|| format!("expected a whole number between 1 and {MOST_RAYS}"))
}

fn bounces(text: &str) -> Result<u32, String> {
    let bounces = text.parse().ok().filter(|bounces| (0..=MOST_BOUNCES).contains(bounces));
    bounces.ok_or_else(|| format!("expected a whole number between 0 and {MOST_BOUNCES}"))
}

fn reach(text: &str) -> Result<f64, String> {
    let reach = text.parse().ok().filter(|reach: &f64| *reach > 0.0 && reach.is_finite());
    reach.ok_or_else(|| "expected a positive length, in the scene's unit".into())
}
