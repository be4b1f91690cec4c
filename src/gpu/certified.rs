//! The certified frame on the device: what its kernel reads, band by band, and the list of pixels it could not prove.

use super::dispatch::Gpu;
use super::traffic::list_size;
use crate::error::Result;
use crate::settle::Unsure;

/// Entries that are read together with the frame; more cost a second reading.
const FIRST: u64 = 1 << 12;

/// What a list is for that a kernel writes and the host reads and clears.
const LIST: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_SRC).union(wgpu::BufferUsages::COPY_DST);

/// Bytes before the entries of a list: the count, and padding.
pub(super) const LIST_HEAD: u64 = 8;

/// Bytes of an entry: two u32.
pub(super) const ENTRY: u64 = 8;

impl Gpu {
    /// Room for the list of unsure pixels of a band: all of them, so that it cannot overflow.
    pub(super) fn reserve_unsure(&mut self, pixels: u64) {
        self.reserve("unsure", list_size(pixels), LIST);
        self.reserve("read unsure", Self::unsure_bytes(pixels), super::dispatch::READING);
    }

    /// Bytes of the list that are read together with the frame.
    pub(super) fn unsure_bytes(pixels: u64) -> u64 {
        list_size(pixels.min(FIRST))
    }

    /// The band's unsure pixels; `first` are the bytes that were read together with the frame.
    pub(super) fn unsure(&mut self, first: &[u8]) -> Result<Vec<Unsure>> {
        let count = first.first_chunk().map_or(0, |c| u64::from(u32::from_ne_bytes(*c)));
        let size = list_size(count) as usize;
        if size <= first.len() {
            return Ok(entries(&first[..size]));
        }
        Ok(entries(&self.read("unsure", size as u64)?))
    }
}

fn entries(list: &[u8]) -> Vec<Unsure> {
    let pairs = bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(&list[LIST_HEAD as usize..]);
    pairs.into_iter().map(|[pixel, limit]| Unsure { pixel, limit: f32::from_bits(limit) }).collect()
}
