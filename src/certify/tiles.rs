//! The projected spheres that the rays of a tile may hit, binned by their extent and sorted by depth.
//!
//! No tree is built: spheres are counted per cell, scattered by prefix sums, and each list is sorted incrementally from
//! the front and cut where all remaining spheres are certainly occluded. A list serves one tile of 8 x 8 pixels, or a
//! square of tiles if large spheres would make the lists of single tiles too long. With one list for the whole image,
//! every sphere is tested.

use super::projected::{ProjectedDetailRecord, ProjectedRecord};
use crate::memory::Pool;
use crate::tile::{CHUNK, TILE, WHOLE};
use crate::view::ray::NONE;
use bytemuck::allocation::try_zeroed_vec;
use rayon::prelude::*;
use std::alloc::{Layout, handle_alloc_error};
use std::sync::atomic::{AtomicU64, Ordering};

/// Entries beyond eight per sphere before tiles share their lists: 64 MiB.
const SPARE: u64 = 1 << 21;

/// Entries that are sorted first. Shorter lists skip the occlusion test, which would cost more than eight chunks per
/// tile.
const FOREMOST: usize = 64;

/// The padding of a list: far outside the image, with radius 0.
pub(crate) const NOTHING: ProjectedRecord = ProjectedRecord { x: 1 << 30, y: 1 << 30, rho: 0.0, low: 0.0 };
pub(crate) const NO_DETAIL: ProjectedDetailRecord =
    ProjectedDetailRecord { subpixel_offset: [0.0; 2], center: 0.0, id: NONE };

/// The representation of a projected sphere in a list.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    pub(crate) record: ProjectedRecord,
    pub(crate) detail: ProjectedDetailRecord,
}

/// The bin of a sphere.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable)]
pub(crate) struct Bin {
    /// Lower bound of the depth for every ray.
    pub(crate) chunk_min_depth: f32,
    /// First and last column and row of the tiles whose pixels may hit it.
    pub(crate) tiles: [[u32; 2]; 2],
}

impl Bin {
    /// The bin of a sphere that is in no list.
    pub(crate) const NOWHERE: Self = Self { chunk_min_depth: f32::MAX, tiles: [[u32::MAX, 0]; 2] };

    /// Number of lists that contain it, if squares of 2^level tiles share one.
    pub(crate) fn entries(&self, level: u32) -> u64 {
        let [columns, rows] =
            self.tiles.map(|[first, last]| (u64::from(last >> level) + 1).saturating_sub(u64::from(first >> level)));
        columns * rows
    }
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
    /// The records of the next spheres, at most [`CHUNK`].
    fn place(&mut self, ids: &[u32], to: &mut [Placed]);

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
        let (keys, starts) = grid.scatter(bins, pool);
        let lists = Self::gather(grid, &keys, &starts, placing, pool);
        pool.put_back(keys);
        lists
    }

    /// The range of entries for the tile that contains the pixel at `row` and `column`.
    pub(crate) fn range(&self, row: u32, column: u32) -> [u32; 2] {
        let cell = self.grid.cell(column / TILE, row / TILE);
        let first = cell.checked_sub(1).map_or(0, |before| self.ends[before]);
        [first, self.ends[cell]]
    }

    /// The same for every tile of the window, row by row, that `count` rows of pixels from `first` on overlap.
    pub(crate) fn rows(&self, first: u32, count: u32) -> impl Iterator<Item = [u32; 2]> {
        self.grid.corners(first, count).map(|[row, column]| self.range(row, column))
    }

    /// Level: squares of 2^level tiles share a list.
    #[cfg(test)]
    pub(crate) fn level(&self) -> u32 {
        self.grid.level
    }

    /// Creates the lists of every row of cells and concatenates them.
    fn gather(grid: Grid, keys: &[AtomicU64], starts: &[u32], placing: &impl Placing, pool: &Pool) -> Self {
        let columns = grid.columns as usize;
        let row = |i: usize| {
            let starts = &starts[i * columns..=(i + 1) * columns];
            let mut row = Row::with_capacity((starts[columns] - starts[0]) as usize + columns * CHUNK, pool);
            let mut own = Vec::new();
            for (j, pair) in starts.windows(2).enumerate() {
                own.clear();
                own.extend(keys[pair[0] as usize..pair[1] as usize].iter().map(|key| key.load(Ordering::Relaxed)));
                let tile = (grid.level == 0 && own.len() > FOREMOST).then_some(grid.tile(j, i));
                row.fill(&mut own, &mut placing.begin(tile));
            }
            row
        };
        let made: Vec<Row> = (0..grid.rows as usize).into_par_iter().map(row).collect();
        let total = made.iter().map(|row| row.projected.len()).sum();
        let mut ends = Vec::with_capacity(starts.len());
        let (mut projected, mut details) = (sized(total, pool), sized(total, pool));
        let mut chunk_min_depths: Vec<f32> = sized(total / CHUNK, pool);
        let mut jobs = Vec::with_capacity(made.len());
        let (mut record, mut detail, mut chunk_min_depth) =
            (&mut projected[..], &mut details[..], &mut chunk_min_depths[..]);
        let mut first = 0;
        for row in made {
            ends.extend(row.ends.iter().map(|end| first + end));
            let size = row.projected.len();
            first += size as u32;
            let (of_projected, rest) = record.split_at_mut(size);
            record = rest;
            let (of_details, rest) = detail.split_at_mut(size);
            detail = rest;
            let (of_depths, rest) = chunk_min_depth.split_at_mut(size / CHUNK);
            chunk_min_depth = rest;
            jobs.push((row, of_projected, of_details, of_depths));
        }
        jobs.into_par_iter().for_each(|(row, projected, details, chunk_min_depths)| {
            projected.copy_from_slice(&row.projected);
            details.copy_from_slice(&row.details);
            chunk_min_depths.copy_from_slice(&row.chunk_min_depths);
            row.put_back(pool);
        });
        Self { grid, ends, projected, details, chunk_min_depths }
    }
}

