//! The topology of the tree without its boxes, built from the spheres in world space.

use super::{FIRST, IS_LEAF, LEAF, NOWHERE, STACK};
use crate::double_double as dd;
use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;

/// Nodes as pairs of links, and the order of the leaves' spheres. At most [`STACK`] deep.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shape {
    /// The root first, and children after their parents.
    pub(crate) links: Vec<[u32; 2]>,
    /// Ids of the spheres, leaf by leaf.
    pub(crate) order: Vec<u32>,
}

/// How far along the space-filling curve a cluster searches for its nearest neighbour.
const NEIGHBOURS: PlocSearchDistance = PlocSearchDistance::Low;

/// Initial rounds that search only one step, while there are many clusters and any neighbour is good enough.
const HASTY: usize = 2;

/// If more spheres than this share a centre, clustering is skipped: each round would join only two or three of them.
const HEAP: usize = 1 << 12;

/// The position of a link: the node and which of its two.
type LinkPosition = (usize, usize);

impl Shape {
    /// Clusters nearby spheres (PLOC, Meister and Bittner 2018, by obvhs). If the tree is deeper than [`STACK`] or has
    /// more than one node per two spheres, it is replaced by repeated halving of its order, of depth log2 of the count.
    /// `None` without spheres, or with more than links can address.
    pub(crate) fn new(centers: &[[f64; 3]], radii: &[f64]) -> Option<Self> {
        let count = radii.len();
        if count == 0 || count > FIRST as usize {
            return None;
        }
        let mut ids: Vec<u32> = (0..count as u32).collect();
        if count <= LEAF {
            return Some(Self::halved(&ids));
        }
        let boxes = boxes(centers, radii);
        if largest_heap(&boxes) > HEAP {
            sort_by_medians(centers, &mut ids);
            return Some(Self::halved(&ids));
        }
        let bvh = PlocBuilder::with_capacity(count).build(NEIGHBOURS, &boxes, ids, SortPrecision::U64, HASTY);
        Some(Self::of_clusters(&bvh.nodes).fitting())
    }

    /// The tree itself, or its halved order if it is too deep or too large.
    pub(super) fn fitting(self) -> Self {
        let fits = self.depth() <= STACK as usize && 2 * self.links.len() <= self.order.len();
        if fits { self } else { Self::halved(&self.order) }
    }

    /// Nodes on the longest path, which bounds the traversal stack.
    pub(super) fn depth(&self) -> usize {
        let mut depths = vec![1; self.links.len()];
        for (n, links) in self.links.iter().enumerate() {
            for link in links.iter().filter(|link| **link & IS_LEAF == 0) {
                depths[*link as usize] = depths[n] + 1;
            }
        }
        depths.into_iter().max().unwrap_or(0)
    }

    /// Converts obvhs's nodes; subtrees of few spheres become leaves.
    fn of_clusters(nodes: &[Bvh2Node]) -> Self {
        let children = |n: u32| {
            let first = nodes[n as usize].first_index;
            (!nodes[n as usize].is_leaf()).then_some([first, first + 1])
        };
        // Parents before children, without recursion, since the depth is not bounded yet.
        let mut preorder = Vec::with_capacity(nodes.len());
        let mut stack = vec![0];
        while let Some(n) = stack.pop() {
            preorder.push(n);
            stack.extend(children(n).into_iter().flatten());
        }
        let mut spheres = vec![1u32; nodes.len()];
        for &n in preorder.iter().rev() {
            if let Some([a, b]) = children(n) {
                spheres[n as usize] = spheres[a as usize] + spheres[b as usize];
            }
        }
        let mut shape = Self { links: Vec::new(), order: Vec::new() };
        let mut stack: Vec<(u32, Option<LinkPosition>)> = vec![(0, None)];
        while let Some((n, place)) = stack.pop() {
            if let Some([a, b]) = children(n).filter(|_| spheres[n as usize] > LEAF as u32) {
                let node = shape.node(place);
                stack.extend([(b, Some((node, 1))), (a, Some((node, 0)))]);
                continue;
            }
            let mut below = vec![n];
            let mut ids = Vec::with_capacity(LEAF);
            while let Some(n) = below.pop() {
                match children(n) {
                    Some(both) => below.extend(both),
                    None => ids.push(nodes[n as usize].first_index),
                }
            }
            shape.leaf(place, &ids);
        }
        shape
    }

