//! Rays from the hits of a resident frame toward the sky and toward lights without a size: shaders/main/sky.wgsl,
//! docs/certificate.md, section 13.

use super::held::{Held, HeldTree, Starts};
use super::steps::spread;
use crate::answers::lit::Traced;
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::compose::Step;
use crate::gpu::device::AdapterSummary;
use crate::gpu::input::GROUP;
use crate::gpu::sizes::STEPS;
use crate::gpu::submit::READING;
use crate::gpu::texture::texture;
use crate::search::tree::Tree;
use crate::search::tree::device_rays::DirectionRecord;
use crate::view::{View, ViewRecord};
use bytemuck::{Pod, Zeroable};
use std::time::Instant;

/// The most rays of a pixel, which one invocation traces one after the other.
const MOST: u32 = 1 << 12;

/// The cost of a ray in ray-sphere tests, for the budget of submissions.
const PER_RAY: f64 = 128.0;

/// The rays of a pixel in a dispatch, and the steps through the tree of an invocation, beyond which the host traces the pixel.
struct Portion {
    rays: u32,
    steps: u32,
}

impl Portion {
    /// On hardware the steps end what would hang.
    fn of(summary: &AdapterSummary) -> Self {
        if summary.is_software() { Self { rays: 16, steps: STEPS } } else { Self { rays: 512, steps: 1 << 18 } }
    }
}

/// What is traced from the hits of the frame that was rendered last.
#[derive(Clone, Copy)]
pub(crate) struct SkyRays<'a> {
    /// Over the spheres that the device holds.
    pub(crate) tree: &'a Tree,
    /// Of the frame's pixels, in any unit.
    pub(crate) view: &'a View,
    /// Of every turn, and then of the lights.
    pub(crate) directions: &'a [DirectionRecord],
    /// Rays of a pixel toward the sky and toward lights.
    pub(crate) rays: u32,
    pub(crate) lights: u32,
    pub(crate) seed: u32,
    /// Only every second pixel, as on a chessboard.
    pub(crate) chessboard: bool,
    /// Limits of the rays toward the sky between which the exact one lies, in the tree's unit for these directions.
    pub(crate) limit: [f32; 2],
}

/// What a device finds of rays from the hits.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum SkyTraced {
    /// For each pixel the words of [`Traced`], a bit for each ray whose end nothing hides, and behind them one if the host has to
    /// trace the pixel's rays.
    Words(Vec<u32>),
    /// The last frame was not this one, or left no hits.
    NoHits,
    /// Why the device cannot trace.
    Refused(String),
}

/// Declared in shaders/main/sky.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct SkyRecord {
    pub(crate) first: u32,
    pub(crate) end: u32,
    pub(crate) rays: u32,
    pub(crate) lights: u32,
    pub(crate) turns: u32,
    pub(crate) seed: u32,
    pub(crate) chessboard: u32,
    pub(crate) groups: u32,
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
        self.rays + self.lights
    }
}

/// The window and the sample of a view.
fn window(record: &ViewRecord) -> [u32; 6] {
    [record.first_row, record.rows, record.first_column, record.columns, record.strata, record.sample]
}

impl Gpu {
    /// Invalidates the hits of the last frame.
    pub(crate) fn forget_hits(&mut self) {
        self.resident.starts = None;
    }

    /// Traces rays from the hits of the last frame. `go_on` is called with the number of completed pixels.
    ///
    /// # Errors
    /// Those of the device, and [`Error::Interrupted`].
    pub(crate) fn trace_sky(&mut self, rays: &SkyRays<'_>, go_on: &dyn Fn(u64) -> bool) -> Result<SkyTraced> {
        let starts = match self.resident.starts {
            Some(Ok(starts)) if window(&starts.record) == window(&rays.view.record) => starts,
            Some(Err(reason)) => return Ok(SkyTraced::Refused(reason.to_owned())),
            _ => return Ok(SkyTraced::NoHits),
        };
        if rays.each() > MOST {
            return Ok(SkyTraced::Refused(format!("{} rays from each pixel, more than {MOST}", rays.each())));
        }
        let trace = |gpu: &mut Self, held: &mut Held| gpu.guarded(|gpu| gpu.trace_from(starts, held, rays, go_on));
        match self.with_held(trace) {
            Err(Error::Limits { problem, .. }) => Ok(SkyTraced::Refused(problem)),
            words => Ok(words?.map_or(SkyTraced::NoHits, SkyTraced::Words)),
        }
    }

