//! The tree as devices read it: eight boxes in 64 bytes, and spheres. Traversed by shaders/search/tree.wgsl.
//!
//! The levels of the tree are followed by one more: its nodes are the blocks, and their children are single spheres, because
//! a sphere costs a device about as much as eight boxes. Node n of level l lies at (8^l - 1)/7 + n, which leaves unused nodes
//! at the ends of the levels, at most as many as there are blocks, and needs neither links nor a table.

use super::build::bounds;
use super::{Node, Tree, WIDE};
use crate::double_double as dd;
use crate::view::View;
use bytemuck::{Pod, Zeroable};
use halfline_ground::parallel;

/// The most levels of nodes: bindings of 2^32 bytes hold at most 2^27 spheres, and ten levels 2^30.
#[cfg(test)]
pub(crate) const DEVICE_LEVELS: u32 = 10;

/// Eight boxes on a grid; search/tree.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct NodeRecord {
    /// The least x, y, z of all boxes.
    pub(crate) origin: [f32; 3],
    /// The biased exponents of the grid's steps in x, y, z, 8 bits each from the lowest, and one bit for each child that
    /// exists.
    pub(crate) grid: u32,
    /// Steps from the origin to the planes of the children, one byte each: least x, y, z, greatest x, y, z.
    pub(crate) planes: [[u32; 2]; 6],
}

/// The finest grid of a node, 2^-30: far less than the padding of rays.
const FINEST: i32 = -30;

/// The bias of exponents of f32.
const BIAS: i32 = 127;

impl NodeRecord {
    /// The boxes of a node, rounded outward to its grid.
    pub(super) fn new(node: &Node) -> Self {
        let exists = |lane: &usize| node.planes[0][*lane] <= node.planes[3][*lane];
        let mut record = Self::zeroed();
        for n in 0..3 {
            let (lows, highs) = (&node.planes[n], &node.planes[n + 3]);
            let lanes = || (0..WIDE).filter(exists);
            let low = lanes().map(|lane| lows[lane]).fold(f32::MAX, f32::min);
            let high = lanes().map(|lane| highs[lane]).fold(low, f32::max);
            let from = |plane: f32| f64::from(plane) - f64::from(low);
            let exponent = finest(from(high));
            let steps = |plane: f32| dd::ldexp(from(plane), -exponent);
            record.origin[n] = low;
            record.grid |= ((exponent + BIAS) as u32) << (8 * n);
            for lane in lanes() {
                let (word, shift) = (lane / 4, lane % 4 * 8);
                record.planes[n][word] |= (steps(lows[lane]).floor() as u32) << shift;
                record.planes[n + 3][word] |= (steps(highs[lane]).ceil() as u32) << shift;
                record.grid |= 1 << (24 + lane);
            }
        }
        record
    }
}

/// The exponent of the smallest step such that 255 steps are at least `extent`.
fn finest(extent: f64) -> i32 {
    let least = dd::exponent(extent / 255.0).max(FINEST);
    if 255.0 * dd::ldexp(1.0, least) < extent { least + 1 } else { least }
}

/// A sphere on the grid of places; certify/given.wgsl declares it.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct PlacedSphereRecord {
    pub(crate) steps: [i32; 3],
    pub(crate) radius: f32,
    pub(crate) rest: [f32; 3],
    /// WGSL rounds the size up.
    pub(crate) unused: f32,
}

/// Steps of the grid of places in the tree's unit. Spheres are within 2^28 of them from the middle, and rays within 2^30.
/// Section 9 of docs/certificate.md.
const STEPS: f64 = (1u64 << 28) as f64;

/// Largest coordinate of a place on the grid, in the tree's unit: differences of two places fit an i32.
/// Section 13 of docs/certificate.md.
pub(super) const NEAR: f64 = 3.0;

/// A place as whole steps and a rest.
pub(crate) type OnGrid = ([i32; 3], [f32; 3]);

pub(crate) fn on_grid(at: [f64; 3]) -> OnGrid {
    let steps = at.map(|x| (x * STEPS).round());
    (steps.map(|n| n as i32), std::array::from_fn(|n| (at[n] - steps[n] / STEPS) as f32))
}

/// The place of the first node of a level.
pub(crate) fn first(level: usize) -> usize {
    ((1 << (3 * level)) - 1) / 7
}

impl Tree {
    /// The length 2^`unit` in the tree's unit, and the eye of a view on the grid of places. `None` where rays have no
    /// common eye, where it is far away, or where the length is not a normal f32.
    pub(crate) fn eye(&self, view: &View, unit: i32) -> Option<(f32, OnGrid)> {
        let unit = dd::ldexp(1.0, unit - self.placement.k);
        let is_normal = (f32::MIN_POSITIVE.into()..=f32::MAX.into()).contains(&unit);
        let at = self.placement.point(view.basis.e.to_array());
        let is_near = at.iter().all(|x| x.abs() <= NEAR);
        (is_near && is_normal && !view.parallel).then(|| (unit as f32, on_grid(at)))
    }

    /// The nodes for devices.
    pub(crate) fn device_nodes(&self) -> Vec<NodeRecord> {
        let blocks = first(self.levels());
        let mut records = vec![NodeRecord::zeroed(); blocks + self.blocks.len()];
        for level in 0..self.levels() {
            let nodes = &self.nodes[self.firsts[level] as usize..self.firsts[level + 1] as usize];
            let records = &mut records[first(level)..][..nodes.len()];
            parallel::each(records, |n, record| *record = NodeRecord::new(&nodes[n]));
        }
        parallel::each(&mut records[blocks..], |n, record| {
            let spheres = &self.spheres[n * WIDE..self.spheres.len().min((n + 1) * WIDE)];
            *record = NodeRecord::new(&Node::of(spheres.iter().map(|s| bounds(&self.placement, s))));
        });
        records
    }

    /// The spheres for devices that certify, in the order of the tree.
    pub(crate) fn device_spheres(&self) -> Vec<PlacedSphereRecord> {
        let record = |&[x, y, z, radius]: &[f64; 4]| {
            let (steps, rest) = on_grid(self.placement.point([x, y, z]));
            PlacedSphereRecord { steps, radius: self.placement.radius(radius) as f32, rest, unused: 0.0 }
        };
        parallel::map(&self.spheres, record)
    }
}