    /// Builds a tree by repeated halving of `order`.
    pub(super) fn halved(order: &[u32]) -> Self {
        let mut shape = Self { links: Vec::new(), order: Vec::new() };
        let mut stack: Vec<(&[u32], Option<LinkPosition>)> = vec![(order, None)];
        while let Some((ids, place)) = stack.pop() {
            // The root is a node even if one leaf would suffice.
            if ids.len() > LEAF || place.is_none() {
                let (a, b) = ids.split_at(ids.len().div_ceil(2));
                let node = shape.node(place);
                stack.extend([(b, Some((node, 1))), (a, Some((node, 0)))]);
            } else {
                shape.leaf(place, ids);
            }
        }
        shape
    }

    fn node(&mut self, place: Option<LinkPosition>) -> usize {
        let node = self.links.len();
        self.links.push([NOWHERE; 2]);
        self.set(place, node as u32);
        node
    }

    fn leaf(&mut self, place: Option<LinkPosition>, ids: &[u32]) {
        self.set(place, IS_LEAF | (ids.len() as u32) << 27 | self.order.len() as u32);
        self.order.extend(ids);
    }

    fn set(&mut self, place: Option<LinkPosition>, link: u32) {
        if let Some((node, side)) = place {
            self.links[node][side] = link;
        }
    }
}

/// The boxes of the spheres relative to their centre, in f32. Rounding may make the tree less efficient but not
/// incorrect.
fn boxes(centers: &[[f64; 3]], radii: &[f64]) -> Vec<Aabb> {
    let point = |c: &[f64; 3]| DVec3::from_array(*c);
    let span = centers.par_iter().map(|c| (point(c), point(c)));
    let none = || (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = span.reduce(none, |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let middle = low * 0.5 + high * 0.5;
    let largest = radii.iter().copied().fold((high - middle).abs().max_element(), f64::max);
    let shift = -dd::exponent(largest);
    let one = |(c, r): (&[f64; 3], &f64)| {
        let p = (point(c) - middle).to_array().map(|x| dd::ldexp(x, shift) as f32);
        let (p, r) = (Vec3A::from_array(p), Vec3A::splat(dd::ldexp(*r, shift) as f32));
        Aabb { min: p - r, max: p + r }
    };
    centers.par_iter().zip(radii).map(one).collect()
}

/// The largest number of boxes with the same centre.
fn largest_heap(boxes: &[Aabb]) -> usize {
    let middle = |a: &Aabb| (a.min + a.max).to_array().map(f32::to_bits);
    let mut points: Vec<[u32; 3]> = boxes.par_iter().map(middle).collect();
    points.par_sort_unstable();
    points.chunk_by(|a, b| a == b).map(<[_]>::len).max().unwrap_or(0)
}

/// Sorts `ids` so that repeated halving separates them at planes across their longest extent.
fn sort_by_medians(centers: &[[f64; 3]], ids: &mut [u32]) {
    if ids.len() <= LEAF {
        return;
    }
    let at = |id: u32, axis: usize| centers[id as usize][axis];
    let extent = |axis: usize| {
        let ends = |[low, high]: [f64; 2], id: &u32| [low.min(at(*id, axis)), high.max(at(*id, axis))];
        let [low, high] = ids.iter().fold([f64::INFINITY, f64::NEG_INFINITY], ends);
        high - low
    };
    let extents = [0, 1, 2].map(extent);
    let axis = (0..3).max_by(|a, b| extents[*a].total_cmp(&extents[*b])).unwrap_or(0);
    let half = ids.len().div_ceil(2);
    ids.select_nth_unstable_by(half - 1, |a, b| at(*a, axis).total_cmp(&at(*b, axis)));
    let (a, b) = ids.split_at_mut(half);
    rayon::join(|| sort_by_medians(centers, a), || sort_by_medians(centers, b));
}
