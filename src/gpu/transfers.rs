//! Uploads, readbacks and the division into bands: `halfline plan` prints them, dispatch.rs performs them.

use super::input::{GROUP, Input, KernelRays};
use super::submission_budget::{PIXEL, SubmissionBudget};
use crate::certify::general::GeneralRecord;
use crate::certify::projected::{ProjectedDetailRecord, ProjectedRecord};
use crate::error::Result;
use crate::kernel::{Generals, Kernel, RaySource};
use crate::search::tile_candidates::CandidateList;
use crate::tile::{CHUNK, TILE};
use crate::view::{SphereRecord, SphereResiduals, ViewRecord};
use std::ops::Range;

/// Assumed tests per ray that traverses a tree: far more than for disjoint spheres, far fewer than if all overlap.
const TREE_TESTS: f64 = (1 << 12) as f64;

/// The limits of an adapter's bindings and dispatches.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BindingLimits {
    /// Largest binding in bytes.
    pub(crate) binding: u64,
    /// Largest number of workgroups along one dimension of a dispatch.
    pub(crate) groups: u32,
}

impl From<&wgpu::Limits> for BindingLimits {
    fn from(limits: &wgpu::Limits) -> Self {
        Self {
            binding: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
            groups: limits.max_compute_workgroups_per_dimension,
        }
    }
}

impl BindingLimits {
    /// The largest number of spheres for this frame. The records of a form, and the colours, must fit one binding. For
    /// a certified kernel the lists of the fullest row of tiles must fit, so the number assumes spheres distributed
    /// like these.
    pub(crate) fn spheres(&self, kernel: &Kernel, input: &Input<'_>) -> u64 {
        let of_colors = if kernel.colors { self.binding / size_of::<[f32; 3]>() as u64 } else { u64::MAX };
        // Frames store ids as i32.
        let most = of_colors.min(i32::MAX as u64);
        let Some(candidates) = &input.candidates else {
            // Spheres of certified given rays are a texture.
            let records = if kernel.certify { u64::MAX } else { self.binding / size_of::<SphereRecord>() as u64 };
            return most.min(records);
        };
        let [_, [top, bottom]] = input.view.record.tiles();
        let largest = |row: u32| largest(candidates, &Band { first: row * TILE, count: TILE });
        let fullest = (top..=bottom).map(largest).max().unwrap_or(0).max(1);
        let spheres = u128::from(input.view.record.spheres) * u128::from(self.binding) / u128::from(fullest);
        most.min(u64::try_from(spheres).unwrap_or(u64::MAX))
    }
}

/// A band of the window: rows of pixels, counted in the full frame, or a run of given rays in one row.
pub(crate) struct Band {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Band {
    /// Pixels of the window, or rays, before this band.
    pub(crate) fn before(&self, kernel: &Kernel, record: &ViewRecord) -> u64 {
        match kernel.rays {
            RaySource::Camera => u64::from(record.columns) * u64::from(self.first - record.first_row),
            _ => u64::from(self.first),
        }
    }
}

/// The division of the rays into bands that fit the adapter's bindings and the submission budget. The smallest band is
/// a row of tiles or a group of given rays; it is submitted even if it exceeds the budget.
pub(crate) struct Bands<'a> {
    kernel: &'a Kernel,
    input: &'a Input<'a>,
    limits: BindingLimits,
    /// The first row or ray of all. Bands begin at multiples of the smallest band, so the first one may be shorter.
    start: u32,
    /// The first row or ray that is in no band yet, and the one past the last.
    first: u32,
    end: u32,
}

impl<'a> Bands<'a> {
    pub(crate) fn new(kernel: &'a Kernel, input: &'a Input<'a>, limits: BindingLimits) -> Self {
        let record = &input.view.record;
        let (start, end) = match kernel.rays {
            RaySource::Camera => (record.first_row, record.first_row + record.rows),
            _ => (0, input.rays.given() as u32),
        };
        let mut bands = Self { kernel, input, limits, start, first: start, end };
        bands.first -= start % bands.unit().0;
        bands
    }

    /// The next band, as large as `budget` allows.
    pub(crate) fn next(&mut self, budget: &SubmissionBudget) -> Option<Band> {
        let (first, left) = (self.first, self.end - self.first);
        if left == 0 {
            return None;
        }
        let (unit, pixels) = self.unit();
        let units = (self.limits.binding / (12 * pixels)).clamp(1, u64::from(self.limits.groups));
        let mut count = left.min(units.min(u64::from(left)) as u32 * unit);
        let tests = budget.next(self.tests(&Band { first, count: left }));
        if self.tests(&Band { first, count }) > tests {
            count = self.within(first, count, tests);
        }
        if let Some(candidates) = &self.input.candidates {
            count = rows_that_fit(candidates, first, count, self.limits.binding);
        }
        self.first += count;
        let cut = self.start.saturating_sub(first);
        Some(Band { first: first + cut, count: count - cut })
    }

