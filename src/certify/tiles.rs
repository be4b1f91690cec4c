//! The projected spheres that the rays of a tile may hit, binned by their extent and sorted by depth.
//!
//! No tree is built: spheres are counted per cell, scattered by prefix sums, and each list is sorted incrementally from
//! the front and cut where all remaining spheres are certainly occluded. A list serves one tile of 8 x 8 pixels, or a
//! square of tiles if large spheres would make the lists of single tiles too long. With one list for the whole image,
//! every sphere is tested.

mod grid;

pub(crate) use grid::Bin;
pub(super) use grid::{Grid, number, ordered, sized};

use super::projected::{ProjectedDetailRecord, ProjectedRecord};
use crate::memory::Pool;
use crate::tile::{CHUNK, TILE, WHOLE};
use crate::view::ray::NONE;
use grid::Keys;
use pulp::NullaryFnOnce;
use rayon::prelude::*;

/// Entries beyond eight per sphere before tiles share their lists: 64 MiB.
const SPARE: u64 = 1 << 21;

/// Entries that are sorted first. Shorter lists skip the occlusion test, which would cost more than eight chunks per
/// tile.
const FOREMOST: usize = 64;

/// Spheres that are read together: they lie anywhere in memory, and a processor waits for many of them at once.
pub(super) const AHEAD: usize = 4 * CHUNK;

/// The padding of a list: far outside the image, with radius 0.
pub(crate) const NOTHING: ProjectedRecord = ProjectedRecord { x: 1 << 30, y: 1 << 30, rho: 0.0, low: 0.0 };
pub(crate) const NO_DETAIL: ProjectedDetailRecord =
    ProjectedDetailRecord { subpixel_offset: [0.0; 2], center: 0.0, id: NONE };

/// The representation of a projected sphere in a list.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable)]
pub(crate) struct Placed {
    pub(crate) record: ProjectedRecord,
    pub(crate) detail: ProjectedDetailRecord,
    /// The depth of the centre in the frame's unit.
    pub(crate) depth: f64,
}

/// Creates the records of a list from front to back.
pub(crate) trait Placing: Sync {
    /// The entries of one list, in order.
    type Filling<'a>: Filling
    where
        Self: 'a;

    /// Begins the list of the tile at this column and row of tiles, or of several tiles (`None`).
    fn begin(&self, tile: Option<[u32; 2]>) -> Self::Filling<'_>;
}

/// A list under construction.
pub(crate) trait Filling {
    /// Reads the spheres that come next, at most [`AHEAD`].
    fn fetch(&mut self, ids: &[u32]);

    /// The records of those spheres from number `first` on, at most [`CHUNK`].
    fn place(&mut self, first: usize, to: &mut [Placed]);

    /// The depth beyond which every sphere is certainly occluded, if known: no sphere with a higher minimum is hit
    /// first.
    fn limit(&self) -> Option<f64>;
}

/// The candidates of every tile.
#[derive(Debug, Clone)]
pub(crate) struct Lists {
    grid: Grid,
    /// The end of every cell's entries, which is the start of the next cell's.
    ends: Vec<u32>,
    /// The records that every candidate test reads.
    pub(crate) projected: Vec<ProjectedRecord>,
    /// The records that only a winner needs.
    pub(crate) details: Vec<ProjectedDetailRecord>,
    /// The depths of the centres in the frame's unit, which only the host reads.
    pub(crate) depths: Vec<f64>,
    /// Per [`CHUNK`] entries: the lower bound of the depths in this chunk and all later ones of its list.
    pub(crate) chunk_min_depths: Vec<f32>,
}

impl Lists {
    /// Bins spheres, whose ids are their indices in `bins`, with `single` entries in lists of single tiles. Squares of 2^`level` tiles, or larger ones, share a list.
    /// The size is chosen for the whole image, and lists are created only for cells that overlap `tiles` (first and
    /// last column and row). So each list equals that of the whole image.
    pub(crate) fn new(
        bins: &[Bin],
        single: u64,
        tiles: [[u32; 2]; 2],
        level: u32,
        placing: &impl Placing,
        pool: &Pool,
    ) -> Self {
        let most = (8 * bins.len() as u64 + SPARE).min(u64::from(u32::MAX));
        let entries = |level: u32| match level {
            0 => single,
            _ => bins.par_iter().map(|bin| bin.entries(level)).sum::<u64>(),
        };
        let fits = |level: &u32| *level >= WHOLE || entries(*level) <= most;
        let level = (level..=WHOLE).find(fits).unwrap_or(WHOLE);
        let grid = Grid::new(level, tiles);
        let keys = grid.scatter(bins, pool);
        let lists = Self::gather(grid, &keys, placing, pool);
        keys.put_back(pool);
        lists
    }

