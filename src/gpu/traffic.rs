//! What goes to the device, what it writes, and in how many pieces: told by `halfline plan`, done by dispatch.rs.

use super::certified::{ENTRY, LIST_HEAD};
use super::dispatch::{GROUP, Input};
use crate::certify::front::{FrontMoreRecord, FrontRecord};
use crate::certify::near::NearRecord;
use crate::certify::tiles::{CHUNK, TILE};
use crate::error::Result;
use crate::listed::{Asked, Candidate};
use crate::plan::{Kernel, Rays};
use crate::view::SphereLow;
use std::ops::Range;

/// Ray-sphere tests in one dispatch: a second or so on software, far below any watchdog on hardware.
const TESTS_PER_DISPATCH: u64 = 1 << 32;

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
    let tests = match &input.stage {
        // What a pixel of an average tile may be asked.
        Some(asked) => asked.stage().lists.mean(),
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
        let count = input.stage.map_or(most, |asked| rows_that_fit(&asked, first, most, reach.binding));
        bands.push(Band { first, count });
        first += count;
    }
    bands
}

/// Rows from `first` on, no more than `most`, whose lists fit a binding; at least one row of tiles.
fn rows_that_fit(asked: &Asked<'_>, first: u32, most: u32, binding: u64) -> u32 {
    let largest = |count: u32| {
        let entries = Entries::of(asked, &Band { first, count });
        entries.sizes(asked).into_iter().map(|(_, bytes)| bytes).max().unwrap_or(0)
    };
    let mut rows = most;
    while rows > TILE && largest(rows) > binding {
        rows = (rows / 2).next_multiple_of(TILE);
    }
    rows
}

/// The list entries of a band.
pub(crate) struct Entries {
    /// Of every tile, counted from the band's first.
    tiles: Vec<[u32; 2]>,
    /// Among all of the frame.
    all: Range<usize>,
}

impl Entries {
    pub(crate) fn of(asked: &Asked<'_>, band: &Band) -> Self {
        let mut tiles: Vec<_> = asked.stage().lists.rows(band.first, band.count).collect();
        let some = tiles.iter().filter(|[first, end]| first < end);
        let [first, end] = some.fold([u32::MAX, 0], |[a, b], [first, end]| [a.min(*first), b.max(*end)]);
        let first = first.min(end);
        for [a, b] in &mut tiles {
            [*a, *b] = if a < b { [*a - first, *b - first] } else { [0; 2] };
        }
        Self { tiles, all: first as usize..end as usize }
    }

    /// What the rays of the band may meet, and its bytes, by the names of the bindings.
    pub(crate) fn sizes(&self, asked: &Asked<'_>) -> Vec<(&'static str, u64)> {
        let (entries, tiles) = (self.all.len(), size_of_val(&self.tiles[..]));
        let all = match asked {
            Asked::Certified(stage) => vec![
                ("fronts", entries * size_of::<FrontRecord>()),
                ("others", size_of_val(&stage.nears[..]) + entries * size_of::<FrontMoreRecord>()),
                ("lists", tiles + entries / CHUNK * size_of::<f32>()),
            ],
            Asked::Form(listed) => {
                let places = listed.nears() + entries;
                let mut all = vec![
                    ("candidates", places * size_of::<Candidate>()),
                    ("lists", tiles + places / CHUNK * size_of::<f32>()),
                ];
                all.extend(listed.wide.then_some(("candidate_lows", places * size_of::<SphereLow>())));
                all
            }
        };
        all.into_iter().map(|(name, bytes)| (name, bytes as u64)).collect()
    }

    /// The bytes themselves, part by part; `upload` hears each binding.
    pub(crate) fn upload(
        mut self,
        asked: &Asked<'_>,
        mut upload: impl FnMut(&'static str, &[&[u8]]) -> Result<()>,
    ) -> Result<()> {
        let all = self.all;
        match asked {
            Asked::Certified(stage) => {
                let lists = &stage.lists;
                let sills = &lists.sills[all.start / CHUNK..all.end / CHUNK];
                upload("fronts", &[bytemuck::cast_slice(&lists.fronts[all.clone()])])?;
                let mores = bytemuck::cast_slice(&lists.mores[all]);
                upload("others", &[bytemuck::cast_slice::<NearRecord, u8>(&stage.nears), mores])?;
                upload("lists", &[bytemuck::cast_slice(&self.tiles), bytemuck::cast_slice(sills)])
            }
            Asked::Form(listed) => {
                // The near spheres lie before the lists.
                let nears = listed.nears() as u32;
                self.tiles.iter_mut().flatten().for_each(|n| *n += nears);
                let limits = listed.limits(all.clone());
                upload("lists", &[bytemuck::cast_slice(&self.tiles), bytemuck::cast_slice(&limits)])?;
                let candidates = listed.candidates(all.clone());
                upload("candidates", &[bytemuck::cast_slice(&candidates)])?;
                listed.give(candidates);
                if listed.wide {
                    let lows = listed.lows(all);
                    upload("candidate_lows", &[bytemuck::cast_slice(&lows)])?;
                    listed.give(lows);
                }
                Ok(())
            }
        }
    }
}

/// What a kernel reads besides the view and the lists of a band, by the name of its binding.
pub(crate) fn uploads<'a>(kernel: &Kernel, input: &Input<'a>) -> Vec<(&'static str, &'a [u8])> {
    let mut all: Vec<(&'static str, &'a [u8])> = Vec::new();
    match input.stage {
        Some(Asked::Certified(stage)) => all.push(("lens", bytemuck::bytes_of(&stage.lens))),
        Some(Asked::Form(_)) => {}
        None => all.push(("spheres", bytemuck::cast_slice(&input.view.spheres))),
    }
    if let (true, Some(colors)) = (kernel.colors, input.colors) {
        all.push(("colors", bytemuck::cast_slice(colors)));
    }
    if kernel.rays != Rays::Camera {
        all.push(("rays", bytemuck::cast_slice(input.rays)));
    }
    if kernel.rays == Rays::Spread || kernel.is_wide() && !kernel.tiles {
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
