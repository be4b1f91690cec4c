//! The general spheres that the rays of a tile may hit first, from a quadtree of tiles. A cell drops the spheres of its
//! parent that lie behind a sphere which certainly covers the cell. cell.rs bounds their depths; docs/certificate.md,
//! section 3b, shows that the frame keeps its bits.

mod cell;

use super::general::{General, GeneralRecord};
use super::projection::ProjectionBounds;
use super::tiles::Grid;
use crate::tile::TILE;
use cell::TileBlock;
use halfline_ground::parallel;

/// Slots of one level of cells beyond eight per sphere: 8 MiB. A cell whose list is longer than its share of them is not
/// divided further.
const SPARE: usize = 1 << 21;

/// The general spheres of every tile.
#[derive(Debug, Clone)]
pub(crate) struct GeneralLists {
    grid: Grid,
    /// The range in `slots` of every cell of the grid; empty without general spheres.
    ranges: Vec<[u32; 2]>,
    /// Places among the general spheres, ascending in every list. Several cells may share a list.
    pub(crate) slots: Vec<u32>,
}

/// A square of 2^level tiles with its list.
struct Node {
    /// Column and row among the squares of its level.
    at: [u32; 2],
    level: u32,
    slots: Vec<u32>,
}

/// The data of a frame from which the list of every cell is made.
pub(in crate::certify) struct GeneralTree<'a> {
    projection: &'a ProjectionBounds,
    /// Columns and rows of tiles of the image.
    tiles: [u32; 2],
    spheres: Vec<General<f64>>,
    /// The cull margin: a sphere is left out where it lies farther than this behind one that covers the cell, relative
    /// to that one's depth.
    margin: f64,
}

impl<'a> GeneralTree<'a> {
    /// The tree for an image of `size` pixels with this cull margin, infinite where nothing hides a sphere.
    pub(in crate::certify) fn new(
        projection: &'a ProjectionBounds,
        generals: &[GeneralRecord],
        size: [u32; 2],
        margin: f64,
    ) -> Self {
        let spheres = generals.iter().map(General::new).collect();
        Self { projection, tiles: size.map(|n| n.div_ceil(TILE)), spheres, margin }
    }

    /// The rays of a square of 2^`level` tiles.
    fn cell(&self, level: u32, at: [u32; 2]) -> TileBlock {
        let ends = [0, 1].map(|k| ((at[k] + 1) << level).min(self.tiles[k]));
        TileBlock::new(self.projection, at.map(|n| n << level), ends)
    }

    /// The spheres of `slots` that rays of the cell may hit first.
    fn kept(&self, level: u32, at: [u32; 2], slots: &[u32]) -> Vec<u32> {
        self.cell(level, at).kept(&self.spheres, slots, self.margin)
    }

    /// The bounds of depth of every general sphere for the rays of a square of 2^`level` tiles.
    #[cfg(test)]
    pub(in crate::certify) fn depths(&self, level: u32, at: [u32; 2]) -> Vec<[f64; 2]> {
        self.cell(level, at).all_depths(&self.spheres)
    }

    /// The lists for squares of 2^`level` tiles that overlap `tiles` (first and last column and row).
    pub(in crate::certify) fn lists(&self, tiles: [[u32; 2]; 2], level: u32) -> GeneralLists {
        let grid = Grid::new(level, tiles);
        if self.spheres.is_empty() {
            return GeneralLists { grid, ranges: Vec::new(), slots: Vec::new() };
        }
        let [columns, rows] = self.tiles;
        let mut top = columns.max(rows).next_power_of_two().ilog2().max(level);
        let most = 8 * self.spheres.len() + SPARE;
        let (shift, all) = (top, (0..self.spheres.len() as u32).collect::<Vec<_>>());
        let mut open = vec![Node { at: [0; 2], level: top, slots: self.kept(top, [0; 2], &all) }];
        let mut done = Vec::new();
        while top > level && !open.is_empty() {
            top -= 1;
            let made = parallel::collect(open.len(), 1, &|nodes, made| {
                open[nodes].iter().for_each(|node| made.extend(self.children(node, tiles)));
            });
            // The share of a cell among all cells of the image, so that it is the same for every window.
            let share = most >> (2 * (shift - top)).min(63);
            let (ended, divided): (Vec<_>, Vec<_>) =
                made.into_iter().partition(|node| node.slots.len() <= 1 || node.slots.len() > share);
            done.extend(ended);
            open = divided;
        }
        done.extend(open);
        GeneralLists::laid_out(grid, &done)
    }

    /// The quarters of a cell that overlap the window of these tiles.
    fn children<'b>(&'b self, node: &'b Node, tiles: [[u32; 2]; 2]) -> impl Iterator<Item = Node> + 'b {
        let level = node.level - 1;
        let [[left, right], [top, bottom]] = tiles.map(|range| range.map(|tile| tile >> level));
        let quarters = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| [2 * node.at[0] + x, 2 * node.at[1] + y]);
        let inside = move |at: &[u32; 2]| (left..=right).contains(&at[0]) && (top..=bottom).contains(&at[1]);
        let child = move |at| Node { at, level, slots: self.kept(level, at, &node.slots) };
        quarters.into_iter().filter(inside).map(child)
    }
}

impl GeneralLists {
    /// One list of all `count` general spheres for every tile of the window.
    #[cfg(test)]
    pub(crate) fn all(count: usize, tiles: [[u32; 2]; 2]) -> Self {
        let grid = Grid::new(crate::tile::WHOLE, tiles);
        Self { grid, ranges: vec![[0, count as u32]], slots: (0..count as u32).collect() }
    }

    /// The lists of `nodes` in the order of the grid's cells.
    fn laid_out(grid: Grid, nodes: &[Node]) -> Self {
        let mut of_cell = vec![u32::MAX; grid.cells()];
        for (n, node) in nodes.iter().enumerate() {
            grid.each_of_square(node.at, node.level, |cell| of_cell[cell] = n as u32);
        }
        let mut placed = vec![[0; 2]; nodes.len()];
        let mut slots = Vec::new();
        let mut range = |n: u32| {
            let (Some(range), Some(node)) = (placed.get_mut(n as usize), nodes.get(n as usize)) else { return [0; 2] };
            if *range == [0; 2] && !node.slots.is_empty() {
                let first = slots.len() as u32;
                slots.extend_from_slice(&node.slots);
                *range = [first, slots.len() as u32];
            }
            *range
        };
        let ranges = of_cell.into_iter().map(&mut range).collect();
        Self { grid, ranges, slots }
    }

    /// The range in `slots` for the tile that contains the pixel at `row` and `column`.
    pub(crate) fn range(&self, row: u32, column: u32) -> [u32; 2] {
        self.ranges.get(self.grid.cell(column / TILE, row / TILE)).copied().unwrap_or_default()
    }

    /// The places of the general spheres that the rays of this pixel may hit first.
    pub(crate) fn of(&self, row: u32, column: u32) -> &[u32] {
        let [first, end] = self.range(row, column).map(|n| n as usize);
        &self.slots[first..end]
    }

    /// The range in `slots` of every tile of the window, row by row, that `count` rows of pixels from `first` on overlap.
    pub(crate) fn rows(&self, first: u32, count: u32) -> impl Iterator<Item = [u32; 2]> {
        self.grid.corners(first, count).map(|[row, column]| self.range(row, column))
    }
}
