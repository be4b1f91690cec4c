//! Rays from the hits of a resident frame toward the sky and toward lights without a size: shaders/main/sky.wgsl,
//! docs/certificate.md, section 13.

use super::scene::Starts;
use super::steps::spread;
use crate::answers::light::Traced;
use crate::gpu::Gpu;
use crate::gpu::compose::Step;
use crate::gpu::dispatch::Program;
use crate::gpu::input::GROUP;
use crate::gpu::sizes::STEPS;
use crate::search::tree::Tree;
use crate::search::tree::device_rays::DirectionRecord;
use crate::view::{View, ViewRecord};
use bytemuck::{Pod, Zeroable};
use halfline_ground::error::{Error, Result};
use web_time::Instant;

/// The most rays of a pixel, which one invocation traces one after the other.
const MAX_RAYS_PER_PIXEL: u32 = 1 << 12;

/// The cost of a ray in ray-sphere tests, for the budget of submissions.
const PER_RAY: f64 = 128.0;

const SKY: Program = Program::Step(Step::Sky);

/// The tree over the spheres that the device holds, as textures; given rays have another.
const NODES: &str = "nodes of hits";
pub(super) const SPHERES: &str = "spheres of hits";

/// A request for rays from the hits of the last frame toward the sky and lights.
#[derive(Clone, Copy)]
pub(crate) struct SkyRays<'a> {
    /// The tree over the spheres that the device holds.
    pub(crate) tree: &'a Tree,
    /// The view of the frame's pixels, in any unit.
    pub(crate) view: &'a View,
    /// The directions toward the sky in every turn of their lattice, then those toward the lights.
    pub(crate) directions: &'a [DirectionRecord],
    /// The parameters, but for the numbers of dispatches, of turns and of the eye, which [`Gpu`] fills in.
    pub(crate) record: SkyRecord,
}

/// The result of tracing rays from the hits on a device.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum SkyTraced<T> {
    Traced(T),
    /// The last frame was not this one, or left no hits.
    NoHits,
    /// The reason why the device cannot trace.
    Refused(String),
}

/// Declared in shaders/main/sky.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct SkyRecord {
    pub(crate) first: u32,
    pub(crate) end: u32,
    /// Rays of a pixel toward the sky and toward lights.
    pub(crate) rays: u32,
    pub(crate) lights: u32,
    pub(crate) turns: u32,
    pub(crate) seed: u32,
    /// 1 where the place of a pixel chooses its turn, 0 where a hash does.
    pub(crate) interleaved: u32,
    pub(crate) groups: u32,
    /// Bounds below and above the exact limit of rays toward the sky, in the tree's unit for these directions.
    pub(crate) sure_limit: f32,
    pub(crate) limit: f32,
    pub(crate) unit: f32,
    pub(crate) steps: u32,
    pub(crate) eye: [i32; 3],
    pub(crate) first_ray: u32,
    pub(crate) eye_rest: [f32; 3],
    pub(crate) end_ray: u32,
}

impl SkyRays<'_> {
    /// Rays of a pixel.
    fn each(&self) -> u32 {
        self.record.rays + self.record.lights
    }
}

/// The window and the sample of a view.
fn window(record: &ViewRecord) -> [u32; 6] {
    [record.first_row, record.rows, record.first_column, record.columns, record.strata, record.sample]
}

impl Gpu {
    /// Invalidates the hits of the last frame.
    pub(crate) fn forget_hits(&mut self) {
        self.starts = None;
    }

    /// Traces rays from the hits of the last frame: for each pixel the words of [`Traced`], a bit for each ray whose end nothing
    /// hides, and behind them one if the host has to trace the pixel's rays. `go_on` is called with the number of completed pixels.
    ///
    /// # Errors
    /// Errors of the device, and [`Error::Interrupted`].
    pub(crate) fn trace_sky(&mut self, rays: &SkyRays<'_>, go_on: &dyn Fn(u64) -> bool) -> Result<SkyTraced<Vec<u32>>> {
        self.trace_hits(rays, go_on, |gpu, bytes| gpu.fetch(gpu.encoder(), false, "open", bytes))
    }

    /// Traces rays from the hits of the last frame, and takes the answers, which are so many bytes on the device, by `take`.
    pub(super) fn trace_hits<T>(
        &mut self,
        rays: &SkyRays<'_>,
        go_on: &dyn Fn(u64) -> bool,
        take: impl FnOnce(&mut Self, u64) -> Result<T>,
    ) -> Result<SkyTraced<T>> {
        let is_of = |starts: &Starts| window(&starts.record) == window(&rays.view.record);
        let starts = match self.starts {
            Some(Ok(starts)) if self.resident.is_some() && is_of(&starts) => starts,
            Some(Err(reason)) => return Ok(SkyTraced::Refused(reason.to_owned())),
            _ => return Ok(SkyTraced::NoHits),
        };
        if rays.each() > MAX_RAYS_PER_PIXEL {
            return Ok(SkyTraced::Refused(format!(
                "{} rays from each pixel, more than {MAX_RAYS_PER_PIXEL}",
                rays.each()
            )));
        }
        let (least, tree) = (self.room.least, rays.tree.ids.len());
        if tree >= self.room.tree {
            return Ok(SkyTraced::Refused(self.exhausted()));
        }
        match self.guarded(|gpu| gpu.trace_from(starts, rays, go_on).and_then(|bytes| take(gpu, bytes))) {
            Err(Error::Limits { problem, .. }) => {
                if self.room.is_exhausted() {
                    // The frame without these rays has room.
                    (self.room.least, self.room.tree) = (least, tree);
                }
                Ok(SkyTraced::Refused(problem))
            }
            traced => traced.map(SkyTraced::Traced),
        }
    }