    /// The lists of some tiles of the window, in the order of their cells: pairs of a tile (column and row) and its spheres.
    /// All other tiles have none.
    pub(crate) fn of_tiles(tiles: [[u32; 2]; 2], some: &[([u32; 2], Vec<Placed>)]) -> Self {
        let grid = Grid::new(0, tiles);
        let mut ends = vec![0; grid.cells()];
        let (mut projected, mut details) = (Vec::new(), Vec::new());
        let (mut depths, mut chunk_min_depths) = (Vec::new(), Vec::new());
        for ([column, row], list) in some {
            let padding = list.len().next_multiple_of(CHUNK) - list.len();
            projected.extend(list.iter().map(|placed| placed.record));
            projected.extend(std::iter::repeat_n(NOTHING, padding));
            details.extend(list.iter().map(|placed| placed.detail));
            details.extend(std::iter::repeat_n(NO_DETAIL, padding));
            depths.extend(list.iter().map(|placed| placed.depth));
            depths.extend(std::iter::repeat_n(0.0, padding));
            // Lists are not sorted, so no chunk is behind another.
            chunk_min_depths.resize(projected.len() / CHUNK, f32::MIN);
            ends[grid.cell(*column, *row)] = projected.len() as u32;
        }
        let mut end = 0;
        for own in &mut ends {
            end = end.max(*own);
            *own = end;
        }
        Self { grid, ends, projected, details, depths, chunk_min_depths }
    }

    /// The range of entries for the tile that contains the pixel at `row` and `column`.
    pub(crate) fn range(&self, row: u32, column: u32) -> [u32; 2] {
        let cell = self.grid.cell(column / TILE, row / TILE);
        let first = cell.checked_sub(1).map_or(0, |before| self.ends[before]);
        [first, self.ends[cell]]
    }

    /// Level: squares of 2^level tiles share a list.
    #[cfg(test)]
    pub(crate) fn level(&self) -> u32 {
        self.grid.level()
    }

    /// Creates the lists of every row of cells and concatenates them.
    fn gather(grid: Grid, keys: &Keys, placing: &impl Placing, pool: &Pool) -> Self {
        let arch = pulp::Arch::new();
        let row = |own: &mut Vec<u64>, i: usize| arch.dispatch(Cells { grid, keys, i, placing, own, pool });
        let made: Vec<Row> = (0..grid.rows() as usize).into_par_iter().map_init(Vec::new, row).collect();
        let total = made.iter().map(|row| row.projected.len()).sum();
        let mut ends = Vec::with_capacity(grid.cells());
        let (mut projected, mut details) = (sized(total, pool), sized(total, pool));
        let mut depths: Vec<f64> = sized(total, pool);
        let mut chunk_min_depths: Vec<f32> = sized(total / CHUNK, pool);
        let mut jobs = Vec::with_capacity(made.len());
        let (mut record, mut detail) = (&mut projected[..], &mut details[..]);
        let (mut depth, mut chunk_min_depth) = (&mut depths[..], &mut chunk_min_depths[..]);
        let mut first = 0;
        for row in made {
            ends.extend(row.ends.iter().map(|end| first + end));
            let size = row.projected.len();
            first += size as u32;
            let (of_projected, rest) = record.split_at_mut(size);
            record = rest;
            let (of_details, rest) = detail.split_at_mut(size);
            detail = rest;
            let (of_depths, rest) = depth.split_at_mut(size);
            depth = rest;
            let (of_chunks, rest) = chunk_min_depth.split_at_mut(size / CHUNK);
            chunk_min_depth = rest;
            jobs.push((row, of_projected, of_details, of_depths, of_chunks));
        }
        jobs.into_par_iter().for_each(|(row, projected, details, depths, chunk_min_depths)| {
            projected.copy_from_slice(&row.projected);
            details.copy_from_slice(&row.details);
            depths.copy_from_slice(&row.depths);
            chunk_min_depths.copy_from_slice(&row.chunk_min_depths);
            row.put_back(pool);
        });
        Self { grid, ends, projected, details, depths, chunk_min_depths }
    }
}

