//! The projected spheres that the rays of a tile may hit, binned by their extent and sorted by depth.
//!
//! No tree is built: spheres are counted per cell, scattered by prefix sums, and each list is sorted incrementally from
//! the front and cut where all remaining spheres are certainly occluded. A list serves one tile of 8 x 8 pixels, or a
//! square of tiles if large spheres would make the lists of single tiles too long. With one list for the whole image,
//! every sphere is tested.

mod grid;

pub(crate) use super::entry::Placed;
pub(super) use grid::Grid;

use super::entry::{Bin, number};
use super::projected::{ProjectedDetailRecord, ProjectedRecord};
use super::records::{AHEAD, ListRecords, RecordMaker};
use crate::tile::{CHUNK, TILE, WHOLE};
use crate::view::ray::NONE;
use bytemuck::Zeroable;
use grid::Keys;
use halfline_ground::memory::Pool;
use halfline_ground::parallel;
use pulp::NullaryFnOnce;

/// Entries beyond eight per sphere before tiles share their lists: 64 MiB.
const SPARE: u64 = 1 << 21;

/// The most entries of so many spheres before tiles share their lists.
fn most_entries(spheres: u64) -> u64 {
    (8 * spheres + SPARE).min(u64::from(u32::MAX))
}

/// Entries that are sorted first. Shorter lists skip the occlusion test, which would cost more than eight chunks per
/// tile.
const FOREMOST: usize = 64;

/// The padding of a list: far outside the image, with radius 0.
pub(crate) const NOTHING: ProjectedRecord = ProjectedRecord { x: 1 << 30, y: 1 << 30, rho: 0.0, low: 0.0 };
pub(crate) const NO_DETAIL: ProjectedDetailRecord =
    ProjectedDetailRecord { subpixel_offset: [0.0; 2], center: 0.0, id: NONE };
const PADDING: Placed = Placed { record: NOTHING, detail: NO_DETAIL, depth: 0.0 };

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
    /// last column and row). So each list equals the list of the whole image.
    pub(super) fn new(
        bins: &[Bin],
        single: u64,
        tiles: [[u32; 2]; 2],
        level: u32,
        maker: &RecordMaker<'_>,
        pool: &Pool,
    ) -> Self {
        let most = most_entries(bins.len() as u64);
        let entries = |level: u32| match level {
            0 => single,
            _ => Bin::total(bins, level),
        };
        let fits = |level: &u32| *level >= WHOLE || entries(*level) <= most;
        let level = (level..=WHOLE).find(fits).unwrap_or(WHOLE);
        let grid = Grid::new(level, tiles);
        let keys = grid.scatter(bins, pool);
        let lists = Self::gather(grid, &keys, maker, pool);
        keys.put_back(pool);
        lists
    }

    /// The lists of some tiles of the window, in the order of their cells: pairs of a tile (column and row) and its spheres.
    /// All other tiles have none.
    pub(crate) fn of_tiles(tiles: [[u32; 2]; 2], some: &[([u32; 2], Vec<Placed>)]) -> Self {
        let grid = Grid::new(0, tiles);
        let mut all = Self::with_capacity(grid, 0, &Pool::default());
        all.ends = vec![0; grid.cells()];
        for ([column, row], list) in some {
            for some in list.chunks(CHUNK) {
                let mut chunk = [PADDING; CHUNK];
                chunk[..some.len()].copy_from_slice(some);
                // Lists are not sorted, so no chunk is behind another.
                all.push(&chunk, f32::MIN);
            }
            all.ends[grid.cell(*column, *row)] = all.projected.len() as u32;
        }
        let mut end = 0;
        for own in &mut all.ends {
            end = end.max(*own);
            *own = end;
        }
        all
    }

    /// The number of entries that so many spheres have where tiles have 1/`finer` of their area: lists of single tiles grow with it
    /// until tiles share lists.
    pub(crate) fn entries(&self, spheres: u64, finer: u64) -> u64 {
        let entries = self.projected.len() as u64;
        entries.max(entries.saturating_mul(finer).min(most_entries(spheres)))
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
        self.grid.level
    }

    /// Creates the lists of every row of cells and concatenates them.
    fn gather(grid: Grid, keys: &Keys, maker: &RecordMaker<'_>, pool: &Pool) -> Self {
        let arch = pulp::Arch::new();
        let row = |i: usize| arch.dispatch(Cells { grid, keys, i, maker, pool });
        let rows = parallel::blocks(0..grid.rows as usize, 1, &|rows, _| row(rows.start));
        let mut ends = Vec::with_capacity(grid.cells());
        let mut first = 0;
        for row in &rows {
            ends.extend(row.ends.iter().map(|end| first + end));
            first += row.projected.len() as u32;
        }
        let all = Self {
            grid,
            ends,
            projected: concatenated(&rows, |row| &row.projected, pool),
            details: concatenated(&rows, |row| &row.details, pool),
            depths: concatenated(&rows, |row| &row.depths, pool),
            chunk_min_depths: concatenated(&rows, |row| &row.chunk_min_depths, pool),
        };
        rows.into_iter().for_each(|row| row.put_back(pool));
        all
    }

    /// No lists yet, with capacity for `entries`.
    fn with_capacity(grid: Grid, entries: usize, pool: &Pool) -> Self {
        Self {
            grid,
            ends: Vec::new(),
            projected: empty(entries, pool),
            details: empty(entries, pool),
            depths: empty(entries, pool),
            chunk_min_depths: empty(entries / CHUNK, pool),
        }
    }

    /// Returns their memory to the pool for the next frame.
    pub(super) fn put_back(self, pool: &Pool) {
        pool.put_back(self.projected);
        pool.put_back(self.details);
        pool.put_back(self.depths);
        pool.put_back(self.chunk_min_depths);
    }

    /// Appends a chunk.
    #[inline(always)]
    fn push(&mut self, chunk: &[Placed; CHUNK], chunk_min_depth: f32) {
        self.chunk_min_depths.push(chunk_min_depth);
        self.projected.extend(chunk.map(|p| p.record));
        self.details.extend(chunk.map(|p| p.detail));
        self.depths.extend(chunk.map(|p| p.depth));
    }

    /// Appends the entries of these keys: in order, as far as needed, padded.
    #[inline(always)]
    fn fill(&mut self, keys: &mut [u64], records: &mut ListRecords<'_>) {
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
                let mut numbers = [0; AHEAD];
                numbers.iter_mut().zip(group).for_each(|(number, key)| *number = *key as u32);
                records.fetch(&numbers[..group.len()]);
                for (n, chunk) in group.chunks(CHUNK).enumerate() {
                    let chunk_min_depth = number((chunk[0] >> 32) as u32);
                    if records.limit().is_some_and(|limit| f64::from(chunk_min_depth) > limit) {
                        return;
                    }
                    let mut placed = [PADDING; CHUNK];
                    records.place(n, &mut placed[..chunk.len()]);
                    self.push(&placed, chunk_min_depth);
                }
            }
            rest = later;
            batch *= 2;
        }
    }
}

