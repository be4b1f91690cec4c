//! Traces given rays instead of viewing rays: lidar beams, secondary rays, single queries.
//!
//! Rays that share an origin are traced with the spheres moved there in f64, like viewing rays. Rays from many points
//! carry their origins as a high and a low f32 part, and so do the centres: the kernel subtracts high from high and low
//! from low. Rays are grouped by origin where the groups are large enough to pay for moving the spheres.

use super::plan::Plan;
use super::renderer::{Executor, Renderer};
use crate::answers::raw::Raw;
use crate::error::{Error, Place, Result};
use crate::frame::report::Timings;
use crate::gpu::input::{Input, Output};
use crate::kernel::{Kernel, RaySource};
use crate::scene::{Spheres, check_sphere};
use crate::search::tree::{Shape, Slack, Tree, coherent};
use crate::settings::{Accuracy, Search, Settings};
use crate::view::View;
use crate::view::ray::{NONE, RayRecord};
use crate::{cpu, double_double as dd};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Rays given by the caller: origin + t direction, 0 < t < limit. All numbers are taken as exact.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rays<'a> {
    /// One point per direction, or a single one for all.
    pub origins: &'a [[f64; 3]],
    /// Of any length but zero.
    pub directions: &'a [[f64; 3]],
    /// One limit per direction, in units of the direction, or none at all. A hit at t counts only if t < limit; +inf
    /// is no limit, and with a limit of 0 or less nothing is hit.
    pub limits: &'a [f64],
}

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
    /// How candidates were found; never `auto`. The answers do not depend on it.
    pub search: Search,
}

/// Whether given rays hit anything within their limits, in their order.
#[derive(Debug, Clone, PartialEq)]
pub struct Occlusion {
    /// 1 where some sphere is hit at 0 < t < limit, else 0.
    pub hit: Vec<u8>,
    /// As that of [`Hits`].
    pub certainty: Vec<u8>,
}

/// Spheres set up for given rays, which may come in any number of calls.
pub struct Tracer<'a> {
    renderer: &'a mut Renderer,
    spheres: &'a Spheres,
    settings: Settings,
    build_ms: f64,
}

impl Tracer<'_> {
    /// The nearest hit of each ray.
    ///
    /// # Errors
    /// [`Error::Settings`] for invalid rays, [`Error::Interrupted`], and those of the device.
    pub fn hits(&mut self, rays: &Rays) -> Result<Hits> {
        let mut hits = self.renderer.trace(self.spheres, rays.origins, rays.directions, &self.settings)?;
        for (n, limit) in rays.limits.iter().enumerate() {
            if hits.t[n] >= *limit {
                (hits.id[n], hits.t[n], hits.distance[n]) = (-1, f64::INFINITY, f64::INFINITY);
                if let Some(normal) = &mut hits.normal {
                    normal[n] = [0.0; 3];
                }
            }
        }
        Ok(hits)
    }

    /// Whether each ray hits any sphere within its limit.
    ///
    /// # Errors
    /// As [`Self::hits`].
    pub fn occluded(&mut self, rays: &Rays) -> Result<Occlusion> {
        let hits = self.hits(rays)?;
        Ok(Occlusion { hit: hits.id.iter().map(|id| u8::from(*id >= 0)).collect(), certainty: hits.certainty })
    }

    /// The renderer that traces.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        self.renderer
    }

    /// The accuracy of the answers: fast, certified or exact.
    #[must_use]
    pub fn accuracy(&self) -> Accuracy {
        Accuracy::Fast
    }

    /// The name of the method; `certified` and `exact` choose their own.
    #[must_use]
    pub fn method(&self) -> &'static str {
        self.settings.method.unwrap_or(crate::Method::Stable).name()
    }

    /// How the spheres of a ray are found: all or tree.
    #[must_use]
    pub fn search(&self) -> Search {
        Search::Tree
    }

    /// Time to set up the spheres, the tree included, in milliseconds.
    #[must_use]
    pub fn build_ms(&self) -> f64 {
        self.build_ms
    }
}

/// A smaller group does not pay for moving the spheres: its rays fill one workgroup.
const GROUP: usize = 64;

/// Traces given rays once. For many calls keep a [`Renderer`].
///
/// # Errors
/// As [`Renderer::trace`].
pub fn trace(spheres: &Spheres, origins: &[[f64; 3]], directions: &[[f64; 3]], settings: &Settings) -> Result<Hits> {
    Renderer::new(settings)?.trace(spheres, origins, directions, settings)
}

