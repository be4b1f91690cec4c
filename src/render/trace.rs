//! Traces given rays instead of viewing rays: lidar beams, secondary rays, single queries.

mod by_method;
mod certified;
pub mod echoes;
#[cfg(test)]
mod tests;

use super::budget;
use super::plan::{GivenPlan, choose};
use super::renderer::Renderer;
use crate::answers::settle::Settled;
use crate::cpu;
use crate::frame::Aov;
use crate::frame::report::milliseconds;
use crate::scene::Spheres;
use crate::search::tree::Tree;
use crate::settings::{Accuracy, Backend, Search, Settings};
pub use crate::view::given::Rays;
use halfline_ground::error::Result;
use halfline_ground::memory::zeroed;
use halfline_ground::parallel;
use std::sync::Arc;
use web_time::Instant;

/// The nearest hits of given rays, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Hits {
    /// Index of the sphere; -1 on a miss.
    pub id: Vec<i32>,
    /// The hit is at origin + t direction, in units of the given direction; +inf on a miss.
    pub t: Vec<f64>,
    /// Euclidean length from the origin to the hit, t |direction|; +inf on a miss.
    pub distance: Vec<f64>,
    /// 0 proved by the kernel, 1 settled by the judge, 255 not certified; for misses too.
    pub certainty: Vec<u8>,
    /// Unit normals against the ray, 0,0,0 on a miss; `None` unless [`crate::Aov::Normal`] is requested.
    pub normal: Option<Vec<[f32; 3]>>,
    /// Proven bounds of the absolute errors of `distance`; 0 on a miss, +inf where nothing is proven, `None` unless
    /// [`crate::Aov::Bound`] is requested.
    pub bound: Option<Vec<f64>>,
    /// The search that found candidates, never `auto`. The answers do not depend on it.
    pub search: Search,
}

/// Whether given rays hit anything within their limits, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Occlusion {
    /// 1 where some sphere is hit at 0 < t < limit, else 0.
    pub hit: Vec<u8>,
    /// The certainty of the answer, as [`Hits::certainty`].
    pub certainty: Vec<u8>,
}

/// Spheres set up for given rays, which may come in any number of calls.
///
/// ```
/// use halfline::{Rays, Renderer, Settings, Spheres};
///
/// let spheres = Spheres { centers: vec![[0.0, 0.0, -3.0]].into(), radii: vec![1.0].into(), ..Spheres::default() };
/// let settings = Settings::default();
/// let mut renderer = Renderer::new(&settings)?;
/// let mut tracer = renderer.tracer(&spheres, &settings)?;
/// let directions = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]];
/// let hits = tracer.hits(&Rays { origins: &[[0.0; 3]], directions: &directions, limits: &[] })?;
/// assert_eq!((hits.id, hits.t[0]), (vec![0, -1], 2.0));
/// # Ok::<(), halfline::Error>(())
/// ```
pub struct Tracer<'a> {
    renderer: &'a mut Renderer,
    spheres: &'a Spheres,
    plan: GivenPlan,
    /// Present if answers are certified and there are spheres.
    tree: Option<Arc<Tree>>,
    warning: Option<String>,
    backend: Backend,
    /// Whether an adapter that is open is not used.
    on_host: bool,
    tolerance: f64,
    /// Whether bounds of the errors are requested.
    bounds: bool,
    build_ms: f64,
}

impl<'a> Tracer<'a> {
    /// A tracer of a frame's rays by a plan, with the tree that its engine keeps.
    pub(super) fn of_frame(
        renderer: &'a mut Renderer,
        spheres: &'a Spheres,
        plan: GivenPlan,
        tree: Option<Arc<Tree>>,
        (tolerance, bounds): (f64, bool),
    ) -> Self {
        let (warning, backend, on_host, build_ms) = (None, Backend::default(), false, 0.0);
        Self { renderer, spheres, plan, tree, warning, backend, on_host, tolerance, bounds, build_ms }
    }

    /// The nearest hit of each ray. Certified and exact answers agree with exact arithmetic: t and distance within
    /// the promised relative error, the normal within 1e-3 rad.
    ///
    /// # Errors
    /// [`crate::Error::Settings`] for invalid rays, [`crate::Error::Interrupted`], and errors of the device.
    pub fn hits(&mut self, rays: &Rays) -> Result<Hits> {
        rays.check()?;
        self.answered(|this| this.answers(rays)).map(|(hits, _)| hits)
    }

    /// The nearest hits, and the rays that the judge decided, in their order. A failing device is an error.
    pub(super) fn answers(&mut self, rays: &Rays) -> Result<(Hits, Vec<Settled>)> {
        if self.plan.certifies() { self.certified_hits(rays) } else { Ok((self.hits_by_method(rays)?, Vec::new())) }
    }

    /// Whether each ray hits any sphere within its limit.
    ///
    /// # Errors
    /// As [`Self::hits`].
    pub fn occluded(&mut self, rays: &Rays) -> Result<Occlusion> {
        rays.check()?;
        if self.plan.certifies() {
            return self.certified_occlusion(rays);
        }
        let hits = self.hits(rays)?;
        Ok(Occlusion { hit: hits.id.iter().map(|id| u8::from(*id >= 0)).collect(), certainty: hits.certainty })
    }

