//! Certified answers of given rays on a device: f32 decides what is hit, docs/certificate.md, section 9. t and the normal
//! of a hit come from f64, and so do the answers to rays that f32 leaves unsure.

use crate::answers::raw::Raw;
use crate::cpu::given_certified::{Given, Query};
use crate::frame::report::Timings;
use crate::gpu::Gpu;
use crate::gpu::input::{Input, KernelRays, Output};
use crate::kernel::{Kernel, Task};
use crate::search::tree::device_rays::{BoxRayRecord, CertifiedRayRecord};
use crate::view::View;
use crate::view::ray::{NONE, UNSURE};
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::progress::Watch;

/// The state of a tracer's work on a device.
#[derive(Debug, Default)]
pub(in crate::render) struct OnDevice {
    /// The number of the upload of its tree; `None` before.
    uploaded: Option<u64>,
    /// The number of rays so far that f32 left unsure.
    pub(super) refined: u64,
}

impl OnDevice {
    /// The answers to the rays with these numbers.
    pub(super) fn answers<Q: Query>(
        &mut self,
        gpu: &mut Gpu,
        given: &Given<'_>,
        numbers: &[u32],
        watch: &Watch,
    ) -> Result<Vec<Q>> {
        let both = parallel::values(numbers.len(), CHEAP, |n| device_ray(given, numbers[n]));
        let boxes = parallel::map(&both, |(_, ray)| *ray);
        let rays = parallel::map(&both, |(record, _)| record.unwrap_or(CertifiedRayRecord::NOTHING));
        // Frames of translucent spheres have two trees, which take turns.
        let (nodes, spheres) = match self.uploaded == Some(gpu.trees_uploaded) {
            true => (Vec::new(), Vec::new()),
            false => (given.tree.device_nodes(), given.tree.device_spheres()),
        };
        let kernel = Kernel::bare(Task::Given { any: Q::ANY, tree: !given.all });
        let mut view = View::along_axes(DVec3::ZERO, &[], &[])?;
        view.record.spheres = given.tree.ids.len() as u32;
        let input = Input {
            view: &view,
            colors: None,
            rays: KernelRays::Certified { rays: &rays, boxes: &boxes, nodes: &nodes, spheres: &spheres },
        };
        let mut raw = Raw::new(&kernel, rays.len(), &Pool::default())?;
        let mut output = Output { raw: &mut raw, timings: &mut Timings::default() };
        gpu.run(&kernel, &input, &mut output, &|_| watch.goes_on())?;
        if !spheres.is_empty() {
            gpu.trees_uploaded += 1;
            self.uploaded = Some(gpu.trees_uploaded);
        }
        let decide = |k: usize| match (raw.id[k], both[k].0) {
            (UNSURE, _) | (_, None) => Q::UNSURE,
            (NONE, _) => Q::NONE,
            (place, _) => Q::hit(given, &given.rays.ray(numbers[k] as usize), place as usize),
        };
        let mut answers = parallel::values(numbers.len(), CHEAP, decide);
        let left: Vec<u32> =
            answers.iter().zip(numbers).filter_map(|(answer, &n)| (*answer == Q::UNSURE).then_some(n)).collect();
        self.refined += left.len() as u64;
        let again = given.each(&left);
        let unsure = answers.iter_mut().filter(|answer| **answer == Q::UNSURE);
        unsure.zip(again).for_each(|(answer, again)| *answer = again);
        Ok(answers)
    }
}

/// A ray for the kernel, without its record if f32 cannot decide it, and as the boxes see it.
fn device_ray(given: &Given<'_>, n: u32) -> (Option<CertifiedRayRecord>, BoxRayRecord) {
    let Some((ray, boxes)) = given.ray(&given.rays.ray(n as usize)) else {
        return (Some(CertifiedRayRecord::NOTHING), BoxRayRecord::new(None));
    };
    match CertifiedRayRecord::new(ray.placed(), ray.direction, ray.limit, &boxes) {
        Some(record) => (Some(record), BoxRayRecord::new(Some(boxes))),
        None => (None, BoxRayRecord::new(None)),
    }
}
