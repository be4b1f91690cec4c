//! The stage of lights and sky: after the nearest hits, before the buffers are assembled.

use super::place::Executor;
use super::plan::lights::{bounces, light_points};
use super::renderer::Renderer;
use crate::answers::lit::{Lit, OpenSky, Traced};
use crate::cpu::light::{LitScene, Wanted};
use crate::error::Result;
use crate::exact::Judge;
use crate::gpu::resident::sky::{SkyRays, SkyTraced};
use crate::memory::Pool;
use crate::progress::Step;
use crate::scene::{Gradient, Light, LightSource, Scene, Sky, SkyLight};
use crate::search::tree::Tree;
use crate::search::tree::device_rays::DirectionRecord;
use crate::settings::{Accuracy, Settings};
use crate::view::backdrop::Backdrop;
use crate::view::directions::{DiscPoints, SkyDirections};
use crate::view::{View, ViewRecord};
use std::sync::Arc;

/// The pixels from whose hits rays leave.
#[derive(Clone, Copy)]
pub(super) struct Pixels<'a> {
    /// Their spheres.
    pub(super) ids: &'a [u32],
    /// Those of every second pixel only, as on a chessboard.
    pub(super) chessboard: bool,
}

impl<'a> Pixels<'a> {
    pub(super) fn all(ids: &'a [u32]) -> Self {
        Self { ids, chessboard: false }
    }
}

/// Rays of each pixel toward the sky and toward lights.
struct SkyCount {
    rays: usize,
    lights: usize,
}

/// What the lights of one scene need, for the pixels' centres and for all samples.
pub(super) struct LightSetup {
    /// `None` without spheres.
    tree: Option<Arc<Tree>>,
    accuracy: Accuracy,
}

impl LightSetup {
    /// Decides what f64 leaves unsure, where the answers are certified. It has no spheres: those of a question come with
    /// it.
    fn judge(&self, scene: &Scene, view: &View) -> Result<Option<Judge>> {
        let certified = matches!(self.accuracy, Accuracy::Certified | Accuracy::Exact);
        certified.then(|| view.judge(&scene.bare())).transpose()
    }
}

/// Where a ray toward the sky ends, in the tree's unit over the length of its direction: at most, and at least.
fn limits(tree: &Tree, reach: f64) -> [f32; 2] {
    let limit = tree.placement.radius(reach) / DirectionRecord::UNIT;
    match limit < f64::from(f32::MAX) {
        true => [(limit as f32).next_down(), (limit as f32).next_up()],
        false => [f32::MAX.next_down(), f32::MAX],
    }
}

impl Renderer {
    pub(super) fn light_setup(&mut self, scene: &Scene, accuracy: Accuracy) -> LightSetup {
        LightSetup { tree: self.order.tree(&scene.spheres, self.frames), accuracy }
    }

    /// What the device that rendered this view finds of rays from its hits toward the sky, `sky` of them, and toward lights,
    /// where none of them has a size and they cast shadows.
    fn trace_from_hits(
        &mut self,
        tree: &Tree,
        (scene, settings, view): (&Scene, &Settings, &View),
        (sky, reach): (&SkyDirections, f64),
        (lights, chessboard): (bool, bool),
    ) -> Result<Option<(SkyCount, Vec<u32>)>> {
        let Executor::Gpu(gpu) = &mut self.place else { return Ok(None) };
        let without_size = |light: &Light| match light.source {
            LightSource::Direction(direction) => Some(DirectionRecord::new(direction.to_array())),
            LightSource::Point(place) => DirectionRecord::place(tree, place.to_array()),
            LightSource::Sphere(_) | LightSource::Ball { .. } => None,
        };
        let all: Option<Vec<DirectionRecord>> = scene.lighting.lights.iter().map(without_size).collect();
        let all = all.filter(|_| lights).unwrap_or_default();
        let count = SkyCount { rays: sky.len(), lights: all.len() };
        if count.rays + count.lights == 0 {
            return Ok(None);
        }
        let turned = sky.turned().iter().map(DirectionRecord::of_unit);
        let directions: Vec<DirectionRecord> = turned.chain(all).collect();
        let asked = SkyRays {
            tree,
            view,
            directions: &directions,
            rays: count.rays as u32,
            lights: count.lights as u32,
            seed: settings.seed,
            chessboard,
            limit: limits(tree, reach),
        };
        let pixels = view.record.pixels() as u64;
        let doing = self.watch.begin(Step::Light, pixels);
        match gpu.trace_sky(&asked, &|done| doing.reached(done))? {
            SkyTraced::NoHits => Ok(None),
            SkyTraced::Words(words) => {
                doing.end()?;
                Ok(Some((count, words)))
            }
            SkyTraced::Refused(reason) => {
                let left = format!("the host traced the rays to lights and sky of this frame: {reason}");
                self.left_to_host.get_or_insert(left);
                Ok(None)
            }
        }
    }