impl Renderer {
    /// Sets up `spheres` for any number of calls with given rays. Of `settings`, only `accuracy`, `method`, `search`
    /// and, for normals, `aovs` are used.
    ///
    /// # Errors
    /// [`Error::Scene`] for invalid spheres, [`Error::Settings`] for a contradiction.
    pub fn tracer<'a>(&'a mut self, spheres: &'a Spheres, settings: &Settings) -> Result<Tracer<'a>> {
        check(spheres, &[], &[])?;
        Ok(Tracer { renderer: self, spheres, settings: settings.clone(), build_ms: 0.0 })
    }

    /// The closest hit of each ray origin + t direction, t > 0. `origins` holds one point per direction, or a single
    /// one for all. Directions have any length but zero. Of `settings`, only `method`, `search` and, for normals,
    /// `aovs` are used.
    ///
    /// # Errors
    /// [`Error::Settings`] for invalid rays, [`Error::Scene`] for invalid spheres, and those of [`Renderer::render`].
    pub fn trace(
        &mut self,
        spheres: &Spheres,
        origins: &[[f64; 3]],
        directions: &[[f64; 3]],
        settings: &Settings,
    ) -> Result<Hits> {
        check(spheres, origins, directions)?;
        let plan = Plan::for_given_rays(settings, spheres.len(), directions.len())?;
        let origin = |n: usize| if origins.len() == 1 { origins[0] } else { origins[n] };
        let mut hits = Hits {
            id: vec![-1; directions.len()],
            t: vec![f64::INFINITY; directions.len()],
            distance: vec![f64::INFINITY; directions.len()],
            certainty: vec![255; directions.len()],
            normal: plan.kernel.normal.then(|| vec![[0.0; 3]; directions.len()]),
            search: plan.search,
        };
        let mut shape = None;
        for mut group in groups(directions.len(), origin) {
            let mut view = View::along_axes(group.eye, &spheres.centers, &spheres.radii)?;
            if group.kind == RaySource::Spread || plan.kernel.is_wide() {
                view.keep_residuals(&spheres.centers, &spheres.radii);
            }
            let record = |&n: &u32| ray_record(&view, origin(n as usize), directions[n as usize]);
            let mut records: Vec<_> = group.rays.par_iter().map(record).collect();
            let far = farthest(&records);
            let tree = (plan.search == Search::Tree).then(|| {
                // Built once for all groups: neighbouring spheres are the same from every origin.
                let shape = shape.get_or_insert_with(|| Shape::new(&spheres.centers, &spheres.radii));
                Tree::new(shape.as_ref()?, &view, far, Slack::of(plan.kernel.method))
            });
            let tree = tree.flatten();
            if tree.is_some() {
                let order = coherent(&records, far);
                group.rays = order.par_iter().map(|&k| group.rays[k as usize]).collect();
                records = order.par_iter().map(|&k| records[k as usize]).collect();
            } else {
                hits.search = Search::All;
            }
            let kernel = Kernel { rays: group.kind, tree: tree.is_some(), ..plan.kernel };
            let mut raw = Raw::new(&kernel, records.len(), &self.pool)?;
            match &mut self.place {
                Executor::Gpu(gpu) => {
                    gpu.check_method(kernel.method)?;
                    let input =
                        Input { view: &view, colors: None, rays: &records, candidates: None, tree: tree.as_ref() };
                    let mut output = Output { raw: &mut raw, timings: &mut Timings::default() };
                    gpu.run(&kernel, &input, &mut output, &|_| self.watch.goes_on())?;
                }
                Executor::Cpu => {
                    cpu::given_rays(&kernel, &view, &records, tree.as_ref(), &mut raw);
                }
            }
            for (k, &n) in group.rays.iter().enumerate() {
                let n = n as usize;
                if raw.id[k] == NONE {
                    continue;
                }
                hits.id[n] = raw.id[k] as i32;
                hits.t[n] = dd::ldexp(raw.t(k), view.unit - scale(directions[n]));
                hits.distance[n] = hits.t[n] * DVec3::from_array(directions[n]).length();
                if let Some(normal) = &mut hits.normal {
                    normal[n] = [raw.normal[3 * k], raw.normal[3 * k + 1], raw.normal[3 * k + 2]];
                }
            }
        }
        Ok(hits)
    }
}

