//! The stage of lights and sky: after the nearest hits, before the buffers are assembled.

use super::plan::lights::{bounces, light_points};
use super::renderer::Renderer;
use crate::answers::lit::{Lit, OpenSky};
use crate::cpu::light::{LitScene, Wanted};
use crate::error::Result;
use crate::exact::Judge;
use crate::memory::Pool;
use crate::progress::Step;
use crate::scene::{Gradient, Scene, Sky, SkyLight};
use crate::search::tree::Tree;
use crate::settings::{Accuracy, Settings};
use crate::view::backdrop::Backdrop;
use crate::view::directions::{DiscPoints, SkyDirections};
use crate::view::{View, ViewRecord};

/// What the lights of one scene need, for the pixels' centres and for all samples.
pub(super) struct LightSetup {
    /// `None` without spheres.
    tree: Option<Tree>,
    accuracy: Accuracy,
}

impl LightSetup {
    pub(super) fn new(scene: &Scene, accuracy: Accuracy) -> Self {
        Self { tree: Tree::new(&scene.spheres.centers, &scene.spheres.radii), accuracy }
    }

    /// Decides what f64 leaves unsure, where the answers are certified. It has no spheres: those of a question come with
    /// it.
    fn judge(&self, scene: &Scene, view: &View) -> Result<Option<Judge>> {
        let certified = matches!(self.accuracy, Accuracy::Certified | Accuracy::Exact);
        certified.then(|| view.judge(&scene.bare())).transpose()
    }
}

impl Renderer {
    /// What lights and `sky` give to the pixels that show these spheres.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`], and [`crate::Error::Limits`] where memory is short.
    pub(super) fn light(
        &self,
        setup: &LightSetup,
        (scene, settings, view): (&Scene, &Settings, &View),
        (wanted, sky): (Wanted, Option<Sky>),
        (ids, open): (&[u32], Option<OpenSky<'_>>),
        pool: &Pool,
    ) -> Result<Lit> {
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
            bounces: bounces(scene),
        };
        let doing = self.watch.begin(Step::Light, ids.len() as u64);
        lighting.fill(ids, &mut lit, &|pixels| doing.next(pixels));
        doing.end()?;
        Ok(lit)
    }
}