    /// Rows or rays in the smallest band, and their pixels.
    fn unit(&self) -> (u32, u64) {
        match self.kernel.rays {
            RaySource::Camera => (TILE, u64::from(self.input.view.record.columns) * u64::from(TILE)),
            _ => (GROUP, u64::from(GROUP)),
        }
    }

    /// How many of `most` rows or rays cost no more than `tests`, at least the smallest band.
    fn within(&self, first: u32, most: u32, tests: f64) -> u32 {
        let (unit, _) = self.unit();
        let (mut few, mut many) = (1, most.div_ceil(unit));
        while few < many {
            let middle = (few + many).div_ceil(2);
            if self.tests(&Band { first, count: most.min(middle * unit) }) <= tests {
                few = middle;
            } else {
                many = middle - 1;
            }
        }
        most.min(few * unit)
    }

    /// Upper bound of a band's cost, in ray-sphere tests of `stable`.
    pub(crate) fn tests(&self, band: &Band) -> f64 {
        let record = &self.input.view.record;
        let width = if self.kernel.rays == RaySource::Camera { record.columns } else { 1 };
        let pixels = f64::from(width) * f64::from(band.count);
        let cost = if self.kernel.certify { 1.0 } else { self.kernel.method.cost() };
        let all = match &self.input.candidates {
            // A ray tests its tile's list, and general spheres: those of its tile in a certified kernel, otherwise all.
            Some(candidates) => {
                let binned = candidates.binned();
                let count = |[a, b]: [u32; 2]| u64::from(b - a);
                let tile_candidates: u64 = binned.lists.rows(band.first, band.count).map(count).sum();
                let generals = match candidates {
                    CandidateList::Certified(binned) => {
                        binned.general_lists.rows(band.first, band.count).map(count).sum::<u64>() as f64
                            * f64::from(TILE * TILE)
                    }
                    CandidateList::Uncertified(_) => pixels * binned.generals.len() as f64,
                };
                tile_candidates as f64 * f64::from(TILE * TILE) + generals
            }
            None if self.kernel.tree => pixels * TREE_TESTS,
            None => pixels * f64::from(record.spheres),
        };
        all * cost + pixels * PIXEL
    }
}

/// Rows from `first` on, at most `most`, whose lists fit a binding; at least one row of tiles.
fn rows_that_fit(candidates: &CandidateList<'_>, first: u32, most: u32, binding: u64) -> u32 {
    let mut rows = most;
    while rows > TILE && largest(candidates, &Band { first, count: rows }) > binding {
        rows = (rows / 2).next_multiple_of(TILE);
    }
    rows
}

/// Size in bytes of the largest binding for the lists of a band.
fn largest(candidates: &CandidateList<'_>, band: &Band) -> u64 {
    Entries::of(candidates, band).sizes(candidates).into_iter().map(|(_, bytes)| bytes).max().unwrap_or(0)
}

/// The list entries of a band.
pub(crate) struct Entries {
    /// The list of every tile, relative to the band's first entry; and its general spheres in `lists`.
    tiles: Vec<[[u32; 2]; 2]>,
    /// The range in the lists of the whole frame.
    all: Range<usize>,
    /// The range in the general spheres of all tiles.
    general_lists: Range<usize>,
}

impl Entries {
    pub(crate) fn of(candidates: &CandidateList<'_>, band: &Band) -> Self {
        let binned = candidates.binned();
        let lists: Vec<_> = binned.lists.rows(band.first, band.count).collect();
        let general_lists: Vec<_> = match candidates {
            CandidateList::Certified(binned) => binned.general_lists.rows(band.first, band.count).collect(),
            CandidateList::Uncertified(_) => vec![[0; 2]; lists.len()],
        };
        let [all, generals] = [span(&lists), span(&general_lists)];
        // The general spheres lie in the same buffer, behind the tiles and the chunks.
        let before = 4 * lists.len() + all.len() / CHUNK;
        let inside = |[a, b]: [u32; 2], span: &Range<usize>, before: usize| match a < b {
            true => [a, b].map(|n| (n as usize - span.start + before) as u32),
            false => [0; 2],
        };
        let tile = |(own, near)| [inside(own, &all, 0), inside(near, &generals, before)];
        let tiles = lists.into_iter().zip(general_lists).map(tile).collect();
        Self { tiles, all, general_lists: generals }
    }

    /// The band's first entry in the lists of the whole frame.
    pub(crate) fn first(&self) -> u32 {
        self.all.start as u32
    }

