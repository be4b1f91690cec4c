//! The spheres that a device holds, in blocks that fit a binding.

use crate::certify::ProjectionRecord;
use crate::certify::binned::BinnedScene;
use crate::certify::placing::{PlacedSummary, PlacingRecord};
use crate::certify::planes::Ranks;
use crate::certify::projected::{ProjectedDetailRecord, ProjectedRecord};
use crate::certify::tiles::Placed;
use crate::double_double as dd;
use crate::gpu::device::Open;
use crate::gpu::sizes::{
    HOST_SPHERES, SUMMARY_DEPTHS, SUMMARY_HOST, SUMMARY_LIST, SUMMARY_MISSED, SUMMARY_MORE, SUMMARY_PERHAPS,
    SUMMARY_PIECES,
};
use crate::scene::camera::Camera;
use crate::scene::list::List;
use crate::scene::same::SameSpheres;
use crate::scene::{Cuts, Spheres};
use crate::view::ViewRecord;
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::parallel;
use std::ops::Range;
use std::sync::Arc;

/// The hits that a frame leaves on the device, from which rays start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Starts {
    pub(super) record: ViewRecord,
    /// The exponent of the unit of the vectors from the eye to the hits. Another view of the same pixels may have
    /// another.
    pub(super) unit: i32,
}

/// Spheres of a block: 64 MiB, and 80 MiB of records.
pub(crate) const BLOCK: usize = 1 << 21;

/// Spheres that one job brings into the layout of a device.
const SPHERES_PER_JOB: usize = 1 << 14;

/// The spheres of a block, and their records.
pub(super) struct Block {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Centre and radius in f64; none where the host placed them.
    pub(super) spheres: Option<wgpu::Buffer>,
    pub(super) projected: wgpu::Buffer,
}

/// The box around the centres and the range of the radii.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    low: DVec3,
    high: DVec3,
    radii: [f64; 2],
}

/// The largest range of exponents of sizes and distances that devices place: records keep their bits in every unit.
/// Section 12 of docs/certificate.md.
const SPAN: i32 = 64;
/// The largest exponent of a number that integers of shaders/place/float64.wgsl multiply.
/// Section 12 of docs/certificate.md.
const LARGEST: i32 = 300;

impl Reach {
    pub(super) fn of(spheres: &Spheres) -> Self {
        let none = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY, radii: [f64::INFINITY, 0.0] };
        let one = |all: Self, (center, radius): (&[f64; 3], &f64)| {
            let center = DVec3::from_array(*center);
            let radii = [all.radii[0].min(*radius), all.radii[1].max(*radius)];
            Self { low: all.low.min(center), high: all.high.max(center), radii }
        };
        let job = |ids: Range<usize>| spheres.centers[ids.clone()].iter().zip(&spheres.radii[ids]).fold(none, one);
        let both = |a: Self, b: Self| Self {
            low: a.low.min(b.low),
            high: a.high.max(b.high),
            radii: [a.radii[0].min(b.radii[0]), a.radii[1].max(b.radii[1])],
        };
        let jobs = parallel::blocks(0..spheres.len(), SPHERES_PER_JOB, &|ids, _| job(ids));
        jobs.into_iter().reduce(both).unwrap_or(none)
    }

    /// Bounds of the exponents of all sizes and of all distances from `eye`; `None` where they may be too far apart.
    pub(crate) fn sizes(&self, eye: DVec3) -> Option<[i32; 2]> {
        let near = (self.low - eye).max(eye - self.high).max_element().max(0.0);
        let far = (self.high - eye).abs().max((eye - self.low).abs()).max_element();
        let [least, most] = [near.max(self.radii[0]), far.max(self.radii[1])];
        let range = [least, most].map(dd::exponent);
        let world = self.low.abs().max(self.high.abs()).max(eye.abs()).max_element();
        let fits = range[1] - range[0] <= SPAN && range[0] >= -LARGEST && range[1].max(dd::exponent(world)) <= LARGEST;
        (least > 0.0 && most.is_finite() && fits).then_some(range)
    }
}

/// Cache key of placed records: camera, tolerance and lens as the device reads them, tiles of the window. The records
/// hold the camera in f64 only, and the host projects in double-double, so the exact camera is compared too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlacedFor {
    pub(super) camera: Camera,
    pub(super) placing: PlacingRecord,
    pub(super) lens: ProjectionRecord,
    pub(super) tiles: [[u32; 2]; 2],
}

/// The positions and radii of a scene's spheres, which all renderers of a device read.
pub(crate) struct SpheresOnDevice {
    of: SameSpheres,
    /// Spheres of a block.
    size: usize,
    /// Centre and radius in f64, block by block.
    blocks: Vec<wgpu::Buffer>,
}