/// The lists of a row of cells, with indices relative to its start.
struct Row {
    ends: Vec<u32>,
    projected: Vec<ProjectedRecord>,
    details: Vec<ProjectedDetailRecord>,
    chunk_min_depths: Vec<f32>,
}

impl Row {
    fn with_capacity(entries: usize, pool: &Pool) -> Self {
        Self {
            ends: Vec::new(),
            projected: empty(entries, pool),
            details: empty(entries, pool),
            chunk_min_depths: empty(entries / CHUNK, pool),
        }
    }

    fn put_back(self, pool: &Pool) {
        pool.put_back(self.projected);
        pool.put_back(self.details);
        pool.put_back(self.chunk_min_depths);
    }

    /// Appends the list of these keys: in order, as far as needed, padded.
    fn fill(&mut self, keys: &mut [u64], filling: &mut impl Filling) {
        let nothing = Placed { record: NOTHING, detail: NO_DETAIL };
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
            for chunk in now.chunks(CHUNK) {
                let chunk_min_depth = number((chunk[0] >> 32) as u32);
                if filling.limit().is_some_and(|limit| f64::from(chunk_min_depth) > limit) {
                    self.ends.push(self.projected.len() as u32);
                    return;
                }
                let mut ids = [0; CHUNK];
                ids.iter_mut().zip(chunk).for_each(|(id, key)| *id = *key as u32);
                let mut placed = [nothing; CHUNK];
                filling.place(&ids[..chunk.len()], &mut placed[..chunk.len()]);
                self.chunk_min_depths.push(chunk_min_depth);
                self.projected.extend(placed.map(|p| p.record));
                self.details.extend(placed.map(|p| p.detail));
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

/// `n` values, all of which the caller writes.
pub(super) fn sized<T: bytemuck::Zeroable + Send + 'static>(n: usize, pool: &Pool) -> Vec<T> {
    let mut vector = pool.take(n);
    if vector.is_empty() {
        // Reports a failed allocation as any vector here does; `zeroed_vec` would panic.
        let room = Layout::array::<T>(n).unwrap_or(Layout::new::<T>());
        return try_zeroed_vec(n).unwrap_or_else(|()| handle_alloc_error(room));
    }
    vector.resize_with(n, T::zeroed);
    vector
}

/// Squares of 2^level tiles that share a list, called cells, as far as they overlap the window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    level: u32,
    /// First and last column of the window's tiles.
    tiles: [u32; 2],
    /// First column and row of cells.
    first: [u32; 2],
    /// Number of columns and rows of cells.
    columns: u32,
    rows: u32,
}

impl Grid {
    /// The grid for the window of these tiles, given by first and last column and row.
    pub(super) fn new(level: u32, tiles: [[u32; 2]; 2]) -> Self {
        let cells = tiles.map(|range| range.map(|tile| tile >> level));
        let [columns, rows] = cells.map(|[first, last]| last - first + 1);
        Self { level, tiles: tiles[0], first: cells.map(|[first, _]| first), columns, rows }
    }