    /// The number of bytes of the answers.
    fn trace_from(&mut self, starts: Starts, rays: &SkyRays<'_>, go_on: &dyn Fn(u64) -> bool) -> Result<u64> {
        self.hold_tree(rays.tree)?;
        self.compile(SKY)?;
        let pixels = rays.view.record.pixels() as u64;
        let bytes = 4 * pixels * Traced::words_of(rays.each() as usize) as u64;
        self.check_size("rays to the sky", bytes)?;
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        self.reserve("open", bytes, storage);
        self.refill("directions", bytemuck::cast_slice(rays.directions))?;
        let record = ViewRecord { spheres: rays.tree.ids.len() as u32, ..rays.view.record };
        self.refill("view", bytemuck::bytes_of(&record))?;
        let (unit, (eye, eye_rest)) = rays.tree.eye(rays.view, starts.unit).unwrap_or((0.0, ([0; 3], [0.0; 3])));
        let turned = rays.directions.len() as u32 - rays.record.lights;
        let turns = turned.checked_div(rays.record.rays).unwrap_or(1);
        let mut encoder = self.encoder();
        encoder.clear_buffer(&self.buffers["open"], 0, Some(bytes));
        self.open.queue.submit([encoder.finish()]);
        // The rays of a pixel in a dispatch, and the steps through the tree of an invocation, beyond which the host traces the pixel:
        // on hardware they end what would hang.
        let (together, steps) = if self.summary.is_software() { (16, STEPS) } else { (512, 1 << 18) };
        let record = SkyRecord { turns, unit, steps, eye, eye_rest, ..rays.record };
        let each = PER_RAY * f64::from(rays.each().min(together));
        let mut first = 0;
        while first < pixels {
            if !go_on(first) {
                return Err(Error::Interrupted);
            }
            let count = self.programs[&SKY].budget.next(each * (pixels - first) as f64) / each;
            let end = (first + (count as u64).max(1)).min(pixels);
            let groups = ((end - first) as u32).div_ceil(GROUP);
            let groups = spread(groups, self.limits.max_compute_workgroups_per_dimension);
            for first_ray in (0..rays.each()).step_by(together as usize) {
                let end_ray = rays.each().min(first_ray + together);
                let (from, to) = (first as u32, end as u32);
                let part = SkyRecord { first: from, end: to, groups: groups.0, first_ray, end_ray, ..record };
                self.refill("sky", bytemuck::bytes_of(&part))?;
                let start = Instant::now();
                self.submit_sky(groups)?;
                let seconds = self.seconds(start);
                if let Some(pipeline) = self.programs.get_mut(&SKY) {
                    pipeline.budget.took(PER_RAY * f64::from(end_ray - first_ray) * (end - first) as f64, seconds);
                }
            }
            first = end;
        }
        Ok(bytes)
    }

    /// One dispatch.
    fn submit_sky(&mut self, groups: (u32, u32)) -> Result<()> {
        let bound = |name| match name {
            "nodes" => self.bound(NODES, None),
            "placed" => self.bound(SPHERES, None),
            _ => self.bound(name, None),
        };
        let mut encoder = self.encoder();
        self.dispatch(&mut self.pass(&mut encoder), &self.programs[&SKY], bound, groups);
        self.finish(encoder, true, |_| {})
    }

    /// Sends a tree, unless it is there.
    fn hold_tree(&mut self, tree: &Tree) -> Result<()> {
        if self.textures.contains_key(SPHERES) {
            return Ok(());
        }
        let mut places = vec![0u32; tree.ids.len()];
        (0..).zip(&tree.ids).for_each(|(place, id)| places[*id as usize] = place);
        self.fill("places", bytemuck::cast_slice(&places))?;
        self.fill_texture(NODES, bytemuck::cast_slice(&tree.device_nodes()))?;
        self.fill_texture(SPHERES, bytemuck::cast_slice(&tree.device_spheres()))
    }

    /// Drops the tree of other spheres.
    pub(super) fn forget_tree(&mut self) {
        self.buffers.remove("places");
        for name in [NODES, SPHERES] {
            self.textures.remove(name);
        }
    }
}
