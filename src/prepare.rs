//! The setup of one frame: the view, and the spheres binned into tiles.

use crate::certify::TERMS;
use crate::certify::stage::Stage;
use crate::error::Result;
use crate::listed::{Asked, Listed};
use crate::memory::Pool;
use crate::plan::Plan;
use crate::predict::Prediction;
use crate::raster::Raster;
use crate::report::Stages;
use crate::scene::Scene;
use crate::settings::{Accuracy, Search, Settings};
use crate::view::View;

/// A plan with the data that it needs.
pub(crate) struct Prepared {
    /// The plan, without tiles where the lens does not allow them.
    pub(crate) plan: Plan,
    pub(crate) view: View,
    /// The scene binned into tiles; `None` where every ray tests all spheres, and where every pixel is decided exactly.
    pub(crate) stage: Option<Stage>,
}

impl Prepared {
    /// For the rays of `raster` in one frame of `scene`.
    ///
    /// # Errors
    /// Those of [`View::new`] and of [`Stage::new`].
    pub(crate) fn new(
        plan: Plan,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        pool: &Pool,
        stages: &mut Stages,
    ) -> Result<Self> {
        let view = stages.time("view", || View::for_rays(scene, raster, plan.kernel.records()))?;
        if plan.accuracy != Accuracy::Certified && !plan.kernel.tiles {
            return Ok(Self { plan, view, stage: None });
        }
        // A form's tiles are tiles; one list for the whole image, in its order, is a certified kernel's search alone.
        let level = if plan.kernel.certify { plan.search.level() } else { Search::Tiles.level() };
        let tolerance = settings.promise().relative();
        let stage = stages.time("stage", || Stage::new(scene, &view, tolerance, &TERMS, level, pool))?;
        if stage.is_none() && plan.kernel.tiles {
            let plan = plan.without_tiles();
            let view = stages.time("view", || View::for_rays(scene, raster, plan.kernel.records()))?;
            return Ok(Self { plan, view, stage });
        }
        Ok(Self { plan, view, stage })
    }

    /// Per-tile candidate lists; `None` where every ray tests all spheres.
    pub(crate) fn asked<'a>(&'a self, scene: &'a Scene, pool: &'a Pool) -> Option<Asked<'a>> {
        let (stage, kernel) = (self.stage.as_ref()?, &self.plan.kernel);
        let listed = || Listed::new(&self.view, &scene.spheres, stage, kernel.is_wide(), pool);
        Some(if kernel.certify { Asked::Certified(stage) } else { Asked::Form(listed()) })
    }

    /// Whether a kernel or its twin runs: not for exact answers, nor where f32 cannot bound the lens.
    pub(crate) fn is_traced(&self) -> bool {
        self.plan.accuracy == Accuracy::Fast || self.stage.is_some()
    }

    /// What rounding can do at worst; `None` where answers are certified.
    pub(crate) fn predicted(&self, scene: &Scene) -> Option<Prediction> {
        let of_view = || Prediction::of_view(&self.view, scene, self.plan.kernel.method);
        (self.plan.accuracy == Accuracy::Fast).then(|| self.plan.predicted.or_else(of_view)).flatten()
    }

    /// What is to be careful about, as far as it is known before a ray is traced.
    pub(crate) fn warnings(&self, scene: &Scene, settings: &Settings, predicted: Option<Prediction>) -> Vec<String> {
        let plan = &self.plan;
        let mut warnings = scene.skipped.warnings();
        warnings.extend(predicted.and_then(|predicted| predicted.warning(plan.kernel.method)));
        if scene.spheres.is_empty() {
            warnings.push("the scene has 0 spheres: the picture is background".into());
        }
        if settings.search == Search::Tiles && plan.search == Search::All {
            warnings.push(plan.search_reason.into());
        }
        warnings
    }

    /// Whether some spheres of a certified frame are not wholly in front of the eye plane.
    pub(crate) fn has_nears(&self) -> bool {
        self.certified().is_some_and(|stage| !stage.nears.is_empty())
    }

    /// The stage of a certified frame.
    pub(crate) fn certified(&self) -> Option<&Stage> {
        self.stage.as_ref().filter(|_| self.plan.kernel.certify)
    }
}
