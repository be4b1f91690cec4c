//! The setup of one frame: the view, and the spheres binned into tiles.

use super::plan::Plan;
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::grouped::Grouped;
use crate::certify::placing::Placer;
use crate::error::Result;
use crate::frame::report::Timings;
use crate::intersect::predict::Prediction;
use crate::memory::Pool;
use crate::scene::Scene;
use crate::search::tile_candidates::{CandidateList, TileCandidates};
use crate::settings::{Accuracy, Search, Settings};
use crate::view::raster::Raster;
use crate::view::{Records, View, middle};

/// A plan with the data that it needs.
pub(crate) struct FrameSetup {
    /// The plan, without tiles where the camera does not allow them.
    pub(crate) plan: Plan,
    pub(crate) view: View,
    /// The scene binned into tiles; `None` where every ray tests all spheres or every pixel is decided exactly.
    pub(crate) binned: Option<BinnedScene>,
    /// The host's part in placing the spheres, where a device holds them: it bins them.
    pub(crate) placer: Option<Placer>,
}

impl FrameSetup {
    /// The setup where a device holds the spheres, whose sizes and distances have exponents within `sizes`. The plan comes back where
    /// the camera does not allow it.
    ///
    /// # Errors
    /// Those of [`View::new`] but for the spheres.
    pub(crate) fn resident(
        plan: Plan,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        sizes: [i32; 2],
    ) -> Result<std::result::Result<Self, Plan>> {
        let (unit, tolerance) = (middle(sizes), settings.promise().relative());
        let mut view = View::in_unit(scene, raster, unit)?;
        let mut placer = Placer::new(scene, &view, tolerance)?;
        if placer.as_ref().is_some_and(|placer| !placer.is_same_in_units(sizes[1] + 1 - unit)) {
            // What is projected depends on the unit: here it is that of the CPU path, which looks at every sphere.
            view = View::for_rays(scene, raster, Records::None)?;
            placer = Placer::new(scene, &view, tolerance)?;
        }
        Ok(match placer {
            Some(placer) => Ok(Self { plan, view, binned: None, placer: Some(placer) }),
            None => Err(plan),
        })
    }

    /// The setup for the rays of `raster` in one frame of `scene`, whose spheres may be known in groups.
    ///
    /// # Errors
    /// Those of [`View::new`] and of [`BinnedScene::new`].
    pub(crate) fn new(
        plan: Plan,
        (scene, groups): (&Scene, Option<Grouped<'_>>),
        settings: &Settings,
        raster: Raster,
        pool: &Pool,
        timings: &mut Timings,
    ) -> Result<Self> {
        let view = timings.time("view", || View::for_rays(scene, raster, plan.kernel.records()))?;
        if plan.accuracy != Accuracy::Certified && !plan.kernel.tiles {
            return Ok(Self { plan, view, binned: None, placer: None });
        }
        // An uncertified method always bins into tiles; a single list for the whole image exists for the certified
        // kernel alone.
        let level = if plan.kernel.certify { plan.search.level() } else { Search::Tiles.level() };
        let tolerance = settings.promise().relative();
        let binned = timings.time("stage", || {
            BinnedScene::new(&Binning { groups, level, ..Binning::of(scene, &view, tolerance, pool) })
        })?;
        if binned.is_none() && plan.kernel.tiles {
            let plan = plan.without_tiles();
            let view = timings.time("view", || View::for_rays(scene, raster, plan.kernel.records()))?;
            return Ok(Self { plan, view, binned, placer: None });
        }
        Ok(Self { plan, view, binned, placer: None })
    }

    /// Per-tile candidate lists; `None` where every ray tests all spheres.
    pub(crate) fn candidates<'a>(&'a self, scene: &'a Scene, pool: &'a Pool) -> Option<CandidateList<'a>> {
        let (binned, kernel) = (self.binned.as_ref()?, &self.plan.kernel);
        let tile_candidates = || TileCandidates::new(&self.view, &scene.spheres, binned, kernel.is_wide(), pool);
        Some(if kernel.certify {
            CandidateList::Certified(binned)
        } else {
            CandidateList::Uncertified(tile_candidates())
        })
    }

    /// Whether a kernel or its twin runs: not for exact answers, nor where f32 cannot bound the projection.
    pub(crate) fn is_traced(&self) -> bool {
        self.plan.accuracy == Accuracy::Fast || self.binned.is_some() || self.placer.is_some()
    }

    /// The predicted worst-case rounding error; `None` where answers are certified.
    pub(crate) fn predicted(&self, scene: &Scene) -> Option<Prediction> {
        let of_view = || Prediction::of_view(&self.view, scene, self.plan.kernel.method);
        (self.plan.accuracy == Accuracy::Fast).then(|| self.plan.predicted.or_else(of_view)).flatten()
    }

    /// The warnings that are known before a ray is traced.
    pub(crate) fn warnings(&self, scene: &Scene, settings: &Settings, predicted: Option<Prediction>) -> Vec<String> {
        let plan = &self.plan;
        let warning = predicted.and_then(|predicted| predicted.warning(plan.kernel.method));
        let mut warnings: Vec<String> = warning.into_iter().collect();
        if scene.spheres.is_empty() {
            warnings.push("the scene has 0 spheres, so every pixel is background".into());
        }
        if settings.search != Search::Auto && plan.search != settings.search {
            warnings.push(plan.search_reason.into());
        }
        warnings
    }

    /// The binned scene of a certified frame.
    pub(crate) fn certified(&self) -> Option<&BinnedScene> {
        self.binned.as_ref().filter(|_| self.plan.kernel.certify)
    }
}