impl SpheresOnDevice {
    /// Room for the spheres in blocks of `size` spheres.
    pub(super) fn new(open: &Open, spheres: &Spheres, frame: u64, size: usize) -> Self {
        let starts = (0..spheres.len()).step_by(size);
        let block = |first: usize| buffer(open, "resident", 32 * size.min(spheres.len() - first) as u64);
        Self { of: SameSpheres::of(spheres, frame), size, blocks: starts.map(block).collect() }
    }

    /// Whether they are these in blocks of this size, and no one can change them.
    pub(super) fn serves(&self, spheres: &Spheres, size: usize) -> bool {
        // The frame matters only for lists that can be changed.
        self.size == size && self.of.is_kept() && self.of.is_of(spheres, 0)
    }

    /// Sends the spheres; returns the number of bytes.
    ///
    /// # Errors
    /// [`Error::DeviceLost`](crate::Error::DeviceLost).
    pub(super) fn send(&self, open: &mut Open, spheres: &Spheres) -> Result<u64> {
        let blocks = spheres.centers.chunks(self.size).zip(spheres.radii.chunks(self.size));
        let mut sent = 0;
        for (to, (centers, radii)) in self.blocks.iter().zip(blocks) {
            let mut packed: Vec<[f64; 4]> = vec![[0.0; 4]; centers.len()];
            parallel::each(&mut packed, |n, to| {
                let [x, y, z] = centers[n];
                *to = [x, y, z, radii[n]];
            });
            let bytes: &[u8] = bytemuck::cast_slice(&packed);
            open.write(to, 0, bytes)?;
            sent += bytes.len() as u64;
        }
        Ok(sent)
    }
}

/// A buffer of spheres or of their records.
fn buffer(open: &Open, label: &str, size: u64) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    open.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

/// The spheres of a scene on a device.
pub(crate) struct ResidentScene {
    shared: Option<Arc<SpheresOnDevice>>,
    /// The last frame that used them.
    pub(super) used: u64,
    count: u32,
    pub(super) reach: Reach,
    pub(super) blocks: Vec<Block>,
    /// The ids of the spheres that the host placed, in the last block.
    guests: Vec<u32>,
    /// The planes that cut spheres, and the order of these.
    cuts: Option<Cuts>,
    pub(super) ranks: Option<Ranks>,
    pub(super) pieces: u32,
    /// The key of the last placing, and the spheres that the host placed or listed for it.
    pub(super) placed: Option<(PlacedFor, BinnedScene)>,
    pub(in crate::gpu) has_colors: bool,
    pub(in crate::gpu) has_lists: bool,
    /// Identity of the colours: their list where no one can change it; their address, and the frame in which they were
    /// sent.
    colors: (Option<List<[f32; 3]>>, Option<usize>, u64),
}

fn address_of_colors(spheres: &Spheres) -> Option<usize> {
    spheres.colors.as_ref().map(|colors| colors.as_ptr() as usize)
}

impl ResidentScene {
    /// Bytes of the largest buffer of a block of so many spheres.
    pub(super) fn largest(count: usize) -> u64 {
        Block::records(count as u32, true)
    }

    /// Room for the records of a scene's spheres in blocks of `size` spheres.
    pub(super) fn new(open: &Open, spheres: &Spheres, frame: u64, size: usize) -> Self {
        let ranks = spheres.cuts.as_ref().map(|cuts| Ranks::new(spheres, cuts));
        let is_cut = ranks.is_some();
        let block = |n: usize| Block::new(open, [n, size.min(spheres.len() - n)].map(|n| n as u32), is_cut);
        Self {
            shared: None,
            used: frame,
            count: spheres.len() as u32,
            reach: Reach::of(spheres),
            blocks: (0..spheres.len()).step_by(size).map(block).collect(),
            guests: Vec::new(),
            cuts: spheres.cuts.clone(),
            ranks,
            pieces: 0,
            placed: None,
            has_colors: false,
            has_lists: false,
            colors: (spheres.colors.as_ref().and_then(List::kept), address_of_colors(spheres), frame),
        }
    }

    /// Takes its spheres, and sends their ranks; returns the number of bytes.
    ///
    /// # Errors
    /// [`Error::DeviceLost`](crate::Error::DeviceLost).
    pub(super) fn take(&mut self, shared: Arc<SpheresOnDevice>, open: &mut Open) -> Result<u64> {
        self.blocks.iter_mut().zip(&shared.blocks).for_each(|(block, spheres)| block.spheres = Some(spheres.clone()));
        self.shared = Some(shared);
        self.blocks.iter().map(|block| self.send_ranks(open, block, |n| block.first + n)).sum()
    }

    /// Sends the ranks of the spheres of a block, whose ids `id` returns, where planes cut spheres.
    fn send_ranks(&self, open: &mut Open, block: &Block, id: impl Fn(u32) -> u32 + Sync) -> Result<u64> {
        let Some(ranks) = &self.ranks else { return Ok(0) };
        let mut of = vec![0; block.count as usize];
        parallel::each(&mut of, |n, to| *to = ranks.rank(id(n as u32)));
        open.write(&block.projected, Block::records(block.count, false), bytemuck::cast_slice(&of))?;
        Ok(size_of_val(&of[..]) as u64)
    }