    /// Number of cells.
    pub(super) fn cells(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Index of the cell of the tile at this column and row of tiles.
    pub(super) fn cell(&self, column: u32, row: u32) -> usize {
        let [left, top] = self.first;
        (((row >> self.level) - top) * self.columns + ((column >> self.level) - left)) as usize
    }

    /// Row and column of the first pixel of every tile of the window, row by row, that `count` rows of pixels from `first` on
    /// overlap.
    pub(super) fn corners(&self, first: u32, count: u32) -> impl Iterator<Item = [u32; 2]> {
        let [left, right] = self.tiles;
        let rows = first / TILE..(first + count).div_ceil(TILE);
        rows.flat_map(move |row| (left..=right).map(move |tile| [row * TILE, tile * TILE]))
    }

    /// Every cell of the grid that the square of 2^`level` tiles at this column and row of such squares overlaps.
    pub(super) fn each_of_square(&self, at: [u32; 2], level: u32, each: impl FnMut(usize)) {
        let tiles = at.map(|n| [n << level, (n << level) + ((1 << level) - 1)]);
        self.each_cell(&Bin { chunk_min_depth: 0.0, tiles }, each);
    }

    /// Column and row in the image of the cell at this column and row of the grid.
    fn tile(&self, column: usize, row: usize) -> [u32; 2] {
        [self.first[0] + column as u32, self.first[1] + row as u32]
    }

    /// Every cell of the grid that `bin` overlaps.
    #[inline(always)]
    fn each_cell(&self, bin: &Bin, mut each: impl FnMut(usize)) {
        let [[left, right], [top, bottom]] = bin.tiles.map(|range| range.map(|tile| tile >> self.level));
        let [first_column, first_row] = self.first;
        let (left, right) = (left.max(first_column), right.min(first_column + self.columns - 1));
        let (mut row, bottom) = (top.max(first_row), bottom.min(first_row + self.rows - 1));
        while row <= bottom {
            let before = (row - first_row) * self.columns;
            (left..=right).for_each(|column| each((before + column - first_column) as usize));
            row += 1;
        }
    }

    /// Keys of the spheres per cell, sorted by depth and then id; the start of each cell's keys, and the end of all.
    fn scatter(&self, bins: &[Bin], pool: &Pool) -> (Vec<AtomicU64>, Vec<u32>) {
        // Each group has counters of its own, from which its positions in every cell follow.
        let group = bins.len().div_ceil(2 * rayon::current_num_threads()).max(1);
        let cells = (self.columns * self.rows) as usize;
        let count = |bins: &[Bin]| {
            let mut counts = vec![0u32; cells];
            bins.iter().for_each(|bin| self.each_cell(bin, |cell| counts[cell] += 1));
            counts
        };
        let mut places: Vec<Vec<u32>> = bins.par_chunks(group).map(count).collect();
        let mut starts = Vec::with_capacity(cells + 1);
        let mut total = 0;
        for cell in 0..cells {
            starts.push(total);
            for counts in &mut places {
                total += std::mem::replace(&mut counts[cell], total);
            }
        }
        starts.push(total);
        let keys: Vec<AtomicU64> = sized(total as usize, pool);
        bins.par_chunks(group).zip(&mut places).enumerate().for_each(|(n, (bins, places))| {
            for (id, bin) in (n * group..).zip(bins) {
                let key = u64::from(ordered(bin.chunk_min_depth)) << 32 | id as u64;
                self.each_cell(bin, |cell| {
                    keys[places[cell] as usize].store(key, Ordering::Relaxed);
                    places[cell] += 1;
                });
            }
        });
        (keys, starts)
    }
}

/// The bits of x as an integer with the same order.
pub(super) fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The inverse.
pub(super) fn number(ordered: u32) -> f32 {
    f32::from_bits(if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !ordered })
}
