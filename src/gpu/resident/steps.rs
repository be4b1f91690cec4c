//! The dispatches of a resident frame.

use super::minima;
use super::scene::{Block, Counts, ResidentScene, pieces};
use crate::certify::projected::{ProjectedDetailRecord, ProjectedRecord};
use crate::certify::tiles::{NOTHING, Placed};
use crate::gpu::Gpu;
use crate::gpu::compose::Step;
use crate::gpu::dispatch::Program;
use crate::gpu::input::GROUP;
use crate::gpu::sizes::{
    HOST_SPHERES, LEAST, PAIRS, PAIRS_OF_UNSURE, PIECES, SLOTS, SUMMARY_HOST, SUMMARY_LIST, SUMMARY_MISSED,
    SUMMARY_PAIRS,
};
use crate::kernel::Kernel;
use crate::view::ViewRecord;
use bytemuck::{Pod, Zeroable};
use halfline_ground::error::Result;
use std::num::NonZeroU64;

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

/// The most spheres for the host, and the most pairs, that are read back together with their numbers; more of them take
/// one more submission.
const FIRST: u32 = 1 << 12;

/// Bytes of the summary before its list.
const HEAD: u64 = 4 * SUMMARY_LIST as u64;

/// A dispatch for a block.
struct Job<'a> {
    program: Program,
    block: &'a Block,
    pass: BlockPass,
    groups: (u32, u32),
}

/// Columns and rows of at least so many workgroups.
pub(super) fn spread(groups: u32, most: u32) -> (u32, u32) {
    let columns = groups.clamp(1, most);
    (columns, groups.div_ceil(columns).max(1))
}

impl Gpu {
    /// Runs the kernel that places every block.
    pub(super) fn place_blocks(&mut self, resident: &ResidentScene) -> Result<Counts> {
        let mut head = [0u32; SUMMARY_LIST as usize];
        // No depth yet: the least above the largest. No sphere aside.
        (head[0], head[2], head[SUMMARY_MISSED as usize]) = (u32::MAX, u32::MAX, u32::MAX);
        self.reserve_summary();
        self.open.queue.write_buffer(&self.buffers["summary"], 0, bytemuck::cast_slice(&head));
        let blocks = resident.blocks.iter().filter(|block| block.spheres.is_some());
        Ok(Counts::new(&self.summarize(blocks, Step::Place)?))
    }

    /// Cuts the large spheres among those that the host placed; returns the number of pieces of all spheres.
    pub(super) fn cut_guests(&mut self, block: &Block) -> Result<u64> {
        Ok(pieces(&self.summarize([block], Step::Guests)?))
    }

    fn reserve_summary(&mut self) {
        let size = 4 * u64::from(SUMMARY_LIST + HOST_SPHERES);
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        self.reserve("summary", size, storage);
        self.reserve("pieces", 8 * u64::from(PIECES), wgpu::BufferUsages::STORAGE);
        self.reserve("pairs", 8 * u64::from(PAIRS), wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    }

    /// Runs a step for some blocks and reads the summary.
    fn summarize<'a>(&mut self, blocks: impl IntoIterator<Item = &'a Block>, step: Step) -> Result<Vec<u32>> {
        let program = Program::Step(step);
        self.compile(program)?;
        let most = self.limits.max_compute_workgroups_per_dimension;
        let jobs: Vec<_> = blocks.into_iter().map(|block| block.job(program, 0, 0, most)).collect();
        let mut encoder = self.encoder();
        self.encode(&mut encoder, &jobs, None)?;
        let size = |host: u32| 4 * u64::from(SUMMARY_LIST + host);
        let numbers = self.fetch(encoder, true, "summary", size(FIRST))?;
        let host = numbers[SUMMARY_HOST as usize].min(HOST_SPHERES);
        if host <= FIRST {
            return Ok(numbers);
        }
        self.fetch(self.encoder(), false, "summary", size(host))
    }

    /// Both passes of minima, the kernel that certifies, and the pass that finds the spheres of pixels that are not proved.
    pub(super) fn submit_steps(
        &mut self,
        kernel: &Kernel,
        resident: &ResidentScene,
        record: &ViewRecord,
        reads: bool,
    ) -> Result<()> {
        let pixels = record.pixels() as u64;
        let [columns, rows] = record.tiles().map(|[first, last]| last - first + 1);
        let of_tiles = |program, block| Job { program, block, pass: block.pass(0, 0, 0), groups: (columns, rows) };
        let mut jobs = self.splats(kernel, resident, LEAST);
        jobs.extend(self.splats(kernel, resident, SLOTS));
        jobs.extend(resident.blocks.iter().map(|block| of_tiles(Program::Kernel(*kernel), block)));
        jobs.extend(self.splats(kernel, resident, PAIRS_OF_UNSURE));
        let unsure = resident.blocks.first().filter(|_| !reads);
        jobs.extend(unsure.map(|block| of_tiles(Program::Step(Step::Unsure), block)));
        let mut encoder = self.encoder();
        encoder.clear_buffer(&self.buffers["minima"], 0, Some(minima(kernel) * pixels));
        encoder.clear_buffer(&self.buffers["summary"], 4 * u64::from(SUMMARY_PAIRS), Some(4));
        self.encode(&mut encoder, &jobs, Some((kernel, pixels)))?;
        if !reads {
            return self.finish_pairs(encoder, |_| {});
        }
        self.copy_outputs(&mut encoder, kernel, pixels);
        self.finish_pairs(encoder, |gpu| gpu.ask_outputs(kernel, pixels))
    }

