//! Which front spheres the rays of a tile may meet: binned by what they surely cover, nearest first.
//!
//! No tree: count, add up, scatter, sort each list. A list serves one tile of 8 x 8 pixels, or a square of tiles where
//! large spheres would make lists of single tiles too long; one list for all is the search `all`.

use super::front::{FrontMoreRecord, FrontRecord};
use crate::memory::Pool;
use crate::ray::NONE;
use bytemuck::allocation::zeroed_vec;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Pixels along a side of a tile, which is a workgroup; a layout test holds it against the shaders.
pub(crate) const TILE: u32 = 8;

/// Entries that share a sill, and that lists are padded to: what the largest sharing subgroup loads at once.
pub(crate) const CHUNK: usize = 8;

/// Spheres that are prepared together: their places among each other fit 16 bits.
pub(crate) const TOGETHER: usize = 1 << 16;

/// The level at which every image is one square of tiles.
pub(crate) const WHOLE: u32 = 31;

/// Entries that may be spent beyond eight for each sphere before tiles share their lists: 64 MiB.
const SPARE: u64 = 1 << 21;

/// What fills a list up: far outside the image, with no radius.
pub(crate) const NOTHING: FrontRecord = FrontRecord { x: 1 << 30, y: 1 << 30, rho: 0.0, low: 0.0 };
pub(crate) const NOTHING_MORE: FrontMoreRecord = FrontMoreRecord { rest: [0.0; 2], center: 0.0, id: NONE };

/// What becomes of a front sphere in a list.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    pub(crate) front: FrontRecord,
    pub(crate) more: FrontMoreRecord,
}

/// Where it belongs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bin {
    /// No ray is given a lower bound of depth below this.
    pub(crate) sill: f32,
    /// First and last column and row of the tiles in which a pixel's ray may hit.
    pub(crate) tiles: [[u32; 2]; 2],
}

/// Front spheres that were prepared together, at most [`TOGETHER`]: binning reads the bins alone, sphere by sphere.
#[derive(Debug, Default)]
pub(crate) struct Run {
    pub(crate) placed: Vec<Placed>,
    pub(crate) bins: Vec<Bin>,
}

impl Run {
    pub(crate) fn with_capacity(spheres: usize, pool: &Pool) -> Self {
        Self { placed: empty(spheres, pool), bins: empty(spheres, pool) }
    }
}

/// An empty vector with room for `n`.
fn empty<T: Send + 'static>(n: usize, pool: &Pool) -> Vec<T> {
    let mut vector = pool.take(n);
    vector.clear();
    vector.reserve(n);
    vector
}

/// The candidates of every tile.
#[derive(Debug, Clone)]
pub(crate) struct Lists {
    grid: Grid,
    /// One past the last entry of every cell of the grid; the next cell's begin there.
    ends: Vec<u32>,
    /// What every candidate is asked.
    pub(crate) fronts: Vec<FrontRecord>,
    /// What only a winner is asked.
    pub(crate) mores: Vec<FrontMoreRecord>,
    /// Of every [`CHUNK`] entries: nobody in it, or behind it in its list, has a lower bound of depth below this.
    pub(crate) sills: Vec<f32>,
}

impl Lists {
    /// Bins the spheres of `runs` for an image of `size` pixels. Squares of 2^`level` tiles, or
    /// larger ones, share a list.
    pub(crate) fn new(runs: &[Run], size: [u32; 2], level: u32, pool: &Pool) -> Self {
        let tiles = size.map(|n| n.div_ceil(TILE));
        let count: usize = runs.iter().map(|run| run.bins.len()).sum();
        let fits = |level: &u32| *level >= WHOLE || entries(runs, *level) <= 8 * count as u64 + SPARE;
        let level = (level..=WHOLE).find(fits).unwrap_or(WHOLE);
        let [columns, rows] = tiles.map(|n| ((n - 1) >> level) + 1);
        let grid = Grid { level, tiles: tiles[0], columns, rows };
        let (keys, starts) = grid.scatter(runs, pool);
        let lists = Self::gather(grid, runs, &keys, &starts, pool);
        pool.give(keys);
        lists
    }

    /// The entries of the tile that holds the pixel of `row` and `column`: the first, and the one past the last.
    pub(crate) fn range(&self, row: u32, column: u32) -> [u32; 2] {
        let cell = self.grid.cell(column / TILE, row / TILE);
        let first = cell.checked_sub(1).map_or(0, |before| self.ends[before]);
        [first, self.ends[cell]]
    }

    /// The same for every tile, row by row, that `count` rows of pixels touch from row `first` on, a multiple of
    /// [`TILE`].
    pub(crate) fn rows(&self, first: u32, count: u32) -> impl Iterator<Item = [u32; 2]> {
        let rows = (first..first + count).step_by(TILE as usize);
        rows.flat_map(move |row| (0..self.grid.tiles).map(move |tile| self.range(row, tile * TILE)))
    }