fn check(spheres: &Spheres, origins: &[[f64; 3]], directions: &[[f64; 3]]) -> Result<()> {
    for (index, (c, r)) in spheres.centers.iter().zip(&spheres.radii).enumerate() {
        check_sphere(*c, *r, || Place::field(format!("sphere {index}")))?;
    }
    if origins.len() != 1 && origins.len() != directions.len() {
        let problem = format!("found {} origins for {} directions", origins.len(), directions.len());
        return Err(Error::settings(problem, "use one origin, or one for each direction"));
    }
    if u32::try_from(directions.len()).is_err() {
        let problem = format!("{} rays are more than 32-bit indices can number", directions.len());
        return Err(Error::Limits { problem, mend: format!("trace at most {} rays per call", u32::MAX) });
    }
    if let Some(n) = origins.iter().position(|o| o.iter().any(|x| !x.is_finite())) {
        return Err(Error::settings(format!("origin {n} is not finite"), "use three finite numbers"));
    }
    let no_direction = |d: &[f64; 3]| d.iter().any(|x| !x.is_finite()) || d.iter().all(|x| *x == 0.0);
    if let Some(n) = directions.iter().position(no_direction) {
        return Err(Error::settings(
            format!("direction {n} is zero or not finite"),
            "use a finite direction that is not zero",
        ));
    }
    Ok(())
}

/// Rays that are traced together.
struct Group {
    kind: RaySource,
    eye: DVec3,
    rays: Vec<u32>,
}

/// Groups by origin where that pays; the other rays form one group about the middle of their origins.
fn groups(count: usize, origin: impl Fn(usize) -> [f64; 3]) -> Vec<Group> {
    let mut by_origin: HashMap<[u64; 3], Vec<u32>> = HashMap::new();
    for n in 0..count {
        // Adding 0.0 makes -0.0 and 0.0 the same origin.
        by_origin.entry(origin(n).map(|x| (x + 0.0).to_bits())).or_default().push(n as u32);
    }
    if by_origin.len() == 1 || by_origin.len() * GROUP <= count {
        let group = |(bits, rays): ([u64; 3], _)| Group {
            kind: RaySource::SharedOrigin,
            eye: DVec3::from_array(bits.map(f64::from_bits)),
            rays,
        };
        let mut groups: Vec<_> = by_origin.into_iter().map(group).collect();
        groups.sort_by_key(|g| g.rays[0]);
        return groups;
    }
    let (low, high) = (0..count).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), n| {
        let o = DVec3::from_array(origin(n));
        (low.min(o), high.max(o))
    });
    let eye = low * 0.5 + high * 0.5;
    (count > 0).then(|| Group { kind: RaySource::Spread, eye, rays: (0..count as u32).collect() }).into_iter().collect()
}

/// The exponent that brings a direction's largest component into [1, 2).
fn scale(direction: [f64; 3]) -> i32 {
    dd::exponent(DVec3::from_array(direction).abs().max_element())
}

/// A ray as the kernels read it in `view`.
pub(crate) fn ray_record(view: &View, origin: [f64; 3], direction: [f64; 3]) -> RayRecord {
    let f = scale(direction);
    let direction = direction.map(|x| dd::ldexp(x, -f));
    let d = direction.map(|x| x as f32);
    let d_low: [f32; 3] = std::array::from_fn(|k| (direction[k] - f64::from(d[k])) as f32);
    let away: [f64; 3] = std::array::from_fn(|k| dd::ldexp(origin[k] - view.basis.e[k], -view.unit));
    let high = away.map(|x| x as f32);
    let low: [f32; 3] = std::array::from_fn(|k| (away[k] - f64::from(high[k])) as f32);
    let four = |a: [f32; 3], k: usize| [a[0], a[1], a[2], d_low[k]];
    RayRecord { direction: four(d, 0), origin: four(high, 1), origin_low: four(low, 2) }
}

/// The largest distance of an origin from the view's eye, in the frame's unit, rounded up.
pub(crate) fn farthest(rays: &[RayRecord]) -> f64 {
    let square = |r: &RayRecord| r.origin[..3].iter().map(|x| f64::from(*x) * f64::from(*x)).sum::<f64>();
    rays.par_iter().map(square).reduce(|| 0.0, f64::max).sqrt() * (1.0 + f64::from(f32::EPSILON))
}