/// The values of all rows, one after the other.
fn concatenated<T: Zeroable + Copy + Send + Sync + 'static>(
    rows: &[Lists],
    values: impl Fn(&Lists) -> &[T],
    pool: &Pool,
) -> Vec<T> {
    let mut all = pool.sized(rows.iter().map(|row| values(row).len()).sum());
    let mut rest = &mut all[..];
    let mut pairs = Vec::with_capacity(rows.len());
    for values in rows.iter().map(values) {
        let (to, after) = rest.split_at_mut(values.len());
        pairs.push((to, values));
        rest = after;
    }
    parallel::fill(&mut pairs[..], 1, &|_, pairs| pairs.iter_mut().for_each(|(to, values)| to.copy_from_slice(values)));
    all
}

/// A row of cells whose lists are made.
struct Cells<'a> {
    grid: Grid,
    keys: &'a Keys,
    i: usize,
    maker: &'a RecordMaker<'a>,
    pool: &'a Pool,
}

impl NullaryFnOnce for Cells<'_> {
    type Output = Lists;

    #[inline(always)]
    fn call(self) -> Lists {
        let Self { grid, keys, i, maker, pool } = self;
        let columns = grid.columns as usize;
        let (mut own, starts) = keys.of_row(i, columns, pool);
        let mut row = Lists::with_capacity(grid, own.len() + columns * CHUNK, pool);
        let mut records = maker.lists();
        for (j, pair) in starts.windows(2).enumerate() {
            let own = &mut own[pair[0] as usize..pair[1] as usize];
            if !own.is_empty() {
                let tile = (grid.level == 0 && own.len() > FOREMOST).then_some(grid.tile(j, i));
                records.begin(tile);
                row.fill(own, &mut records);
            }
            row.ends.push(row.projected.len() as u32);
        }
        pool.put_back(own);
        row
    }
}

/// An empty vector with capacity for `n` values.
fn empty<T: Send + 'static>(n: usize, pool: &Pool) -> Vec<T> {
    let mut vector = pool.take(n);
    vector.clear();
    vector.reserve(n);
    vector
}