    /// What lights and `sky` give to the pixels that show these spheres.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`], and [`crate::Error::Limits`] where memory is short.
    pub(super) fn light(
        &mut self,
        setup: &LightSetup,
        (scene, settings, view): (&Scene, &Settings, &View),
        (wanted, sky): (Wanted, Option<Sky>),
        (pixels, open): (Pixels<'_>, Option<OpenSky<'_>>),
        pool: &Pool,
    ) -> Result<Lit> {
        let Pixels { ids, chessboard } = pixels;
        let mut lit = Lit::default();
        let lights = &scene.lighting.lights;
        let some = |wanted: bool, each: usize| if wanted { each * ids.len() } else { 0 };
        lit.color = pool.values(some(wanted.color, 3))?;
        lit.shadow = pool.values(some(wanted.shadow, lights.len()))?;
        lit.occlusion = pool.values(some(wanted.occlusion, 1))?;
        lit.sky = pool.values(some(wanted.sky, 3))?;
        let sized = lights.iter().any(|light| light.source.has_size());
        let ViewRecord { strata, sample, .. } = view.record;
        let directions = SkyDirections::new(sky.map_or(0, |sky| sky.rays), strata, sample);
        let scattered = SkyDirections::one(strata, sample);
        let samples = strata * strata;
        let disc = DiscPoints::new(if sized { light_points(samples) } else { 0 }, samples);
        let backdrop = Backdrop::new(scene, view, true);
        let Some(tree) = &setup.tree else {
            return Ok(lit.of_nothing(|pixel| backdrop.at(pixel)));
        };
        let judge = setup.judge(scene, view)?;
        let casts_shadows = wanted.shadow || wanted.color && scene.lighting.shadows;
        let found = match setup.accuracy {
            Accuracy::Certified => {
                let sky = sky.filter(|_| open.is_none());
                let (none, reach) = (SkyDirections::none(), sky.map_or(f64::INFINITY, |sky| sky.reach));
                let directions = if sky.is_some() { &directions } else { &none };
                let of = (scene, settings, view);
                self.trace_from_hits(tree, of, (directions, reach), (casts_shadows, chessboard))?
            }
            _ => None,
        };
        let traced = found.as_ref().map(|(count, words)| Traced { words, rays: count.rays, lights: count.lights });
        if let Some(traced) = &traced {
            self.light_on_device.add(ids, traced);
        }
        let lighting = LitScene {
            scene,
            view,
            tree,
            wanted,
            judge: judge.as_ref(),
            exact: setup.accuracy == Accuracy::Exact,
            sky,
            colors: Gradient::of(scene).filter(|_| wanted.color || wanted.sky).map(SkyLight::new),
            backdrop,
            directions: &directions,
            scattered: &scattered,
            disc: &disc,
            seed: settings.seed,
            open,
            traced,
            bounces: bounces(scene),
        };
        let doing = self.watch.begin(Step::Light, ids.len() as u64);
        lighting.fill(ids, &mut lit, &|pixels| doing.next(pixels));
        doing.end()?;
        Ok(lit)
    }
}