    /// Misses of so many rays, with certainty 0, in whose places hits are put.
    pub(super) fn misses(&self, count: usize) -> Hits {
        Hits {
            id: parallel::from_fn(count, |_| -1),
            t: parallel::from_fn(count, |_| f64::INFINITY),
            distance: parallel::from_fn(count, |_| f64::INFINITY),
            certainty: zeroed(count),
            normal: self.plan.kernel.normal.then(|| zeroed(count)),
            bound: self.bounds.then(|| zeroed(count)),
            search: self.plan.search,
        }
    }

    /// Runs `work`, and where the adapter fails once more on the CPU path, which answers all calls from then on.
    fn answered<T>(&mut self, work: impl Fn(&mut Self) -> Result<T>) -> Result<T> {
        if !self.on_host {
            match work(self) {
                Err(error) => self.warning = Some(self.renderer.device.leave(error, self.backend)?),
                done => return done,
            }
            self.on_host = true;
        }
        let gpu = self.renderer.device.gpu.take();
        let done = work(self);
        self.renderer.device.gpu = gpu;
        done
    }

    /// Whether an adapter traces. Certified and exact answers come from the CPU path with every backend.
    #[must_use]
    pub fn is_gpu(&self) -> bool {
        !self.plan.certifies() && self.renderer.is_gpu() && !self.on_host
    }

    /// The reason why an adapter is not used although the settings allow it.
    #[must_use]
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// The name of the adapter that traces, or `cpu`.
    #[must_use]
    pub fn adapter(&self) -> &str {
        if self.is_gpu() { self.renderer.adapter() } else { cpu::NAME }
    }

    /// Driver and its version, threads for the CPU path.
    #[must_use]
    pub fn driver(&self) -> String {
        if self.is_gpu() { self.renderer.driver() } else { cpu::driver() }
    }

    /// The accuracy of the answers: fast, certified or exact.
    #[must_use]
    pub fn accuracy(&self) -> Accuracy {
        self.plan.accuracy
    }

    /// The name of the method; `certified` and `exact` choose their own.
    #[must_use]
    pub fn method(&self) -> &'static str {
        self.plan.method
    }

    /// The search for the spheres of a ray: all or tree; by a method all.
    #[must_use]
    pub fn search(&self) -> Search {
        self.plan.search
    }

    /// Time to build the tree in milliseconds; 0 by a method.
    #[must_use]
    pub fn build_ms(&self) -> f64 {
        self.build_ms
    }
}

/// Traces given rays once. For many calls keep a [`Tracer`].
///
/// # Errors
/// As [`Renderer::trace`].
pub fn trace(spheres: &Spheres, origins: &[[f64; 3]], directions: &[[f64; 3]], settings: &Settings) -> Result<Hits> {
    Renderer::new(settings)?.trace(spheres, origins, directions, settings)
}

impl Renderer {
    /// Sets up `spheres` for any number of calls with given rays. Of `settings`, only `accuracy`, `method`, `search`,
    /// `tolerance` and, for normals and bounds, `aovs` are used. Without a method, answers are certified unless the accuracy is
    /// fast.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] for invalid spheres, [`crate::Error::Settings`] for a contradiction, [`crate::Error::Limits`] for more spheres
    /// than a method tests in useful time.
    pub fn tracer<'a>(&'a mut self, spheres: &'a Spheres, settings: &Settings) -> Result<Tracer<'a>> {
        spheres.check()?;
        let (plan, warning) = self.given_plan(spheres, settings)?;
        let tolerance = settings.promise().relative();
        let start = Instant::now();
        let tree = plan.certifies().then(|| Tree::new(&spheres.centers, &spheres.radii)).flatten().map(Arc::new);
        let build_ms = if tree.is_some() { milliseconds(start) } else { 0.0 };
        let (backend, on_host) = (settings.backend, warning.is_some());
        let bounds = settings.asks(&[Aov::Bound]);
        Ok(Tracer { renderer: self, spheres, plan, tree, warning, backend, on_host, tolerance, bounds, build_ms })
    }

    /// The plan for given rays, and the reason why an adapter is not used although the settings allow it.
    ///
    /// # Errors
    /// As [`Renderer::tracer`].
    fn given_plan(&mut self, spheres: &Spheres, settings: &Settings) -> Result<(GivenPlan, Option<String>)> {
        let plan = GivenPlan::new(settings, spheres.len())?;
        // With every backend: what would be left to the host takes longer than the CPU path (docs/hardware.md).
        if plan.certifies() {
            return Ok((plan, None));
        }
        if spheres.cuts.is_some() {
            return Err(choose::cut_by_method());
        }
        let load = budget::on_device(spheres.len(), &plan.kernel, 0);
        let blocker = self.blocker(load, plan.accuracy, settings.backend);
        let warning = blocker.or_else(|error| self.device.leave(error, settings.backend).map(Some))?;
        Ok((plan, warning))
    }

    /// The nearest hit of each ray origin + t direction, t > 0. `origins` holds one point per direction, or a single
    /// one for all. Directions have any length but zero. Settings as for [`Renderer::tracer`].
    ///
    /// # Errors
    /// Errors of [`Renderer::tracer`] and [`Tracer::hits`].
    pub fn trace(
        &mut self,
        spheres: &Spheres,
        origins: &[[f64; 3]],
        directions: &[[f64; 3]],
        settings: &Settings,
    ) -> Result<Hits> {
        self.tracer(spheres, settings)?.hits(&Rays { origins, directions, limits: &[] })
    }
}
