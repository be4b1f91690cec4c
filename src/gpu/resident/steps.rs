//! The dispatches of a resident frame.

use super::MINIMA;
use super::held::{Block, Counts, Held, pieces};
use crate::certify::projected::{ProjectedDetailRecord, ProjectedRecord};
use crate::certify::tiles::{NOTHING, Placed};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::gpu::compose::{Step, compose_step};
use crate::gpu::dispatch::Pipeline;
use crate::gpu::input::GROUP;
use crate::gpu::layout::Binding;
use crate::gpu::sizes::{HOST_SPHERES, PAIRS, PIECES, SUMMARY_HOST, SUMMARY_LIST, SUMMARY_PAIRS};
use crate::gpu::submit::READING;
use crate::kernel::{Kernel, KernelOutput};
use bytemuck::{Pod, Zeroable};
use naga::valid::Capabilities;

/// A block of spheres in one dispatch, declared in shaders/place/placing.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub(crate) struct BlockPass {
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) mode: u32,
    pub(crate) pieces: u32,
    pub(crate) groups: u32,
    pub(crate) unused_a: u32,
    pub(crate) unused_b: u32,
    pub(crate) unused_c: u32,
}

/// The passes of shaders/splat.
const LEAST: u32 = 0;
const SLOTS: u32 = 1;
const PAIRS_OF_UNSURE: u32 = 2;

/// Spheres for the host, and pairs, that come back with the submission that counts them.
const FIRST: u32 = 1 << 12;

/// Bytes of the summary before its list.
const HEAD: u64 = 4 * SUMMARY_LIST as u64;

/// A dispatch: a pipeline, what it binds of a block, and its workgroups.
struct Job<'a> {
    step: Step,
    block: &'a Block,
    /// The place of its part in the buffer of parts.
    part: u64,
    groups: (u32, u32),
}

/// Columns and rows of at least so many workgroups.
pub(super) fn spread(groups: u32, most: u32) -> (u32, u32) {
    let columns = groups.clamp(1, most);
    (columns, groups.div_ceil(columns).max(1))
}

impl Gpu {
    /// Runs the kernel that places every block.
    pub(super) fn place_blocks(&mut self, held: &Held) -> Result<Counts> {
        let blocks: Vec<&Block> = held.blocks.iter().filter(|block| block.spheres.is_some()).collect();
        let mut head = [0u32; SUMMARY_LIST as usize];
        // No depth yet: the least above the largest.
        (head[0], head[2]) = (u32::MAX, u32::MAX);
        self.reserve_summary();
        self.open.queue.write_buffer(&self.buffers["summary"], 0, bytemuck::cast_slice(&head));
        let numbers = self.summarize(&blocks, Step::Place)?;
        Ok(Counts::new(&numbers))
    }

    /// Cuts the large ones of the spheres that the host placed; the number of pieces of all.
    pub(super) fn cut_guests(&mut self, block: &Block) -> Result<u64> {
        Ok(pieces(&self.summarize(&[block], Step::Guests)?))
    }

