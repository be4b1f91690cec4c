//! The setup of one frame: the view, and the engine that finds its first hits.

use super::engine::{Engine, EverySphere, Exact, Found, GivenRays, Resident, Strips, ViewRays};
use super::log::FrameLog;
use super::order::Ordered;
use super::plan::Plan;
use super::plan::kind::EngineKind;
use super::renderer::NOTHING;
use super::rendering::Rendering;
use crate::answers::hits::FirstHits;
use crate::certify::binned::{BinnedScene, Binning, Through};
use crate::certify::grouped::Grouped;
use crate::certify::placing::Placer;
use crate::gpu::Gpu;
use crate::gpu::resident::scene::Reach;
use crate::intersect::predict::Prediction;
use crate::scene::Scene;
use crate::settings::{Accuracy, Settings};
use crate::view::raster::Raster;
use crate::view::{Records, View, middle};
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;

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

/// The reason for the CPU path where the rays of a camera are certified one by one.
const GIVEN: &str = "it certifies the rays of curved lenses";

/// The setup of a frame: a device that certifies holds the spheres, else the host bins them.
///
/// # Errors
/// Errors of [`FrameSetup::resident`] and [`FrameSetup::new`].
pub(super) fn make(at: &mut Rendering<'_>, plan: Plan, scene: &Scene, raster: Raster) -> Result<FrameSetup> {
    let frame = at.renderer.frames;
    let hold = |gpu: &mut Gpu, log: &mut FrameLog| log.time("hold", || gpu.hold(scene, frame));
    let plan = match on_device(at, plan, scene, raster, hold)? {
        ResidentSetup::Ready(setup) => return Ok(*setup),
        ResidentSetup::Refused(plan) => plan,
    };
    let pixels = u64::from(raster.window.width()) * u64::from(raster.window.height());
    // Groups are hidden by all spheres.
    let is_grouped =
        plan.accuracy == Accuracy::Certified && plan.given.is_none() && !plan.is_deep && scene.spheres.cuts.is_none();
    let ordered = || at.renderer.order_of(&scene.spheres).groups(&scene.spheres, frame, pixels);
    let order = is_grouped.then(ordered).flatten();
    FrameSetup::new(at, plan, (scene, order.as_deref().map(Ordered::groups)), raster)
}

/// The plan by which [`make`] sets a frame up, without holding the spheres.
///
/// # Errors
/// As [`make`].
pub(super) fn decided(at: &mut Rendering<'_>, plan: Plan, raster: Raster) -> Result<Plan> {
    let scene = at.scene;
    let reach = |gpu: &mut Gpu, _: &mut FrameLog| gpu.reach(&scene.spheres);
    match on_device(at, plan, scene, raster, reach)? {
        ResidentSetup::Ready(setup) => Ok(setup.plan),
        ResidentSetup::Refused(plan) if plan.engine == EngineKind::Strips => {
            let view = View::for_rays(scene, raster, Records::None)?;
            let is_bounded = binning(at, &plan, (scene, None), &view).is_bounded()?;
            Ok(Plan { engine: if is_bounded { plan.engine } else { EngineKind::Judge }, ..plan })
        }
        ResidentSetup::Refused(plan) => Ok(plan),
    }
}

/// The setup where the device holds the spheres, whose reach `reach` returns. Where the device cannot place them, the plan for
/// the CPU path.
fn on_device(
    Rendering { renderer, settings, log, .. }: &mut Rendering<'_>,
    plan: Plan,
    scene: &Scene,
    raster: Raster,
    reach: impl FnOnce(&mut Gpu, &mut FrameLog) -> Result<Option<Reach>>,
) -> Result<ResidentSetup> {
    if renderer.is_gpu() && plan.certifies_given() {
        log.refuse(GIVEN);
    }
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

/// The binning of the spheres by which the host finds the hits that a plan asks for.
fn binning<'a>(
    at: &'a Rendering<'_>,
    plan: &Plan,
    (scene, groups): (&'a Scene, Option<Grouped<'a>>),
    view: &'a View,
) -> Binning<'a> {
    let opacities = scene.spheres.opacities.as_deref().filter(|_| plan.is_deep);
    let through = opacities.map(|opacities| Through { opacities, layers: at.settings.layers });
    Binning { groups, through, ..Binning::of(scene, view, at.settings.promise().relative(), &at.pool) }
}