/// A row of cells whose lists are made.
struct Cells<'a, P> {
    grid: Grid,
    keys: &'a Keys,
    i: usize,
    placing: &'a P,
    own: &'a mut Vec<u64>,
    pool: &'a Pool,
}

impl<P: Placing> NullaryFnOnce for Cells<'_, P> {
    type Output = Row;

    #[inline(always)]
    fn call(self) -> Row {
        let Self { grid, keys, i, placing, own, pool } = self;
        let columns = grid.columns() as usize;
        let starts = keys.of_row(i, columns, own);
        let mut row = Row::with_capacity(own.len() + columns * CHUNK, pool);
        for (j, pair) in starts.windows(2).enumerate() {
            let own = &mut own[pair[0] as usize..pair[1] as usize];
            if own.is_empty() {
                row.ends.push(row.projected.len() as u32);
                continue;
            }
            let tile = (grid.level() == 0 && own.len() > FOREMOST).then_some(grid.tile(j, i));
            row.fill(own, &mut placing.begin(tile));
        }
        row
    }
}

/// The lists of a row of cells, with indices relative to its start.
struct Row {
    ends: Vec<u32>,
    projected: Vec<ProjectedRecord>,
    details: Vec<ProjectedDetailRecord>,
    depths: Vec<f64>,
    chunk_min_depths: Vec<f32>,
}

impl Row {
    fn with_capacity(entries: usize, pool: &Pool) -> Self {
        Self {
            ends: Vec::new(),
            projected: empty(entries, pool),
            details: empty(entries, pool),
            depths: empty(entries, pool),
            chunk_min_depths: empty(entries / CHUNK, pool),
        }
    }

    fn put_back(self, pool: &Pool) {
        pool.put_back(self.projected);
        pool.put_back(self.details);
        pool.put_back(self.depths);
        pool.put_back(self.chunk_min_depths);
    }

    /// Appends the list of these keys: in order, as far as needed, padded.
    #[inline(always)]
    fn fill(&mut self, keys: &mut [u64], filling: &mut impl Filling) {
        let nothing = Placed { record: NOTHING, detail: NO_DETAIL, depth: 0.0 };
        let mut rest = keys;
        let mut batch = FOREMOST;
        while !rest.is_empty() {
            // Most of a long list may be occluded, so only the next part is sorted.
            let size = batch.min(rest.len());
            if size < rest.len() {
                rest.select_nth_unstable(size - 1);
            }
            let (now, later) = rest.split_at_mut(size);
            now.sort_unstable();
            for group in now.chunks(AHEAD) {
                let mut ids = [0; AHEAD];
                ids.iter_mut().zip(group).for_each(|(id, key)| *id = *key as u32);
                filling.fetch(&ids[..group.len()]);
                for (n, chunk) in group.chunks(CHUNK).enumerate() {
                    let chunk_min_depth = number((chunk[0] >> 32) as u32);
                    if filling.limit().is_some_and(|limit| f64::from(chunk_min_depth) > limit) {
                        self.ends.push(self.projected.len() as u32);
                        return;
                    }
                    let mut placed = [nothing; CHUNK];
                    filling.place(n * CHUNK, &mut placed[..chunk.len()]);
                    self.chunk_min_depths.push(chunk_min_depth);
                    self.projected.extend(placed.map(|p| p.record));
                    self.details.extend(placed.map(|p| p.detail));
                    self.depths.extend(placed.map(|p| p.depth));
                }
            }
            rest = later;
            batch *= 2;
        }
        self.ends.push(self.projected.len() as u32);
    }
}

/// An empty vector with capacity for `n` values.
fn empty<T: Send + 'static>(n: usize, pool: &Pool) -> Vec<T> {
    let mut vector = pool.take(n);
    vector.clear();
    vector.reserve(n);
    vector
}
