//! The bins of spheres, scattered to the squares of tiles that share a list.

use crate::certify::entry::{Bin, ordered};
use crate::tile::TILE;
use halfline_ground::memory::Pool;
use halfline_ground::parallel;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Squares of 2^level tiles that share a list, called cells, as far as they overlap the window.
#[derive(Debug, Clone, Copy)]
pub(in crate::certify) struct Grid {
    pub(super) level: u32,
    /// First and last column of the window's tiles.
    tiles: [u32; 2],
    /// First column and row of cells.
    first: [u32; 2],
    /// Number of columns and rows of cells.
    pub(super) columns: u32,
    pub(super) rows: u32,
}

impl Grid {
    /// The grid for the window of these tiles, given by first and last column and row.
    pub(in crate::certify) fn new(level: u32, tiles: [[u32; 2]; 2]) -> Self {
        let cells = tiles.map(|range| range.map(|tile| tile >> level));
        let [columns, rows] = cells.map(|[first, last]| last - first + 1);
        Self { level, tiles: tiles[0], first: cells.map(|[first, _]| first), columns, rows }
    }

    /// Number of cells.
    pub(in crate::certify) fn cells(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Index of the cell of the tile at this column and row of tiles.
    pub(in crate::certify) fn cell(&self, column: u32, row: u32) -> usize {
        let [left, top] = self.first;
        (((row >> self.level) - top) * self.columns + ((column >> self.level) - left)) as usize
    }

    /// Row and column of the first pixel of every tile of the window, row by row, that `count` rows of pixels from `first` on
    /// overlap.
    pub(in crate::certify) fn corners(&self, first: u32, count: u32) -> impl Iterator<Item = [u32; 2]> {
        let [left, right] = self.tiles;
        let rows = first / TILE..(first + count).div_ceil(TILE);
        rows.flat_map(move |row| (left..=right).map(move |tile| [row * TILE, tile * TILE]))
    }

    /// Every cell of the grid that the square of 2^`level` tiles at this column and row of such squares overlaps.
    pub(in crate::certify) fn each_of_square(&self, at: [u32; 2], level: u32, mut each: impl FnMut(usize)) {
        let tiles = at.map(|n| [n << level, (n << level) + ((1 << level) - 1)]);
        let [[left, right], [top, bottom]] = self.part(tiles);
        for row in top..bottom {
            (left..right).for_each(|column| each((row * self.columns + column) as usize));
        }
    }

    /// Column and row in the image of the cell at this column and row of the grid.
    pub(super) fn tile(&self, column: usize, row: usize) -> [u32; 2] {
        [self.first[0] + column as u32, self.first[1] + row as u32]
    }

    /// The columns and rows of the grid that these tiles overlap, first and last column and row, each with the one past the last; none if they are not in order.
    #[inline(always)]
    fn part(&self, tiles: [[u32; 2]; 2]) -> [[u32; 2]; 2] {
        let size = [self.columns, self.rows];
        let mut part = [[0; 2]; 2];
        for k in 0..2 {
            let [first, last] = tiles[k].map(|tile| tile >> self.level);
            let start = self.first[k];
            part[k] = [first.saturating_sub(start), (last + 1).saturating_sub(start).min(size[k])];
        }
        part
    }

    /// Keys of the spheres per row of cells.
    ///
    /// Not per cell: processors write to so few places at once fast, and sort the keys of a row in their caches.
    pub(super) fn scatter(&self, bins: &[Bin], pool: &Pool) -> Keys {
        // Each group has counters of its own, from which its positions in every row follow.
        let group = bins.len().div_ceil(2 * parallel::threads()).max(1);
        let count = |bins: &[Bin]| {
            let mut counts = vec![0u32; self.rows as usize];
            for bin in bins {
                let [[left, right], [top, bottom]] = self.part(bin.tiles);
                (top..bottom).for_each(|row| counts[row as usize] += right.saturating_sub(left));
            }
            counts
        };
        let mut places: Vec<Vec<u32>> = parallel::blocks(0..bins.len(), group, &|range, _| count(&bins[range]));
        let mut starts = Vec::with_capacity(self.rows as usize + 1);
        let mut total = 0;
        for row in 0..self.rows as usize {
            starts.push(total);
            for counts in &mut places {
                total += std::mem::replace(&mut counts[row], total);
            }
        }
        starts.push(total);
        let keys: Vec<AtomicU64> = pool.sized(total as usize);
        let columns: Vec<AtomicU32> = pool.sized(total as usize);
        parallel::fill(&mut places[..], 1, &|groups, places| {
            let (first, places) = (groups.start * group, &mut places[0]);
            for (id, bin) in (first..bins.len().min(first + group)).zip(&bins[first..]) {
                let key = u64::from(ordered(bin.chunk_min_depth)) << 32 | id as u64;
                let [[left, right], [top, bottom]] = self.part(bin.tiles);
                for row in top..bottom {
                    let place = &mut places[row as usize];
                    for column in left..right {
                        keys[*place as usize].store(key, Ordering::Relaxed);
                        columns[*place as usize].store(column, Ordering::Relaxed);
                        *place += 1;
                    }
                }
            }
        });
        Keys { keys, columns, starts }
    }
}

/// For every entry of a list, its sphere's least depth and id, in this order, and the column of its cell.
pub(super) struct Keys {
    keys: Vec<AtomicU64>,
    columns: Vec<AtomicU32>,
    /// The start of every row of cells, and the end of all.
    starts: Vec<u32>,
}

impl Keys {
    /// The keys of a row of so many cells, one cell after the other; and the start of each, and the end of all.
    pub(super) fn of_row(&self, row: usize, cells: usize, pool: &Pool) -> (Vec<u64>, Vec<u32>) {
        let range = self.starts[row] as usize..self.starts[row + 1] as usize;
        let (keys, columns) = (&self.keys[range.clone()], &self.columns[range]);
        // Counts are one place further, so that their sums are starts; and those end as the starts of the next cell.
        let mut starts = vec![0u32; cells + 2];
        columns.iter().for_each(|column| starts[column.load(Ordering::Relaxed) as usize + 2] += 1);
        for cell in 2..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut own = pool.sized(keys.len());
        for (key, column) in keys.iter().zip(columns) {
            let place = &mut starts[column.load(Ordering::Relaxed) as usize + 1];
            own[*place as usize] = key.load(Ordering::Relaxed);
            *place += 1;
        }
        starts.pop();
        (own, starts)
    }

    pub(super) fn put_back(self, pool: &Pool) {
        pool.put_back(self.keys);
        pool.put_back(self.columns);
    }
}