impl FrameSetup {
    /// The setup where a device holds the spheres, whose sizes and distances have exponents within `sizes`.
    ///
    /// # Errors
    /// Errors of [`View::new`], except errors of the spheres.
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
            // What is projected depends on the unit: here it is the unit of the CPU path, which looks at every sphere.
            view = View::for_rays(scene, raster, Records::None)?;
            placer = Placer::new(scene, &view, tolerance)?;
        }
        Ok(match placer {
            Some(placer) => ResidentSetup::Ready(Box::new(Self { plan, view, engine: Box::new(Resident { placer }) })),
            None => ResidentSetup::Refused(plan),
        })
    }

    /// The setup on the host for the rays of `raster` in one frame of `scene`, whose spheres may be known in groups. Where f32
    /// cannot bound the projection of the lens, the judge is the engine.
    ///
    /// # Errors
    /// Errors of [`View::new`] and of [`BinnedScene::new`].
    pub(super) fn new(
        at: &mut Rendering<'_>,
        plan: Plan,
        (scene, groups): (&Scene, Option<Grouped<'_>>),
        raster: Raster,
    ) -> Result<Self> {
        let view = at.log.time("view", || View::for_rays(scene, raster, plan.kernel.records()))?;
        let engine: Box<dyn Engine> = match (&plan.given, plan.engine) {
            (Some(given), _) => Box::new(GivenRays::new(given.clone(), at.settings)),
            (None, EngineKind::Method) => Box::new(EverySphere),
            (None, _) => Box::new(Exact),
        };
        let mut setup = Self { plan, view, engine };
        if let EngineKind::Strips | EngineKind::Resident = setup.plan.engine {
            setup.bin(at, scene, groups)?;
        }
        Ok(setup)
    }

    /// Finds the first hits of the rays of the view's sample: where a device leaves them to the host, on the CPU path.
    ///
    /// # Errors
    /// Errors of the engines.
    pub(super) fn find(&mut self, at: &mut Rendering<'_>, scene: &Scene, hits: &mut FirstHits) -> Result<()> {
        if let Some(gpu) = &mut at.renderer.device.gpu {
            gpu.forget_hits();
        }
        let settled = loop {
            let rays = ViewRays { scene, view: &self.view, kernel: &self.plan.kernel };
            match self.engine.first_hits(at, rays, &mut hits.raw)? {
                Found::Hits(settled) => break settled,
                Found::Left(reason) => {
                    at.log.refuse(&reason);
                    self.plan.engine = EngineKind::Strips;
                    self.bin(at, scene, None)?;
                }
            }
        };
        hits.settle(settled);
        Ok(())
    }

    /// The engine that finds the layers behind the first hits; `None` where the setup's engine does.
    ///
    /// # Errors
    /// Errors of [`BinnedScene::new`].
    pub(super) fn deep(&self, at: &mut Rendering<'_>, scene: &Scene) -> Result<Option<Box<dyn Engine>>> {
        let finds_all = self.plan.given.is_some() || self.engine.binned().is_some();
        if finds_all || !self.plan.is_deep {
            return Ok(None);
        }
        let binned = at.time("layers", |at| BinnedScene::new(&binning(at, &self.plan, (scene, None), &self.view)))?;
        Ok(Some(match binned {
            Some(binned) => Box::new(Strips { binned }),
            None => Box::new(Exact),
        }))
    }

    /// Bins the spheres. Where that is impossible, the judge is the engine.
    fn bin(&mut self, at: &mut Rendering<'_>, scene: &Scene, groups: Option<Grouped<'_>>) -> Result<()> {
        let of = |at: &mut Rendering<'_>| BinnedScene::new(&binning(at, &self.plan, (scene, groups), &self.view));
        match at.time("stage", of)? {
            Some(binned) => self.engine = Box::new(Strips { binned }),
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
