//! A complete tree of eight children per node over the spheres, for rays from anywhere.
//!
//! Eight spheres make a block, eight blocks a node, eight nodes a node above them; every node but the last of its level
//! is full. So the place of a node tells the places of its children, the depth is the logarithm of the count, and the
//! same spheres give the same tree for any number of threads. The boxes are f32 in the tree's own unit, see [`Placement`];
//! docs/certificate.md, section 9b, derives their padding.

pub(crate) mod bounding;
mod box_ray;
mod build;
pub(crate) mod device;
pub(crate) mod device_rays;
pub(crate) mod lanes;
mod order;
mod records;
pub(crate) mod sixteen;
pub(crate) mod streams;
#[cfg(test)]
mod tests;
pub(crate) mod walk;

use crate::scene::Ball;
use crate::view::placement::Placement;
use bounding::Bounding;
pub(crate) use box_ray::BoxRay;
pub(crate) use order::order;
pub(crate) use records::{ABSENT, Block, Node, WIDE};
use std::sync::OnceLock;

/// The most levels of nodes: blocks number at most 2^28, and eight of them make a node.
pub(crate) const LEVELS: usize = 10;

/// The most spheres of a tree.
pub(crate) const MAX_SPHERES: usize = 1 << 31;

/// The tree.
#[derive(Debug)]
pub(crate) struct Tree {
    pub(crate) placement: Placement,
    /// Level by level, the root first. Children of node n of a level are the nodes 8 n to 8 n + 7 of the next.
    pub(crate) nodes: Vec<Node>,
    /// The first node of each level, and at last the number of nodes.
    pub(crate) firsts: Vec<u32>,
    /// The children of the lowest nodes.
    pub(crate) blocks: Vec<Block>,
    /// The spheres of the blocks in their order; the last block may hold fewer than eight.
    pub(crate) ids: Vec<u32>,
    /// The same spheres as the scene states them: centre and radius. A copy, because a ray that needs one from the scene
    /// would wait for three places of memory.
    pub(crate) spheres: Vec<[f64; 4]>,
    /// Spheres around groups, once streams of rays need them.
    bounding: OnceLock<Bounding>,
}

impl Tree {
    /// Bytes of the tree of so many spheres while it is built: centre and radius 32 each, id 4, a block's lane 16, a node's part
    /// 3, boxes 3; and 2 of the spheres around groups.
    pub(crate) fn bytes(spheres: usize) -> u64 {
        60 * spheres as u64
    }

    /// The spheres around its groups.
    pub(crate) fn bounding(&self) -> &Bounding {
        self.bounding.get_or_init(|| Bounding::of(&self.blocks))
    }

    /// Levels of nodes.
    pub(crate) fn levels(&self) -> usize {
        self.firsts.len() - 1
    }

    /// The sphere at a place.
    #[inline(always)]
    pub(crate) fn ball(&self, place: usize) -> Ball {
        self.spheres[place].into()
    }

    /// The places of a block's spheres in the order of the tree.
    pub(crate) fn places(&self, block: u32) -> std::ops::Range<usize> {
        let first = block as usize * WIDE;
        first..self.ids.len().min(first + WIDE)
    }
}
