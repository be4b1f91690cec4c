//! The setup of one frame: the view, and the data of the plan's engine.

use super::plan::Plan;
use super::plan::engine::Engine;
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::grouped::Grouped;
use crate::certify::placing::Placer;
use crate::error::Result;
use crate::frame::report::Timings;
use crate::intersect::predict::Prediction;
use crate::memory::Pool;
use crate::scene::Scene;
use crate::settings::{Accuracy, Settings};
use crate::view::raster::Raster;
use crate::view::{Records, View, middle};

/// A plan with the data that it needs.
pub(crate) struct FrameSetup {
    /// The plan, with the engine that the stage is for.
    pub(crate) plan: Plan,
    pub(crate) view: View,
    pub(crate) stage: Stage,
}

/// The data of an engine besides the view.
pub(crate) enum Stage {
    /// None: a method tests the spheres of the view.
    Method,
    /// The spheres, binned into tiles by the host.
    Binned(Box<BinnedScene>),
    /// The host's part in placing the spheres that a device holds.
    Placed(Box<Placer>),
    /// None: the judge decides every pixel.
    Judge,
}

/// A setup for a device, or the plan where the device cannot render it.
pub(crate) enum ResidentSetup {
    Ready(Box<FrameSetup>),
    /// The camera does not allow it.
    Refused(Plan),
}

impl FrameSetup {
    /// The setup where a device holds the spheres, whose sizes and distances have exponents within `sizes`.
    ///
    /// # Errors
    /// Errors of [`View::new`], except those of the spheres.
    pub(crate) fn resident(
        plan: Plan,
        scene: &Scene,
        settings: &Settings,
        raster: Raster,
        sizes: [i32; 2],
    ) -> Result<ResidentSetup> {
        let (unit, tolerance) = (middle(sizes), settings.promise().relative());
        let mut view = View::in_unit(scene, raster, Some(unit))?;
        let mut placer = Placer::new(scene, &view, tolerance)?;
        if placer.as_ref().is_some_and(|placer| !placer.is_same_in_units(sizes[1] + 1 - unit)) {
            // What is projected depends on the unit: here it is that of the CPU path, which looks at every sphere.
            view = View::for_rays(scene, raster, Records::None)?;
            placer = Placer::new(scene, &view, tolerance)?;
        }
        Ok(match placer {
            Some(placer) => ResidentSetup::Ready(Box::new(Self { plan, view, stage: Stage::Placed(Box::new(placer)) })),
            None => ResidentSetup::Refused(plan),
        })
    }

    /// The setup on the host for the rays of `raster` in one frame of `scene`, whose spheres may be known in groups. Where f32
    /// cannot bound the projection of the lens, the judge is the engine.
    ///
    /// # Errors
    /// Errors of [`View::new`] and of [`BinnedScene::new`].
    pub(crate) fn new(
        plan: Plan,
        (scene, groups): (&Scene, Option<Grouped<'_>>),
        settings: &Settings,
        raster: Raster,
        pool: &Pool,
        timings: &mut Timings,
    ) -> Result<Self> {
        let view = timings.time("view", || View::for_rays(scene, raster, plan.kernel.records()))?;
        let stage = if plan.engine == Engine::Method { Stage::Method } else { Stage::Judge };
        let mut setup = Self { plan, view, stage };
        if let Engine::Strips | Engine::Resident = setup.plan.engine {
            setup.bin(scene, groups, settings, pool, timings)?;
        }
        Ok(setup)
    }

    /// Leaves the frame to the CPU path, where a device has refused it.
    ///
    /// # Errors
    /// Errors of [`BinnedScene::new`].
    pub(crate) fn move_to_host(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        pool: &Pool,
        timings: &mut Timings,
    ) -> Result<()> {
        self.plan.engine = Engine::Strips;
        self.bin(scene, None, settings, pool, timings)
    }

    /// Bins the spheres. Where that is impossible, the judge is the engine.
    fn bin(
        &mut self,
        scene: &Scene,
        groups: Option<Grouped<'_>>,
        settings: &Settings,
        pool: &Pool,
        timings: &mut Timings,
    ) -> Result<()> {
        let tolerance = settings.promise().relative();
        let binning = Binning { groups, ..Binning::of(scene, &self.view, tolerance, pool) };
        match timings.time("stage", || BinnedScene::new(&binning))? {
            Some(binned) => self.stage = Stage::Binned(Box::new(binned)),
            None => (self.stage, self.plan.engine) = (Stage::Judge, Engine::Judge),
        }
        Ok(())
    }

    /// The predicted worst-case rounding error of a method; `None` for the other engines.
    pub(crate) fn predicted(&self, scene: &Scene) -> Option<Prediction> {
        let method = self.plan.kernel.method()?;
        self.plan.predicted.or_else(|| Prediction::of_view(&self.view, scene, method))
    }

    /// The warnings that are known before a ray is traced.
    pub(crate) fn warnings(&self, scene: &Scene, predicted: Option<Prediction>) -> Vec<String> {
        let warning =
            predicted.zip(self.plan.kernel.method()).and_then(|(predicted, method)| predicted.warning(method));
        let mut warnings: Vec<String> = warning.into_iter().collect();
        if scene.spheres.is_empty() {
            warnings.push("the scene has 0 spheres, so every pixel is background".into());
        }
        warnings
    }

    /// Whether the pixels that f32 proves are certified, and the others settled.
    pub(crate) fn is_certified(&self) -> bool {
        self.plan.accuracy == Accuracy::Certified && matches!(self.stage, Stage::Binned(_) | Stage::Placed(_))
    }

    /// The spheres as the host binned them.
    pub(crate) fn binned(&self) -> Option<&BinnedScene> {
        match &self.stage {
            Stage::Binned(binned) => Some(binned),
            _ => None,
        }
    }

    /// Returns its memory to the pool for the next frame.
    pub(crate) fn put_back(self, pool: &Pool) {
        self.into_view(pool);
    }

    /// The view; the rest of its memory returns to the pool.
    pub(crate) fn into_view(self, pool: &Pool) -> View {
        if let Stage::Binned(binned) = self.stage {
            binned.put_back(pool);
        }
        self.view
    }
}
