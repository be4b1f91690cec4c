//! Given rays by one method, uncertified.
//!
//! Rays that share an origin are traced with the spheres moved there in f64, like viewing rays. Rays from many points
//! carry their origins as a high and a low f32 part, and so do the centres: the kernel subtracts high from high and low
//! from low. Rays are grouped by origin where the groups are large enough to pay for moving the spheres.

use super::{Hits, Rays, Tracer};
use crate::answers::raw::Raw;
use crate::frame::report::Timings;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::kernel::{Kernel, RaySource, Task};
use crate::view::View;
use crate::view::ray::{NONE, RayRecord};
use crate::{cpu, double_double as dd};
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::parallel;
use std::collections::HashMap;

/// A smaller group does not pay for moving the spheres: its rays fill one workgroup.
const GROUP_MIN_RAYS: usize = 64;

impl Tracer<'_> {
    /// The closest hit of each ray among all spheres by the plan's method.
    pub(super) fn hits_by_method(&mut self, rays: &Rays) -> Result<Hits> {
        let (spheres, kernel) = (self.spheres, self.plan.kernel);
        let method = kernel.arithmetic();
        let directions = rays.directions;
        let origin = |n: usize| rays.ray(n).origin;
        let mut hits = Hits { certainty: vec![255; rays.len()], ..self.misses(rays.len()) };
        for group in groups(directions.len(), origin) {
            let kernel = Kernel { task: Task::Method { method, rays: group.kind }, ..kernel };
            let mut view = View::along_axes(group.eye, &spheres.centers, &spheres.radii)?;
            if kernel.reads_residuals() {
                view.keep_residuals(&spheres.centers, &spheres.radii);
            }
            let record = |&n: &u32| ray_record(&view, origin(n as usize), directions[n as usize]);
            let records = parallel::map(&group.rays, record);
            let mut raw = Raw::new(&kernel, records.len(), &self.renderer.pool)?;
            match &mut self.renderer.device.gpu {
                Some(gpu) => {
                    gpu.check_method(method)?;
                    let rays = KernelRays::Given(&records);
                    let input = Input { view: &view, colors: None, rays };
                    let mut output = Output { raw: &mut raw, timings: &mut Timings::default() };
                    gpu.run(&kernel, &input, &mut output, &|_| self.renderer.watch.goes_on())?;
                }
                None => cpu::render(&kernel, &view, Some(&records), None, &mut raw, &|| true),
            }
            let there = |k: usize| {
                let d = directions[group.rays[k] as usize];
                let t = dd::ldexp(raw.t(k), view.unit - scale(d));
                (t, t * DVec3::from_array(d).length())
            };
            let there = parallel::from_fn(group.rays.len(), there);
            for (k, (&n, (t, distance))) in group.rays.iter().zip(there).enumerate() {
                let n = n as usize;
                if raw.id[k] == NONE || t >= rays.ray(n).limit {
                    continue;
                }
                (hits.id[n], hits.t[n], hits.distance[n]) = (raw.id[k] as i32, t, distance);
                if let Some(bound) = &mut hits.bound {
                    bound[n] = f64::INFINITY;
                }
                if let Some(normal) = &mut hits.normal {
                    normal[n] = [raw.normal[3 * k], raw.normal[3 * k + 1], raw.normal[3 * k + 2]];
                }
            }
        }
        Ok(hits)
    }
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
    let pay = |groups: usize| groups == 1 || groups * GROUP_MIN_RAYS <= count;
    for n in 0..count {
        // Adding 0.0 makes -0.0 and 0.0 the same origin.
        by_origin.entry(origin(n).map(|x| (x + 0.0).to_bits())).or_default().push(n as u32);
        if !pay(by_origin.len()) {
            break;
        }
    }
    if pay(by_origin.len()) {
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
fn ray_record(view: &View, origin: [f64; 3], direction: [f64; 3]) -> RayRecord {
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
