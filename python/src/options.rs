//! The settings of a rendering from keywords, which have the names and values of the command's options.

use crate::scene::Scene;
use halfline::error::{Error, Result};
use halfline::intersect::Method;
use halfline::scene::{MOST_BOUNCES, MOST_RAYS};
use halfline::settings::{Accuracy, Backend, Search, Settings, Tolerance};
use halfline::window::Window;
use halfline::{Aov, Light, LightSource, Lighting, Shade, Sky};
use pyo3::prelude::*;

/// How answers are computed.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Accurate {
    accuracy: String,
    method: Option<String>,
    search: String,
    tolerance: Option<f64>,
}

impl Accurate {
    /// The settings of these keywords.
    pub(crate) fn settings(&self) -> Result<Settings> {
        Ok(Settings {
            accuracy: self.accuracy.parse::<Accuracy>()?,
            method: self.method.as_deref().map(str::parse::<Method>).transpose()?,
            search: self.search.parse::<Search>()?,
            tolerance: self.tolerance.map(Tolerance::new).transpose()?,
            ..Settings::default()
        })
    }
}

/// What a picture looks like, and which part of it is rendered.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Picture {
    aovs: Vec<String>,
    size: Option<(u32, u32)>,
    samples: u32,
    seed: u32,
    shade: Option<String>,
    look: String,
    silhouette: bool,
    depth_cue: bool,
    crop: Option<[u32; 4]>,
    background: Option<[f32; 3]>,
    sun: Vec<[f64; 3]>,
    shadows: bool,
    occlusion: Option<u32>,
    reach: Option<f64>,
    bounces: Option<u32>,
}

/// Rays to the sky in the look `soft` with several samples, as in the command.
const SOFT_RAYS: u32 = 4;

impl Picture {
    /// The settings with those of the picture.
    pub(crate) fn settings(&self, accurate: Settings, backend: Backend) -> Result<Settings> {
        let aovs = self.aovs.iter().map(|name| name.parse::<Aov>()).collect::<Result<Vec<_>>>()?;
        if !["plain", "soft", "figure"].contains(&self.look.as_str()) {
            let problem = format!("there is no look '{}'", self.look);
            return Err(Error::settings(problem, "choose from plain, soft, figure"));
        }
        let figure = self.look == "figure";
        let shade = self.shade.as_deref().or(figure.then_some("flat"));
        let crop = self.crop.map(|[x0, y0, x1, y1]| Window { x0, y0, x1, y1 });
        Ok(Settings {
            backend,
            aovs,
            samples: self.samples,
            seed: self.seed,
            shade: shade.map(str::parse::<Shade>).transpose()?.unwrap_or_default(),
            silhouette: self.silhouette || self.look != "plain",
            depth_cue: self.depth_cue || figure,
            sky: Sky { reach: self.reach.unwrap_or(f64::INFINITY), ..Sky::default() },
            window: crop,
            ..accurate
        })
    }

    /// The scene with this camera, size, background and light.
    pub(crate) fn scene(&self, scene: &Scene, camera: Option<&crate::camera::Camera>) -> Result<halfline::Scene> {
        let mut exact = scene.exact(camera, self.size, self.background)?;
        self.light(&mut exact)?;
        Ok(exact)
    }

    fn light(&self, scene: &mut halfline::Scene) -> Result<()> {
        let range = |name: &str, value: Option<u32>, least: u32, most: u32| match value {
            Some(value) if !(least..=most).contains(&value) => {
                let mend = format!("give a whole number from {least} to {most}");
                Err(Error::settings(format!("{name} is {value}"), mend))
            }
            _ => Ok(()),
        };
        range("occlusion", self.occlusion, 0, MOST_RAYS)?;
        range("bounces", self.bounces, 0, MOST_BOUNCES)?;
        let soft = self.look == "soft";
        let Lighting { lights, shadows, sky, bounces } = &mut scene.lighting;
        lights.extend(self.sun.iter().map(|sun| Light::white(LightSource::Direction((*sun).into()))));
        if lights.is_empty() && (self.shadows || soft) {
            lights.push(Light::above_left(&scene.camera)?);
        }
        *shadows |= self.shadows;
        *bounces = self.bounces.or(*bounces);
        let at_centers = soft && self.samples > 1 && self.occlusion.is_none() && sky.is_none();
        let soft_rays = if self.samples > 1 { SOFT_RAYS } else { Sky::default().rays };
        // 0 stands for the scene's number.
        let own = || sky.unwrap_or_default().rays;
        let asked = self.occlusion.map(|rays| if rays == 0 { own() } else { rays });
        let rays = asked.or(soft.then_some(soft_rays)).or(sky.map(|sky| sky.rays));
        *sky = rays.map(|rays| Sky { rays, at_centers, ..sky.unwrap_or_default() });
        match (self.reach, sky) {
            (Some(reach), Some(sky)) => sky.reach = reach,
            (Some(_), None) if !self.aovs.iter().any(|name| name == "occlusion") => {
                let mend = "add occlusion=True or the buffer occlusion, or remove reach";
                return Err(Error::settings("reach applies to a sky, and there is none", mend));
            }
            _ => {}
        }
        Ok(())
    }
}
