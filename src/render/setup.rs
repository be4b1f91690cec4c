//! The setup of one frame: the view, and the engine that finds its first hits.

use super::engine::{Engine, EverySphere, Exact, Found, GivenRays, Resident, Strips, ViewRays};
use super::log::FrameLog;
use super::order::Ordered;
use super::plan::Plan;
use super::plan::kind::EngineKind;
use super::renderer::{NOTHING, Renderer};
use crate::answers::hits::FirstHits;
use crate::certify::binned::{BinnedScene, Binning};
use crate::certify::grouped::Grouped;
use crate::certify::placing::Placer;
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::resident::scene::Reach;
use crate::intersect::predict::Prediction;
use crate::memory::Pool;
use crate::scene::Scene;
use crate::settings::{Accuracy, Settings};
use crate::view::raster::Raster;
use crate::view::{Records, View, middle};
use std::sync::Arc;

/// A plan with the data that it needs.
pub(super) struct FrameSetup {
    /// The plan, with the kind of the engine.
    pub(super) plan: Plan,
    pub(super) view: View,
    pub(super) engine: Box<dyn Engine>,
}

/// A setup for a device, or the plan where the device cannot render it.
enum ResidentSetup {
    Ready(Box<FrameSetup>),
    /// The camera does not allow it.
    Refused(Plan),
}

/// The reason for the CPU path where f32 on a device cannot place the spheres.
const NOT_PLACED: &str = "the device cannot place these spheres for this camera";

/// The setup of a frame: a device that certifies holds the spheres, else the host bins them.
///
/// # Errors
/// Errors of [`FrameSetup::resident`] and [`FrameSetup::new`].
pub(super) fn make(
    renderer: &mut Renderer,
    plan: Plan,
    scene: &Scene,
    settings: &Settings,
    raster: Raster,
    log: &mut FrameLog,
) -> Result<FrameSetup> {
    let frame = renderer.frames;
    let hold = |gpu: &mut Gpu, log: &mut FrameLog| log.time("hold", || gpu.hold(scene, frame));
    let plan = match on_device(renderer, plan, (scene, settings, raster), log, hold)? {
        ResidentSetup::Ready(setup) => return Ok(*setup),
        ResidentSetup::Refused(plan) => plan,
    };
    let pool = Arc::clone(&renderer.pool);
    let pixels = u64::from(raster.window.width()) * u64::from(raster.window.height());
    // Groups are hidden by all spheres.
    let is_grouped = plan.accuracy == Accuracy::Certified && plan.given.is_none() && !plan.is_deep;
    let ordered = || renderer.order_of(&scene.spheres).groups(&scene.spheres, frame, pixels);
    let order = is_grouped.then(ordered).flatten();
    FrameSetup::new(plan, (scene, order.as_ref().map(Ordered::groups)), settings, raster, &pool, log)
}

/// The plan by which [`make`] sets a frame up, without holding the spheres.
///
/// # Errors
/// As [`make`].
pub(super) fn decided(
    renderer: &mut Renderer,
    plan: Plan,
    scene: &Scene,
    settings: &Settings,
    raster: Raster,
    log: &mut FrameLog,
) -> Result<Plan> {
    let reach = |gpu: &mut Gpu, _: &mut FrameLog| gpu.reach(&scene.spheres);
    match on_device(renderer, plan, (scene, settings, raster), log, reach)? {
        ResidentSetup::Ready(setup) => Ok(setup.plan),
        ResidentSetup::Refused(plan) if plan.engine == EngineKind::Strips => {
            let view = View::for_rays(scene, raster, Records::None)?;
            let binning = Binning::of(scene, &view, settings.promise().relative(), &renderer.pool);
            let engine = if binning.is_bounded()? { plan.engine } else { EngineKind::Judge };
            Ok(Plan { engine, ..plan })
        }
        ResidentSetup::Refused(plan) => Ok(plan),
    }
}

/// The setup where the device holds the spheres, whose reach `reach` returns. Where the device cannot place them, the plan for
/// the CPU path.
fn on_device(
    renderer: &mut Renderer,
    plan: Plan,
    (scene, settings, raster): (&Scene, &Settings, Raster),
    log: &mut FrameLog,
    reach: impl FnOnce(&mut Gpu, &mut FrameLog) -> Result<Option<Reach>>,
) -> Result<ResidentSetup> {
    let Some(gpu) = renderer.device.gpu.as_mut().filter(|_| plan.engine == EngineKind::Resident) else {
        return Ok(ResidentSetup::Refused(plan));
    };
    scene.check()?;
    let eye = scene.camera.basis()?.e;
    let reach = if gpu.verdict()?.places { reach(gpu, log)? } else { None };
    let setup = match reach.and_then(|reach| reach.sizes(eye)) {
        Some(sizes) => log.time("view", || FrameSetup::resident(plan, scene, settings, raster, sizes))?,
        None => ResidentSetup::Refused(plan),
    };
    Ok(match setup {
        ResidentSetup::Refused(plan) => {
            log.refuse(if scene.spheres.is_empty() { NOTHING } else { NOT_PLACED });
            ResidentSetup::Refused(Plan { engine: EngineKind::Strips, ..plan })
        }
        ready => ready,
    })
}

impl FrameSetup {
    /// The setup where a device holds the spheres, whose sizes and distances have exponents within `sizes`.
    ///
    /// # Errors
    /// Errors of [`View::new`], except those of the spheres.
    fn resident(
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
        let proves = plan.accuracy == Accuracy::Certified;
        Ok(match placer {
            Some(placer) => {
                ResidentSetup::Ready(Box::new(Self { plan, view, engine: Box::new(Resident { placer, proves }) }))
            }
            None => ResidentSetup::Refused(plan),
        })
    }