    /// Submits commands that end with a list of pairs, and waits for both.
    pub(super) fn finish_pairs(&mut self, mut encoder: wgpu::CommandEncoder, ask: impl FnOnce(&Self)) -> Result<()> {
        let counted = [("summary", HEAD), ("pairs", 8 * u64::from(FIRST))];
        for (name, size) in counted {
            self.copy(&mut encoder, name, size);
        }
        self.finish(encoder, true, |gpu| {
            ask(gpu);
            counted.iter().for_each(|(name, size)| gpu.ask(name, *size));
        })
    }

    /// The pairs of an unproved pixel and a sphere's slot, after [`Gpu::finish_pairs`]; `None` where there are too
    /// many.
    pub(super) fn take_pairs(&mut self) -> Result<Option<Vec<[u32; 2]>>> {
        let count = self.take("summary", HEAD)?[SUMMARY_PAIRS as usize];
        let mut numbers = self.take("pairs", 8 * u64::from(FIRST))?;
        if count > PAIRS {
            return Ok(None);
        }
        if count > FIRST {
            numbers = self.fetch(self.encoder(), false, "pairs", 8 * u64::from(count))?;
        }
        Ok(Some(numbers.chunks_exact(2).take(count as usize).map(|pair| [pair[0], pair[1]]).collect()))
    }

    /// The dispatches of a pass of all spheres over the pixels.
    fn splats<'a>(&self, kernel: &Kernel, resident: &'a ResidentScene, mode: u32) -> Vec<Job<'a>> {
        let most = self.limits.max_compute_workgroups_per_dimension;
        let (samples, planes) = (kernel.samples, kernel.has_planes());
        let [small, large] = [Step::Small { samples, planes }, Step::Large { samples, planes }].map(Program::Step);
        let mut jobs = Vec::new();
        for block in &resident.blocks {
            jobs.push(block.job(small, mode, 0, most));
            if resident.pieces > 0 {
                jobs.push(block.job(large, mode, resident.pieces, most));
            }
        }
        #[cfg(test)]
        if self.reversed {
            jobs.reverse();
        }
        jobs
    }

    /// Adds a pass of these dispatches; `outputs` as of [`Gpu::bound`].
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        jobs: &[Job<'_>],
        outputs: Option<(&Kernel, u64)>,
    ) -> Result<()> {
        let size = size_of::<BlockPass>();
        let stride = size.next_multiple_of(self.limits.min_uniform_buffer_offset_alignment as usize);
        let mut bytes = vec![0; jobs.len() * stride];
        for (to, job) in bytes.chunks_exact_mut(stride).zip(jobs) {
            to[..size].copy_from_slice(bytemuck::bytes_of(&job.pass));
        }
        self.refill("block_pass", &bytes)?;
        let mut pass = self.pass(encoder);
        for (n, Job { program, block, groups, .. }) in jobs.iter().enumerate() {
            let bound = |name| match (name, &block.spheres) {
                ("projected", _) => block.projected.as_entire_binding(),
                ("resident", Some(spheres)) => spheres.as_entire_binding(),
                ("block_pass", _) => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &self.buffers["block_pass"],
                    offset: (n * stride) as u64,
                    size: NonZeroU64::new(size as u64),
                }),
                _ => self.bound(name, outputs),
            };
            self.dispatch(&mut pass, &self.programs[program], bound, *groups);
        }
        Ok(())
    }

    /// The records of a block.
    pub(super) fn records_of(&mut self, block: &Block) -> Result<Vec<Option<Placed>>> {
        let (size, count) = (block.projected.size(), block.count as usize);
        self.buffers.insert("projected", block.projected.clone());
        let numbers = self.fetch(self.encoder(), false, "projected", size)?;
        let bytes: &[u8] = bytemuck::cast_slice(&numbers);
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
    fn pass(&self, mode: u32, pieces: u32, groups: u32) -> BlockPass {
        BlockPass { first: self.first, count: self.count, mode, pieces, groups, ..BlockPass::zeroed() }
    }

    /// A dispatch over its spheres, or over so many pieces.
    fn job(&self, program: Program, mode: u32, pieces: u32, most: u32) -> Job<'_> {
        let groups = spread(if pieces > 0 { pieces } else { self.count.div_ceil(GROUP) }, most);
        Job { program, block: self, pass: self.pass(mode, pieces, groups.0), groups }
    }
}