    fn trace_from(
        &mut self,
        starts: Starts,
        held: &mut Held,
        asked: &SkyRays<'_>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<Vec<u32>> {
        if held.tree.is_none() {
            held.tree = Some(self.hold_tree(asked.tree)?);
        }
        self.step(Step::Sky)?;
        let pixels = asked.view.record.pixels() as u64;
        let bytes = 4 * pixels * Traced::words_of(asked.each() as usize) as u64;
        self.check_size("rays to the sky", bytes)?;
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        self.reserve("open", bytes, storage);
        self.reserve("read open", bytes, READING);
        self.refill("directions", bytemuck::cast_slice(asked.directions))?;
        let record = ViewRecord { spheres: asked.tree.ids.len() as u32, ..asked.view.record };
        self.refill("view", bytemuck::bytes_of(&record))?;
        let (unit, (eye, eye_rest)) = asked.tree.eye(asked.view, starts.unit).unwrap_or((0.0, ([0; 3], [0.0; 3])));
        let turned = asked.directions.len() as u32 - asked.lights;
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.buffers["open"], 0, Some(bytes));
        self.open.queue.submit([encoder.finish()]);
        let Portion { rays: together, steps } = Portion::of(&self.summary);
        let each = PER_RAY * f64::from(asked.each().min(together));
        let mut first = 0;
        while first < pixels {
            if !go_on(first) {
                return Err(Error::Interrupted);
            }
            let count = self.resident.sky.next(each * (pixels - first) as f64) / each;
            let end = (first + (count as u64).max(1)).min(pixels);
            let groups = ((end - first) as u32).div_ceil(GROUP);
            let groups = spread(groups, self.limits.max_compute_workgroups_per_dimension);
            for first_ray in (0..asked.each()).step_by(together as usize) {
                let end_ray = asked.each().min(first_ray + together);
                let part = SkyRecord {
                    first: first as u32,
                    end: end as u32,
                    rays: asked.rays,
                    lights: asked.lights,
                    turns: turned.checked_div(asked.rays).unwrap_or(1),
                    seed: asked.seed,
                    chessboard: asked.chessboard.into(),
                    groups: groups.0,
                    sure_limit: asked.limit[0],
                    limit: asked.limit[1],
                    unit,
                    steps,
                    eye,
                    first_ray,
                    eye_rest,
                    end_ray,
                };
                self.refill("sky", bytemuck::bytes_of(&part))?;
                let start = Instant::now();
                self.submit_sky(held, groups)?;
                let seconds = self.seconds(start);
                self.resident.sky.took(PER_RAY * f64::from(end_ray - first_ray) * (end - first) as f64, seconds);
            }
            first = end;
        }
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.buffers["open"], 0, &self.buffers["read open"], 0, bytes);
        self.fetch(encoder, false, "read open", bytes)
    }

    /// One dispatch.
    fn submit_sky(&mut self, held: &Held, groups: (u32, u32)) -> Result<()> {
        let (pipeline, bindings) = &self.resident.steps.0[&Step::Sky];
        let bound = |name: &'static str| match (&held.tree, name) {
            (Some(tree), "nodes") => wgpu::BindingResource::TextureView(&tree.nodes),
            (Some(tree), "placed") => wgpu::BindingResource::TextureView(&tree.placed),
            (Some(tree), "places") => tree.places.as_entire_binding(),
            _ => self.buffers[name].as_entire_binding(),
        };
        let entries: Vec<_> =
            bindings.iter().map(|b| wgpu::BindGroupEntry { binding: b.binding, resource: bound(b.name) }).collect();
        let encoder = self.record(pipeline, &entries, groups, self.times());
        self.finish(encoder, true, |_| {})
    }

    /// Sends a tree.
    fn hold_tree(&mut self, tree: &Tree) -> Result<HeldTree> {
        let mut places = vec![0u32; tree.ids.len()];
        (0..).zip(&tree.ids).for_each(|(place, id)| places[*id as usize] = place);
        let bytes: &[u8] = bytemuck::cast_slice(&places);
        self.check_size("places of spheres", bytes.len() as u64)?;
        let buffer = self.open.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("places"),
            size: (bytes.len() as u64).max(16),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.open.queue.write_buffer(&buffer, 0, bytes);
        let (nodes, spheres) = (tree.device_nodes(), tree.device_spheres());
        let mut view = |name, bytes: &[u8]| {
            self.traffic.up += bytes.len() as u64;
            texture(&self.open, &self.limits, &self.summary.name, name, bytes).map(|(_, view)| view)
        };
        let nodes = view("nodes", bytemuck::cast_slice(&nodes))?;
        let placed = view("placed", bytemuck::cast_slice(&spheres))?;
        self.traffic.up += bytes.len() as u64;
        Ok(HeldTree { nodes, placed, places: buffer })
    }
}