    fn reserve_summary(&mut self) {
        let size = 4 * u64::from(SUMMARY_LIST + HOST_SPHERES);
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        self.reserve("summary", size, storage);
        self.reserve("read summary", size, READING);
        self.reserve("pieces", 8 * u64::from(PIECES), wgpu::BufferUsages::STORAGE);
        self.reserve("pairs", 8 * u64::from(PAIRS), wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    }

    /// Runs a step for some blocks and reads the summary.
    fn summarize(&mut self, blocks: &[&Block], step: Step) -> Result<Vec<u32>> {
        self.step(step)?;
        let most = self.limits.max_compute_workgroups_per_dimension;
        let mut jobs = Vec::new();
        let mut parts = Vec::new();
        for block in blocks {
            let groups = spread(block.count.div_ceil(GROUP), most);
            jobs.push(Job { step, block, part: parts.len() as u64, groups });
            parts.push(block.part(0, 0, groups.0));
        }
        self.fill_of_parts(&parts)?;
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        {
            let mut pass = self.pass(&mut encoder);
            self.encode(&mut pass, &jobs, &Kernel::certified(), 1);
        }
        let size = |host: u32| 4 * u64::from(SUMMARY_LIST + host);
        let copy = |gpu: &Self, encoder: &mut wgpu::CommandEncoder, host: u32| {
            let [from, to] = ["summary", "read summary"].map(|name| &gpu.buffers[name]);
            encoder.copy_buffer_to_buffer(from, 0, to, 0, size(host));
        };
        copy(self, &mut encoder, FIRST);
        let numbers = self.fetch(encoder, true, "read summary", size(FIRST))?;
        let host = numbers[SUMMARY_HOST as usize].min(HOST_SPHERES);
        if host <= FIRST {
            return Ok(numbers);
        }
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        copy(self, &mut encoder, host);
        self.fetch(encoder, false, "read summary", size(host))
    }

    /// Both passes of minima, the kernel that certifies, and the pass that finds the spheres of pixels that are not proved.
    pub(super) fn submit_steps(
        &mut self,
        kernel: &Kernel,
        held: &Held,
        pixels: u64,
        tiles: [[u32; 2]; 2],
    ) -> Result<()> {
        let (mut jobs, mut parts) = (Vec::new(), Vec::new());
        for mode in [LEAST, SLOTS] {
            self.splats(kernel, held, mode, &mut jobs, &mut parts);
        }
        let minima = jobs.len();
        self.splats(kernel, held, PAIRS_OF_UNSURE, &mut jobs, &mut parts);
        let firsts: Vec<u64> = held
            .blocks
            .iter()
            .map(|block| {
                parts.push(block.part(0, 0, 0));
                parts.len() as u64 - 1
            })
            .collect();
        self.fill_of_parts(&parts)?;
        self.reserve("read pairs", 8 * u64::from(FIRST), READING);
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.buffers["minima"], 0, Some(MINIMA * pixels));
        encoder.clear_buffer(&self.buffers["summary"], 4 * u64::from(SUMMARY_PAIRS), Some(4));
        {
            let mut pass = self.pass(&mut encoder);
            self.encode(&mut pass, &jobs[..minima], kernel, pixels);
            let [columns, rows] = tiles.map(|[first, last]| last - first + 1);
            let Pipeline { compute, bindings, .. } = &self.pipelines[kernel];
            pass.set_pipeline(compute);
            for (block, part) in held.blocks.iter().zip(firsts) {
                pass.set_bind_group(0, &self.group(compute, bindings, (block, part), kernel, pixels), &[]);
                pass.dispatch_workgroups(columns, rows, 1);
            }
            self.encode(&mut pass, &jobs[minima..], kernel, pixels);
        }
        for output in KernelOutput::of(kernel).filter(|_| !self.direct) {
            let (from, to) = (&self.buffers[output.name], &self.buffers[output.staging]);
            encoder.copy_buffer_to_buffer(from, 0, to, 0, pixels * output.bytes());
        }
        let counted = [("summary", "read summary", HEAD), ("pairs", "read pairs", 8 * u64::from(FIRST))];
        for (from, to, size) in counted {
            encoder.copy_buffer_to_buffer(&self.buffers[from], 0, &self.buffers[to], 0, size);
        }
        self.finish(encoder, true, |gpu| {
            gpu.ask(kernel, pixels);
            for (_, name, size) in counted {
                gpu.buffers[name].map_async(wgpu::MapMode::Read, 0..size, |_| {});
            }
        })
    }

    /// The spheres at pixels that are not proved, after [`Gpu::submit_steps`]: pixel and slot; `None` where there are too many.
    pub(super) fn take_pairs(&mut self) -> Result<Option<Vec<[u32; 2]>>> {
        let count = self.take("read summary", HEAD)?[SUMMARY_PAIRS as usize];
        let mut numbers = self.take("read pairs", 8 * u64::from(FIRST))?;
        if count > PAIRS {
            return Ok(None);
        }
        if count > FIRST {
            let size = 8 * u64::from(count);
            self.reserve("read pairs", size, READING);
            let mut encoder = self.open.device.create_command_encoder(&Default::default());
            encoder.copy_buffer_to_buffer(&self.buffers["pairs"], 0, &self.buffers["read pairs"], 0, size);
            numbers = self.fetch(encoder, false, "read pairs", size)?;
        }
        Ok(Some(numbers.chunks_exact(2).take(count as usize).map(|pair| [pair[0], pair[1]]).collect()))
    }

