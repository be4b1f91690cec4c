//! The certified frame on the device: one pass that answers and proves, one that names the candidates of the rest.

use super::dispatch::Gpu;
use super::traffic::{Band, list_size};
use crate::error::Result;
use crate::plan::Kernel;
use crate::settle::Open;
use crate::view::ViewRecord;

/// Entries that are read together with their count; more cost a second reading.
const FIRST: u64 = 1 << 12;

/// Pairs there is room for at first; the room grows as needed.
const PAIRS: u64 = 1 << 14;

/// Workgroups in a row of the second pass; a layout test holds it against the shader.
pub(crate) const GROUPS: u32 = 32768;

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
    }

    /// Reads the band's unsure pixels and asks for their candidates.
    pub(super) fn follow_up(
        &mut self,
        kernel: &Kernel,
        record: &ViewRecord,
        band: &Band,
        open: &mut Open,
    ) -> Result<()> {
        let all = u64::from(record.width) * u64::from(band.count);
        let first = self.read_list("unsure", FIRST.min(all))?;
        if first.count == 0 {
            return Ok(());
        }
        let unsure = if first.count > FIRST.min(all) { self.read_list("unsure", first.count)? } else { first };
        open.pixels.extend(unsure.entries.iter().map(|entry| entry[0]));
        let emit = kernel.emitting();
        self.pipeline(&emit)?;
        let groups = unsure.count.div_ceil(u64::from(super::dispatch::GROUP)) as u32;
        let mut room = self.size("pairs").map_or(PAIRS, |size| (size - LIST_HEAD) / ENTRY);
        loop {
            self.check_size("pairs", list_size(room))?;
            self.reserve("pairs", list_size(room), LIST);
            self.submit(&emit, 0, (groups.min(GROUPS), groups.div_ceil(GROUPS)))?;
            let pairs = self.read_list("pairs", room)?;
            if pairs.count <= room {
                open.pairs.extend(pairs.entries);
                return Ok(());
            }
            room = pairs.count.next_power_of_two();
        }
    }

    /// The count of a list, and its entries as far as they were asked for.
    fn read_list(&mut self, name: &'static str, entries: u64) -> Result<List> {
        let bytes = self.read(name, list_size(entries))?;
        let count = bytes.first_chunk().map_or(0, |c| u64::from(u32::from_ne_bytes(*c)));
        let there = count.min(entries) as usize;
        let entries =
            bytemuck::pod_collect_to_vec::<u8, [u32; 2]>(&bytes[LIST_HEAD as usize..][..ENTRY as usize * there]);
        Ok(List { count, entries })
    }
}

struct List {
    count: u64,
    entries: Vec<[u32; 2]>,
}
