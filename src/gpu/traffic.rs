//! What goes to the device, what it writes, and in how many pieces: told by `halfline plan`, done by dispatch.rs.

use super::certified::{ENTRY, LIST_HEAD};
use super::dispatch::{GROUP, Input};
use crate::certify::front::{FrontMoreRecord, FrontRecord};
use crate::certify::near::NearRecord;
use crate::certify::stage::Stage;
use crate::certify::tiles::{CHUNK, TILE};
use crate::plan::{Kernel, Rays};

/// Ray-sphere tests in one dispatch: a second or so on software, far below any watchdog on hardware.
const TESTS_PER_DISPATCH: u64 = 1 << 32;

/// What a ray that walks a tree is taken to ask: far more than where spheres are apart, far less than where all overlap.
const TREE_TESTS: u64 = 1 << 12;

/// What an adapter can take at once.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    /// Bytes in one binding.
    pub(crate) binding: u64,
    /// Workgroups along one dimension of a dispatch.
    pub(crate) groups: u32,
}

impl From<&wgpu::Limits> for Reach {
    fn from(limits: &wgpu::Limits) -> Self {
        Self {
            binding: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            groups: limits.max_compute_workgroups_per_dimension,
        }
    }
}

/// A band of the frame: rows of pixels, or a run of given rays in one row.
pub(crate) struct Band {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// The rays in pieces that fit the adapter's bindings and its patience.
pub(crate) fn bands(kernel: &Kernel, input: &Input<'_>, reach: &Reach) -> Vec<Band> {
    let record = &input.view.record;
    let tests = match input.stage {
        // What a pixel of an average tile may be asked.
        Some(stage) => stage.lists.mean(),
        None if kernel.tree => TREE_TESTS,
        None => u64::from(record.spheres),
    };
    let pixels = (reach.binding / 12).min(TESTS_PER_DISPATCH / tests.max(1));
    let most = u64::from(reach.groups);
    let (total, step) = match kernel.rays {
        Rays::Camera => {
            let tiles = (pixels / u64::from(record.width * TILE)).max(1);
            (record.height, tiles.min(most) as u32 * TILE)
        }
        _ => (input.rays.len() as u32, (pixels / u64::from(GROUP)).max(1).min(most) as u32 * GROUP),
    };
    let mut bands = Vec::new();
    let mut first = 0;
    while first < total {
        let most = step.min(total - first);
        let count = input.stage.map_or(most, |stage| rows_that_fit(stage, first, most, reach.binding));
        bands.push(Band { first, count });
        first += count;
    }
    bands
}

/// Rows from `first` on, no more than `most`, whose lists fit a binding; at least one row of tiles.
fn rows_that_fit(stage: &Stage, first: u32, most: u32, binding: u64) -> u32 {
    // The near spheres lie in the same buffer.
    let room = binding.saturating_sub(size_of_val(&stage.nears[..]) as u64);
    if size_of_val(&stage.lists.mores[..]) as u64 <= room {
        return most;
    }
    let bytes = |rows: u32| size_of_val(lists(stage, &Band { first, count: rows }).mores) as u64;
    let mut rows = most;
    while rows > TILE && bytes(rows) > room {
        rows = (rows / 2).next_multiple_of(TILE);
    }
    rows
}

/// The tiles' lists of a band, counted from their own beginning, and the near spheres.
pub(crate) struct Lists<'a> {
    nears: &'a [NearRecord],
    tiles: Vec<[u32; 2]>,
    fronts: &'a [FrontRecord],
    mores: &'a [FrontMoreRecord],
    sills: &'a [f32],
}

/// What the rays of `band` may meet.
pub(crate) fn lists<'a>(stage: &'a Stage, band: &Band) -> Lists<'a> {
    let all = &stage.lists;
    let mut tiles: Vec<_> = all.rows(band.first, band.count).collect();
    let some = tiles.iter().filter(|[first, end]| first < end);
    let [first, end] = some.fold([u32::MAX, 0], |[a, b], [first, end]| [a.min(*first), b.max(*end)]);
    let first = first.min(end);
    for [a, b] in &mut tiles {
        [*a, *b] = if a < b { [*a - first, *b - first] } else { [0; 2] };
    }
    let (first, end) = (first as usize, end as usize);
    Lists {
        nears: &stage.nears,
        tiles,
        fronts: &all.fronts[first..end],
        mores: &all.mores[first..end],
        sills: &all.sills[first / CHUNK..end / CHUNK],
    }
}

impl Lists<'_> {
    /// By the names of their bindings, part by part.
    pub(crate) fn uploads(&self) -> [(&'static str, [&[u8]; 2]); 3] {
        [
            ("fronts", [bytemuck::cast_slice(self.fronts), &[]]),
            ("others", [bytemuck::cast_slice(self.nears), bytemuck::cast_slice(self.mores)]),
            ("lists", [bytemuck::cast_slice(&self.tiles), bytemuck::cast_slice(self.sills)]),
        ]
    }
}

/// What a kernel reads besides the view and the lists of a band, by the name of its binding.
pub(crate) fn uploads<'a>(kernel: &Kernel, input: &Input<'a>) -> Vec<(&'static str, &'a [u8])> {
    let mut all: Vec<(&'static str, &'a [u8])> = Vec::new();
    match (kernel.certify, input.stage) {
        (true, Some(stage)) => all.push(("lens", bytemuck::bytes_of(&stage.lens))),
        (true, None) => {}
        (false, _) => all.push(("spheres", bytemuck::cast_slice(&input.view.spheres))),
    }
    if let (true, Some(colors)) = (kernel.colors, input.colors) {
        all.push(("colors", bytemuck::cast_slice(colors)));
    }
    if kernel.rays != Rays::Camera {
        all.push(("rays", bytemuck::cast_slice(input.rays)));
    }
    if let (true, Some(tree)) = (kernel.tree, input.tree) {
        all.push(("nodes", bytemuck::cast_slice(&tree.nodes)));
        all.push(("order", bytemuck::cast_slice(&tree.order)));
    }
    if kernel.rays == Rays::Spread || kernel.is_wide() {
        all.push(("lows", bytemuck::cast_slice(&input.view.lows)));
    }
    all
}

/// A buffer that a kernel writes and the host reads: its binding, where it is read from, bytes per pixel.
pub(crate) struct Written {
    pub(crate) name: &'static str,
    pub(crate) staging: &'static str,
    pub(crate) bytes: u64,
}

/// The buffers that a kernel writes for every pixel.
pub(crate) fn outputs(kernel: &Kernel) -> impl Iterator<Item = Written> {
    [
        (true, "frame_id", "read frame_id", 4),
        (kernel.width, "frame_width", "read frame_width", 4),
        (kernel.t, "frame_t", "read frame_t", 4),
        (kernel.t && kernel.is_wide(), "frame_t_low", "read frame_t_low", 4),
        (kernel.normal, "frame_normal", "read frame_normal", 12),
        (kernel.shade.is_some(), "frame_color", "read frame_color", 12),
    ]
    .into_iter()
    .filter(|(written, ..)| *written)
    .map(|(_, name, staging, bytes)| Written { name, staging, bytes })
}

/// Bytes of a list with room for so many entries of two u32.
pub(crate) fn list_size(entries: u64) -> u64 {
    LIST_HEAD + ENTRY * entries
}