    /// Whether the resident spheres, with their colours, are the spheres of a scene in frame `frame`.
    pub(super) fn is_of(&self, spheres: &Spheres, frame: u64) -> bool {
        let colors = match (&self.colors, &spheres.colors) {
            ((Some(kept), ..), Some(colors)) => kept.is_same(colors),
            ((None, None, _), None) => true,
            ((_, address, sent), _) => *address == address_of_colors(spheres) && *sent == frame,
        };
        let is_same = self.shared.as_ref().is_some_and(|shared| shared.of.is_of(spheres, frame));
        colors && self.cuts == spheres.cuts && is_same
    }

    /// The id of the sphere in a slot.
    pub(super) fn id(&self, slot: u32) -> u32 {
        slot.checked_sub(self.count).map_or(slot, |guest| self.guests[guest as usize])
    }

    /// Replaces the spheres that the host placed, in a block of their own; returns the number of bytes sent.
    ///
    /// # Errors
    /// [`Error::DeviceLost`](crate::Error::DeviceLost).
    pub(super) fn set_guests(&mut self, open: &mut Open, guests: &[Placed]) -> Result<u64> {
        self.blocks.retain(|block| block.spheres.is_some());
        self.guests = guests.iter().map(|placed| placed.detail.id).collect();
        if guests.is_empty() {
            return Ok(0);
        }
        let block = Block::new(open, [self.count, guests.len() as u32], self.ranks.is_some());
        let records: Vec<ProjectedRecord> = guests.iter().map(|placed| placed.record).collect();
        let details: Vec<ProjectedDetailRecord> = guests.iter().map(|placed| placed.detail).collect();
        let depths: Vec<f64> = guests.iter().map(|placed| placed.depth).collect();
        let parts: [&[u8]; 3] =
            [bytemuck::cast_slice(&records), bytemuck::cast_slice(&details), bytemuck::cast_slice(&depths)];
        let mut offset = 0;
        for part in parts {
            open.write(&block.projected, offset, part)?;
            offset += part.len() as u64;
        }
        let ranks = self.send_ranks(open, &block, |n| self.guests[n as usize])?;
        self.blocks.push(block);
        Ok(offset + ranks)
    }

    /// Makes its buffers useless.
    #[cfg(test)]
    pub(in crate::gpu) fn destroy(&self) {
        let buffers = self.blocks.iter().flat_map(|block| block.spheres.iter().chain([&block.projected]));
        buffers.for_each(wgpu::Buffer::destroy);
    }

    /// The block of the spheres that the host placed.
    pub(super) fn guests(&self) -> Option<&Block> {
        self.blocks.last().filter(|block| block.spheres.is_none())
    }
}

impl Block {
    /// Bytes of the records of `count` spheres: two of 16 bytes, and depths in pairs; where planes cut spheres, ranks in fours.
    fn records(count: u32, has_ranks: bool) -> u64 {
        let in_vectors = |each: u32| 16 * u64::from(count.div_ceil(each));
        2 * in_vectors(1) + in_vectors(2) + if has_ranks { in_vectors(4) } else { 0 }
    }

    /// A block with room for records, with ranks where planes cut spheres.
    fn new(open: &Open, [first, count]: [u32; 2], has_ranks: bool) -> Self {
        let projected = buffer(open, "projected", Self::records(count, has_ranks));
        Self { first, count, spheres: None, projected }
    }
}

/// Counters and the spheres left to the host, read back after the placing pass.
pub(super) struct Counts {
    pub(super) summary: PlacedSummary,
    pub(super) host: u32,
    pub(super) pieces: u64,
}

/// Pieces of large spheres, in two words.
pub(super) fn pieces(numbers: &[u32]) -> u64 {
    u64::from(numbers[SUMMARY_MORE as usize]) << 32 | u64::from(numbers[SUMMARY_PIECES as usize])
}

impl Counts {
    /// The counts in the words of the summary.
    pub(super) fn new(numbers: &[u32]) -> Self {
        let range = |at: u32| {
            let [least, most] = [numbers[at as usize], numbers[at as usize + 1]];
            (least <= most).then(|| [least, most].map(|bits| f64::from(f32::from_bits(bits))))
        };
        let host = numbers[SUMMARY_HOST as usize];
        let mut for_host: Vec<u32> = numbers[SUMMARY_LIST as usize..][..host.min(HOST_SPHERES) as usize].to_vec();
        for_host.sort_unstable();
        let missed = Some(numbers[SUMMARY_MISSED as usize]).filter(|slot| *slot < u32::MAX);
        let summary =
            PlacedSummary { depths: range(SUMMARY_DEPTHS), perhaps: range(SUMMARY_PERHAPS), for_host, missed };
        Self { summary, host, pieces: pieces(numbers) }
    }
}
