//! The certified frame on the device: what its kernel reads, band by band, and the list of pixels it could not prove.

use super::dispatch::{Band, Gpu};
use crate::certify::stage::Stage;
use crate::certify::tiles::{CHUNK, TILE};
use crate::error::Result;
use crate::settle::Unsure;

/// Entries that are read together with the frame; more cost a second reading.
const FIRST: u64 = 1 << 12;

/// What a list is for that a kernel writes and the host reads and clears.
const LIST: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_SRC).union(wgpu::BufferUsages::COPY_DST);

/// Bytes before the entries of a list: the count, and padding.
const HEAD: u64 = 8;

/// Bytes of an entry: two u32.
const ENTRY: u64 = 8;

/// Entries of the tiles' lists that a band's rows reach: first and one past the last.
fn reach(ranges: impl Iterator<Item = [u32; 2]>) -> [usize; 2] {
    let some = ranges.filter(|[first, end]| first < end);
    let [first, end] = some.fold([u32::MAX, 0], |[a, b], [first, end]| [a.min(first), b.max(end)]);
    if first < end { [first as usize, end as usize] } else { [0, 0] }
}

impl Gpu {
    /// Uploads what does not depend on the band.
    pub(super) fn upload_stage(&mut self, stage: &Stage) -> Result<()> {
        self.fill("lens", bytemuck::bytes_of(&stage.lens))?;
        self.fill_some("nears", bytemuck::cast_slice(&stage.nears))
    }

    /// The tiles' lists of a band, counted from their own beginning.
    pub(super) fn upload_lists(&mut self, stage: &Stage, band: &Band) -> Result<()> {
        let lists = &stage.lists;
        let [first, end] = reach(lists.rows(band.first, band.count));
        let own = |[a, b]: [u32; 2]| if a < b { [a - first as u32, b - first as u32] } else { [0; 2] };
        let tiles: Vec<_> = lists.rows(band.first, band.count).map(own).collect();
        self.fill_some("tiles", bytemuck::cast_slice(&tiles))?;
        self.fill_some("fronts", bytemuck::cast_slice(&lists.fronts[first..end]))?;
        self.fill_some("front_mores", bytemuck::cast_slice(&lists.mores[first..end]))?;
        self.fill_some("sills", bytemuck::cast_slice(&lists.sills[first / CHUNK..end / CHUNK]))
    }

    /// A binding may not be empty; the kernels count, so one record of nothing is never looked at.
    fn fill_some(&mut self, name: &'static str, bytes: &[u8]) -> Result<()> {
        self.fill(name, if bytes.is_empty() { &[0; 64] } else { bytes })
    }

    /// Room for the list of unsure pixels of a band: all of them, so that it cannot overflow.
    pub(super) fn reserve_unsure(&mut self, pixels: u64) {
        self.reserve("unsure", HEAD + ENTRY * pixels, LIST);
        self.reserve("read unsure", HEAD + ENTRY * pixels.min(FIRST), super::dispatch::READING);
    }

    /// Bytes of the list that are read together with the frame.
    pub(super) fn unsure_bytes(pixels: u64) -> u64 {
        HEAD + ENTRY * pixels.min(FIRST)
    }

    /// The band's unsure pixels; `first` are the bytes that were read together with the frame.
    pub(super) fn unsure(&mut self, first: &[u8]) -> Result<Vec<Unsure>> {
        let count = first.first_chunk().map_or(0, |c| u64::from(u32::from_ne_bytes(*c)));
        let size = (HEAD + ENTRY * count) as usize;
        if size <= first.len() {
            return Ok(entries(&first[..size]));
        }
        Ok(entries(&self.read("unsure", size as u64)?))
    }
}

fn entries(list: &[u8]) -> Vec<Unsure> {
    let pairs = bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(&list[HEAD as usize..]);
    pairs.into_iter().map(|[pixel, limit]| Unsure { pixel, limit: f32::from_bits(limit) }).collect()
}

/// Rows from `first` on, no more than `most`, whose lists fit a binding of `largest` bytes; at least one row of tiles.
pub(super) fn rows_that_fit(stage: &Stage, first: u32, most: u32, largest: u64) -> u32 {
    let bytes = |rows: u32| {
        let [first, end] = reach(stage.lists.rows(first, rows));
        (end - first) as u64 * size_of::<crate::certify::front::FrontMoreRecord>() as u64
    };
    let mut rows = most;
    while rows > TILE && bytes(rows) > largest {
        rows = (rows / 2).next_multiple_of(TILE);
    }
    rows
}