    /// The setup on the host for the rays of `raster` in one frame of `scene`, whose spheres may be known in groups. Where f32
    /// cannot bound the projection of the lens, the judge is the engine.
    ///
    /// # Errors
    /// Errors of [`View::new`] and of [`BinnedScene::new`].
    pub(super) fn new(
        plan: Plan,
        (scene, groups): (&Scene, Option<Grouped<'_>>),
        settings: &Settings,
        raster: Raster,
        pool: &Pool,
        log: &mut FrameLog,
    ) -> Result<Self> {
        let view = log.time("view", || View::for_rays(scene, raster, plan.kernel.records()))?;
        let engine: Box<dyn Engine> = match (&plan.given, plan.engine) {
            (Some(given), _) => Box::new(GivenRays::new(given.clone(), settings)),
            (None, EngineKind::Method) => Box::new(EverySphere),
            (None, _) => Box::new(Exact),
        };
        let mut setup = Self { plan, view, engine };
        if let EngineKind::Strips | EngineKind::Resident = setup.plan.engine {
            setup.bin(scene, groups, settings, pool, log)?;
        }
        Ok(setup)
    }

    /// Finds the first hits of the rays of the view's sample: where a device leaves them to the host, on the CPU path.
    ///
    /// # Errors
    /// Errors of the engines.
    pub(super) fn find(
        &mut self,
        renderer: &mut Renderer,
        scene: &Scene,
        settings: &Settings,
        hits: &mut FirstHits,
        log: &mut FrameLog,
    ) -> Result<()> {
        if let Some(gpu) = &mut renderer.device.gpu {
            gpu.forget_hits();
        }
        let settled = loop {
            let rays = ViewRays { scene, view: &self.view, kernel: &self.plan.kernel };
            match self.engine.first_hits(renderer, rays, &mut hits.raw, log)? {
                Found::Hits(settled) => break settled,
                Found::Left(reason) => {
                    log.refuse(&reason);
                    self.plan.engine = EngineKind::Strips;
                    self.bin(scene, None, settings, &renderer.pool, log)?;
                }
            }
        };
        hits.settle(settled);
        Ok(())
    }

    /// The engine that finds the layers behind the first hits; `None` where that of the setup does.
    ///
    /// # Errors
    /// Errors of [`BinnedScene::new`].
    pub(super) fn deep(
        &self,
        scene: &Scene,
        settings: &Settings,
        pool: &Pool,
        log: &mut FrameLog,
    ) -> Result<Option<Box<dyn Engine>>> {
        let finds_all = self.plan.given.is_some() || self.engine.binned().is_some();
        if finds_all || !self.plan.is_deep {
            return Ok(None);
        }
        let binning = self.binning(scene, None, settings, pool);
        Ok(Some(match log.time("layers", || BinnedScene::new(&binning))? {
            Some(binned) => Box::new(Strips { binned, proves: false }),
            None => Box::new(Exact),
        }))
    }

    /// The binning of the spheres by which the host finds the hits that the plan asks for.
    fn binning<'a>(
        &'a self,
        scene: &'a Scene,
        groups: Option<Grouped<'a>>,
        settings: &Settings,
        pool: &'a Pool,
    ) -> Binning<'a> {
        let opacities = scene.spheres.opacities.as_deref().filter(|_| self.plan.is_deep);
        Binning { groups, opacities, ..Binning::of(scene, &self.view, settings.promise().relative(), pool) }
    }

    /// Bins the spheres. Where that is impossible, the judge is the engine.
    fn bin(
        &mut self,
        scene: &Scene,
        groups: Option<Grouped<'_>>,
        settings: &Settings,
        pool: &Pool,
        log: &mut FrameLog,
    ) -> Result<()> {
        let binning = self.binning(scene, groups, settings, pool);
        let proves = self.plan.accuracy == Accuracy::Certified;
        match log.time("stage", || BinnedScene::new(&binning))? {
            Some(binned) => self.engine = Box::new(Strips { binned, proves }),
            None => (self.engine, self.plan.engine) = (Box::new(Exact), EngineKind::Judge),
        }
        Ok(())
    }

    /// The predicted worst-case rounding error of a method; `None` for the other engines.
    pub(super) fn predicted(&self, scene: &Scene) -> Option<Prediction> {
        let method = self.plan.kernel.method()?;
        self.plan.predicted.or_else(|| Prediction::of_view(&self.view, scene, method))
    }

    /// The warnings that are known before a ray is traced.
    pub(super) fn warnings(&self, scene: &Scene, predicted: Option<Prediction>) -> Vec<String> {
        let warning =
            predicted.zip(self.plan.kernel.method()).and_then(|(predicted, method)| predicted.warning(method));
        let mut warnings: Vec<String> = warning.into_iter().collect();
        if scene.spheres.is_empty() {
            warnings.push("the scene has 0 spheres, so every pixel is background".into());
        }
        let without_ray = self.view.curved.as_ref().map_or(0, |curved| curved.without_ray());
        if without_ray > 0 {
            warnings.push(format!(
                "{without_ray} pixels have no viewing ray, because the lens's model gives their places no direction; they are misses"
            ));
        }
        warnings
    }

    /// Returns its memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) {
        self.into_view(pool);
    }

    /// The view; the rest of its memory returns to the pool.
    pub(super) fn into_view(self, pool: &Pool) -> View {
        self.engine.put_back(pool);
        self.view
    }
}