    /// The sizes in bytes of a band's lists and records, by binding name.
    pub(crate) fn sizes(&self, candidates: &CandidateList<'_>) -> Vec<(&'static str, u64)> {
        let (entries, tiles) = (self.all.len(), size_of_val(&self.tiles[..]));
        let all = match candidates {
            CandidateList::Certified(binned) => vec![
                ("projected", entries * size_of::<ProjectedRecord>()),
                ("others", size_of_val(&binned.generals[..]) + entries * size_of::<ProjectedDetailRecord>()),
                ("lists", tiles + (entries / CHUNK + self.general_lists.len()) * size_of::<u32>()),
            ],
            CandidateList::Uncertified(tile_candidates) => {
                let places = tile_candidates.generals() + entries;
                let mut all = vec![
                    ("spheres", places * size_of::<SphereRecord>()),
                    ("lists", tiles + places / CHUNK * size_of::<f32>()),
                ];
                all.extend(tile_candidates.wide.then_some(("residuals", places * size_of::<SphereResiduals>())));
                all
            }
        };
        all.into_iter().map(|(name, bytes)| (name, bytes as u64)).collect()
    }

    /// The data of a band's bindings; `upload` is called for each binding with its parts.
    pub(crate) fn upload(
        mut self,
        candidates: &CandidateList<'_>,
        mut upload: impl FnMut(&'static str, &[&[u8]]) -> Result<()>,
    ) -> Result<()> {
        let all = self.all;
        match candidates {
            CandidateList::Certified(binned) => {
                let lists = &binned.lists;
                let chunk_min_depths = &lists.chunk_min_depths[all.start / CHUNK..all.end / CHUNK];
                upload("projected", &[bytemuck::cast_slice(&lists.projected[all.clone()])])?;
                let details = bytemuck::cast_slice(&lists.details[all]);
                upload("others", &[bytemuck::cast_slice::<GeneralRecord, u8>(&binned.generals), details])?;
                let [tiles, general_lists] = [
                    bytemuck::cast_slice(&self.tiles),
                    bytemuck::cast_slice(&binned.general_lists.slots[self.general_lists]),
                ];
                upload("lists", &[tiles, bytemuck::cast_slice(chunk_min_depths), general_lists])
            }
            CandidateList::Uncertified(tile_candidates) => {
                // The general spheres precede the lists.
                let generals = tile_candidates.generals() as u32;
                self.tiles.iter_mut().flat_map(|[list, _]| list).for_each(|n| *n += generals);
                let limits = tile_candidates.limits(all.clone());
                upload("lists", &[bytemuck::cast_slice(&self.tiles), bytemuck::cast_slice(&limits)])?;
                let records = tile_candidates.records(all.clone());
                upload("spheres", &[bytemuck::cast_slice(&records)])?;
                tile_candidates.put_back(records);
                if tile_candidates.wide {
                    let residuals = tile_candidates.residuals(all);
                    upload("residuals", &[bytemuck::cast_slice(&residuals)])?;
                    tile_candidates.put_back(residuals);
                }
                Ok(())
            }
        }
    }
}

/// The range that holds all of these ranges; empty ones are of no account.
fn span(ranges: &[[u32; 2]]) -> Range<usize> {
    let some = ranges.iter().filter(|[first, end]| first < end);
    let [first, end] = some.fold([u32::MAX, 0], |[a, b], [first, end]| [a.min(*first), b.max(*end)]);
    first.min(end) as usize..end as usize
}

/// The inputs of a kernel besides the view and the lists of a band, by binding name.
pub(crate) fn uploads<'a>(kernel: &Kernel, input: &Input<'a>) -> Vec<(&'static str, &'a [u8])> {
    let mut all: Vec<(&'static str, &'a [u8])> = Vec::new();
    match input.candidates {
        Some(CandidateList::Certified(binned)) => {
            all.push(("projection", bytemuck::bytes_of(&binned.projection)));
            if let Generals::Few(_) = kernel.generals {
                all.push(("near", bytemuck::cast_slice(&binned.generals)));
            }
        }
        Some(CandidateList::Uncertified(_)) => {}
        None if kernel.certify => {}
        None => all.push(("spheres", bytemuck::cast_slice(&input.view.spheres))),
    }
    if let (true, Some(colors)) = (kernel.colors, input.colors) {
        all.push(("colors", bytemuck::cast_slice(colors)));
    }
    match input.rays {
        KernelRays::Viewing => {}
        KernelRays::Given(rays) => all.push(("rays", bytemuck::cast_slice(rays))),
        KernelRays::Certified { rays, boxes, nodes, spheres } => {
            all.push(("certified_rays", bytemuck::cast_slice(rays)));
            all.push(("placed", bytemuck::cast_slice(spheres)));
            if kernel.tree {
                all.push(("nodes", bytemuck::cast_slice(nodes)));
                all.push(("boxes", bytemuck::cast_slice(boxes)));
            }
        }
    }
    if kernel.reads_residuals() && !kernel.tiles {
        all.push(("residuals", bytemuck::cast_slice(&input.view.residuals)));
    }
    all
}
