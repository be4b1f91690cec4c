//! The entry of a sphere in the lists of tiles: where it lies, and its records.

use super::projected::{ProjectedDetailRecord, ProjectedRecord};
use halfline_ground::parallel::{self, CHEAP};
use std::ops::Range;

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

    /// Number of entries of all bins.
    pub(crate) fn total(bins: &[Self], level: u32) -> u64 {
        let some = |range: Range<usize>| bins[range].iter().map(|bin| bin.entries(level)).sum::<u64>();
        parallel::blocks(0..bins.len(), CHEAP, &|range, _| some(range)).into_iter().sum()
    }
}

/// The representation of a projected sphere in a list.
#[derive(Debug, Clone, Copy, bytemuck::Zeroable)]
pub(crate) struct Placed {
    pub(crate) record: ProjectedRecord,
    pub(crate) detail: ProjectedDetailRecord,
    /// The depth of the centre in the frame's unit.
    pub(crate) depth: f64,
}

/// The bits of x as an integer with the same order.
pub(in crate::certify) fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The inverse.
pub(in crate::certify) fn number(ordered: u32) -> f32 {
    f32::from_bits(if ordered >> 31 == 1 { ordered & !(1 << 31) } else { !ordered })
}