    /// Sorts each list and writes it out, padded.
    fn gather(grid: Grid, runs: &[Run], keys: &[AtomicU64], starts: &[u32], pool: &Pool) -> Self {
        let mut ends = Vec::with_capacity(starts.len());
        let mut end = 0;
        for pair in starts.windows(2) {
            end += (pair[1] - pair[0]).next_multiple_of(CHUNK as u32);
            ends.push(end);
        }
        let total = end as usize;
        let (mut fronts, mut mores) = (sized(total, pool), sized(total, pool));
        let mut sills: Vec<f32> = sized(total / CHUNK, pool);
        let mut jobs = Vec::with_capacity(ends.len());
        let (mut front, mut more, mut sill) = (&mut fronts[..], &mut mores[..], &mut sills[..]);
        let mut first = 0;
        for (pair, &end) in starts.windows(2).zip(&ends) {
            let size = (end - first) as usize;
            first = end;
            if size > 0 {
                let own;
                (own, front) = front.split_at_mut(size);
                let (of_mores, rest) = more.split_at_mut(size);
                more = rest;
                let (of_sills, rest) = sill.split_at_mut(size / CHUNK);
                sill = rest;
                jobs.push((&keys[pair[0] as usize..pair[1] as usize], own, of_mores, of_sills));
            }
        }
        jobs.into_par_iter().for_each_init(Vec::new, |sorted: &mut Vec<u64>, (keys, fronts, mores, sills)| {
            sorted.clear();
            sorted.extend(keys.iter().map(|key| key.load(Ordering::Relaxed)));
            if sorted.len() > TOGETHER {
                sorted.par_sort_unstable()
            } else {
                sorted.sort_unstable()
            }
            fronts[keys.len()..].fill(NOTHING);
            mores[keys.len()..].fill(NOTHING_MORE);
            for (n, &key) in sorted.iter().enumerate() {
                let run = &runs[(key as u32 >> 16) as usize];
                let place = (key & 0xffff) as usize;
                (fronts[n], mores[n]) = (run.placed[place].front, run.placed[place].more);
                if n % CHUNK == 0 {
                    sills[n / CHUNK] = run.bins[place].sill;
                }
            }
        });
        Self { grid, ends, fronts, mores, sills }
    }
}

/// `n` values, all of which are to be written.
fn sized<T: bytemuck::Zeroable + Clone + Send + 'static>(n: usize, pool: &Pool) -> Vec<T> {
    let mut vector = pool.take(n);
    if vector.is_empty() {
        return zeroed_vec(n);
    }
    vector.resize(n, T::zeroed());
    vector
}

/// Entries of all lists if squares of 2^level tiles share one.
fn entries(runs: &[Run], level: u32) -> u64 {
    let cells = |[first, last]: [u32; 2]| u64::from((last >> level) - (first >> level) + 1);
    runs.par_iter().flat_map_iter(|run| &run.bins).map(|p| cells(p.tiles[0]) * cells(p.tiles[1])).sum()
}

/// Squares of 2^level tiles a side that share a list: cells.
#[derive(Debug, Clone, Copy)]
struct Grid {
    level: u32,
    /// Tiles in a row; cells in a row and in a column.
    tiles: u32,
    columns: u32,
    rows: u32,
}

impl Grid {
    fn cell(&self, column: u32, row: u32) -> usize {
        ((row >> self.level) * self.columns + (column >> self.level)) as usize
    }

    /// Every cell that `bin` covers.
    fn cells(&self, bin: &Bin) -> impl Iterator<Item = usize> + use<> {
        let [[left, right], [top, bottom]] = bin.tiles.map(|range| range.map(|tile| tile >> self.level));
        let columns = self.columns;
        (top..=bottom).flat_map(move |row| (left..=right).map(move |column| (row * columns + column) as usize))
    }

    /// Keys of the spheres, sill first and then place, cell by cell; and where each cell's begin, with the end of all.
    fn scatter(&self, runs: &[Run], pool: &Pool) -> (Vec<AtomicU64>, Vec<u32>) {
        // Each group of runs counts for itself, so that each knows its own places in every cell.
        let group = runs.len().div_ceil(2 * rayon::current_num_threads()).max(1);
        let cells = (self.columns * self.rows) as usize;
        let count = |runs: &[Run]| {
            let mut counts = vec![0u32; cells];
            runs.iter().flat_map(|run| &run.bins).for_each(|p| self.cells(p).for_each(|cell| counts[cell] += 1));
            counts
        };
        let mut places: Vec<Vec<u32>> = runs.par_chunks(group).map(count).collect();
        let mut starts = Vec::with_capacity(cells + 1);
        let mut total = 0;
        for cell in 0..cells {
            starts.push(total);
            for counts in &mut places {
                total += std::mem::replace(&mut counts[cell], total);
            }
        }
        starts.push(total);
        let mut keys: Vec<AtomicU64> = pool.take(total as usize);
        keys.resize_with(total as usize, AtomicU64::default);
        runs.par_chunks(group).zip(&mut places).enumerate().for_each(|(n, (runs, places))| {
            for (run, own) in runs.iter().enumerate() {
                for (at, p) in own.bins.iter().enumerate() {
                    let slot = ((n * group + run) << 16 | at) as u64;
                    let key = u64::from(ordered(p.sill)) << 32 | slot;
                    for cell in self.cells(p) {
                        keys[places[cell] as usize].store(key, Ordering::Relaxed);
                        places[cell] += 1;
                    }
                }
            }
        });
        (keys, starts)
    }
}

/// The bits of x, ordered like the numbers.
fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}