    /// The dispatches of a pass of all spheres over the pixels.
    fn splats<'a>(
        &self,
        kernel: &Kernel,
        held: &'a Held,
        mode: u32,
        jobs: &mut Vec<Job<'a>>,
        parts: &mut Vec<BlockPass>,
    ) {
        let most = self.limits.max_compute_workgroups_per_dimension;
        let samples = kernel.samples;
        #[cfg(test)]
        let first = jobs.len();
        for block in &held.blocks {
            let groups = spread(block.count.div_ceil(GROUP), most);
            jobs.push(Job { step: Step::Small { samples }, block, part: parts.len() as u64, groups });
            parts.push(block.part(mode, 0, groups.0));
            if held.pieces > 0 {
                let groups = spread(held.pieces, most);
                jobs.push(Job { step: Step::Large { samples }, block, part: parts.len() as u64, groups });
                parts.push(block.part(mode, held.pieces, groups.0));
            }
        }
        #[cfg(test)]
        if self.resident.reversed {
            jobs[first..].reverse();
        }
    }

    /// Compiles a step.
    pub(super) fn step(&mut self, step: Step) -> Result<()> {
        if !self.resident.steps.0.contains_key(&step) {
            let made = self.built(&compose_step(step), Capabilities::empty(), "resident")?;
            self.resident.steps.0.insert(step, made);
        }
        Ok(())
    }

    /// Bytes between the parts of different dispatches in their buffer.
    fn stride(&self) -> u64 {
        (size_of::<BlockPass>() as u64).next_multiple_of(self.limits.min_uniform_buffer_offset_alignment.into())
    }

    fn fill_of_parts(&mut self, parts: &[BlockPass]) -> Result<()> {
        let stride = self.stride() as usize;
        let mut bytes = vec![0; parts.len() * stride];
        for (to, part) in bytes.chunks_exact_mut(stride).zip(parts) {
            to[..size_of::<BlockPass>()].copy_from_slice(bytemuck::bytes_of(part));
        }
        self.refill("block_pass", &bytes)
    }

    /// A pass that the clock times.
    fn pass<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::ComputePass<'a> {
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes: self.times() })
    }

    fn encode(&self, pass: &mut wgpu::ComputePass<'_>, jobs: &[Job<'_>], kernel: &Kernel, pixels: u64) {
        for job in jobs {
            let (pipeline, bindings) = &self.resident.steps.0[&job.step];
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &self.group(pipeline, bindings, (job.block, job.part), kernel, pixels), &[]);
            pass.dispatch_workgroups(job.groups.0, job.groups.1, 1);
        }
    }

    /// What a pipeline binds of a block and its part.
    fn group(
        &self,
        pipeline: &wgpu::ComputePipeline,
        bindings: &[Binding],
        (block, part): (&Block, u64),
        kernel: &Kernel,
        pixels: u64,
    ) -> wgpu::BindGroup {
        let layout = pipeline.get_bind_group_layout(0);
        let entries: Vec<_> = bindings.iter().map(|b| self.entry(b, block, part, kernel, pixels)).collect();
        let group = wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries };
        self.open.device.create_bind_group(&group)
    }

    fn entry<'a>(
        &'a self,
        binding: &Binding,
        block: &'a Block,
        part: u64,
        kernel: &Kernel,
        pixels: u64,
    ) -> wgpu::BindGroupEntry<'a> {
        let resource = match (binding.name, &block.spheres) {
            ("projected", _) => block.projected.as_entire_binding(),
            ("resident", Some(spheres)) => spheres.as_entire_binding(),
            ("block_pass", _) => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &self.buffers["block_pass"],
                offset: part * self.stride(),
                size: std::num::NonZeroU64::new(size_of::<BlockPass>() as u64),
            }),
            (name, _) => self.bound(name, kernel, pixels),
        };
        wgpu::BindGroupEntry { binding: binding.binding, resource }
    }

    /// The records of a block.
    pub(super) fn records_of(&mut self, block: &Block) -> Result<Vec<Option<Placed>>> {
        let (size, count) = (block.projected.size(), block.count as usize);
        self.reserve("read records", size, READING);
        let mut encoder = self.open.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&block.projected, 0, &self.buffers["read records"], 0, size);
        let bytes: Vec<u8> = bytemuck::cast_slice(&self.fetch(encoder, false, "read records", size)?).to_vec();
        let (records, rest) = bytes.split_at(count * size_of::<ProjectedRecord>());
        let (details, depths) = rest.split_at(count * size_of::<ProjectedDetailRecord>());
        let records: Vec<ProjectedRecord> = bytemuck::pod_collect_to_vec(records);
        let details: Vec<ProjectedDetailRecord> = bytemuck::pod_collect_to_vec(details);
        let depths: Vec<f64> = bytemuck::pod_collect_to_vec(&depths[..count * size_of::<f64>()]);
        let one = |((record, detail), depth): ((ProjectedRecord, ProjectedDetailRecord), f64)| {
            // The sign says that the sphere is cut into pieces.
            let record = ProjectedRecord { rho: record.rho.abs(), ..record };
            (record.x != NOTHING.x).then_some(Placed { record, detail, depth })
        };
        Ok(records.into_iter().zip(details).zip(depths).map(one).collect())
    }
}

impl Block {
    fn part(&self, mode: u32, pieces: u32, groups: u32) -> BlockPass {
        BlockPass { first: self.first, count: self.count, mode, pieces, groups, unused_a: 0, unused_b: 0, unused_c: 0 }
    }
}
