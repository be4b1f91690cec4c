//! Joining the particles that the cell cuts: along bonds, and then parts by links between them. Where links of a part disagree,
//! the first that is met counts.

use super::super::grouped::Grouped;
use super::edges::Edges;
use glam::DVec3;
use std::collections::HashMap;

/// The moves that make molecules whole, and the parts that the particles form.
pub(super) struct Joined {
    /// For each particle, the whole numbers of edges by which it is moved back.
    pub(super) images: Vec<DVec3>,
    /// The molecules that are bonded to their own image and so stay as they are, in the order of their first particles.
    pub(super) endless: Vec<Endless>,
    /// The number of the part that each particle belongs to.
    parts: Vec<u32>,
    /// Whether each part stays.
    stays: Vec<bool>,
}

/// A molecule that is bonded to its own image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Endless {
    /// The index of its first particle.
    pub(super) first: usize,
    /// The number of its particles.
    pub(super) size: u64,
}

/// The number of a part that is not known yet.
const NONE: u32 = u32::MAX;

impl Joined {
    /// Moves bonded particles beside each other; the first particle of each part stays.
    pub(super) fn along(frame: &Edges, positions: &[[f64; 3]], bonds: &[[u32; 2]]) -> Self {
        let around = neighbors(positions.len(), bonds.iter().copied());
        let mut joined = Self {
            images: vec![DVec3::ZERO; positions.len()],
            endless: Vec::new(),
            parts: vec![NONE; positions.len()],
            stays: Vec::new(),
        };
        let mut members = Vec::new();
        for first in 0..positions.len() {
            if joined.parts[first] != NONE {
                continue;
            }
            let (part, mut is_endless, mut next) = (joined.stays.len() as u32, false, 0);
            joined.parts[first] = part;
            members.clear();
            members.push(first);
            while let Some(&a) = members.get(next) {
                next += 1;
                for bond in around.of(a) {
                    let [low, high] = bonds[*bond as usize].map(|n| n as usize);
                    let b = low + high - a;
                    let image = joined.images[a] + frame.images(positions[a], positions[b]);
                    if joined.parts[b] == NONE {
                        (joined.parts[b], joined.images[b]) = (part, image);
                        members.push(b);
                    } else {
                        is_endless |= joined.images[b] != image;
                    }
                }
            }
            if is_endless {
                members.iter().for_each(|n| joined.images[*n] = DVec3::ZERO);
                joined.endless.push(Endless { first, size: members.len() as u64 });
            }
            joined.stays.push(is_endless);
        }
        joined
    }

    /// Whether two particles are of different parts.
    pub(super) fn are_apart(&self, a: usize, b: usize) -> bool {
        self.parts[a] != self.parts[b]
    }

    /// Pairs of the first particle of a group and one of the same group in another part, in the order of the particles.
    pub(super) fn links(&self, groups: &[Option<u64>]) -> Vec<[u32; 2]> {
        let mut first: HashMap<u64, u32> = HashMap::new();
        let link = |(n, group): (usize, &Option<u64>)| {
            let first = *first.entry((*group)?).or_insert(n as u32);
            self.are_apart(first as usize, n).then_some([first, n as u32])
        };
        groups.iter().enumerate().filter_map(link).collect()
    }

    /// Moves whole parts beside those that they are linked with: to parts that stay, else to the one with the lowest number.
    pub(super) fn link(&mut self, frame: &Edges, positions: &[[f64; 3]], links: &[[u32; 2]]) {
        let count = self.stays.len();
        let around = neighbors(count, links.iter().map(|[a, b]| [*a, *b].map(|n| self.parts[n as usize])));
        // What stays comes first, so that others are moved to it.
        let roots = (0..count).filter(|part| self.stays[*part]).chain((0..count).filter(|part| !self.stays[*part]));
        let (mut moves, mut root_of) = (vec![DVec3::ZERO; count], vec![NONE; count]);
        for root in roots {
            if root_of[root] != NONE {
                continue;
            }
            root_of[root] = root as u32;
            let (mut members, mut next) = (vec![root], 0);
            while let Some(&part) = members.get(next) {
                next += 1;
                for link in around.of(part) {
                    let [a, b] = links[*link as usize].map(|n| n as usize);
                    let (here, there) = if self.parts[a] as usize == part { (a, b) } else { (b, a) };
                    let other = self.parts[there] as usize;
                    if root_of[other] == NONE && !self.stays[other] {
                        root_of[other] = root as u32;
                        let image = self.images[here] + moves[part] + frame.images(positions[here], positions[there]);
                        moves[other] = image - self.images[there];
                        members.push(other);
                    }
                }
            }
        }
        for (images, part) in self.images.iter_mut().zip(&mut self.parts) {
            *images += moves[*part as usize];
            *part = root_of[*part as usize];
        }
    }
}

/// For each node of a graph the numbers of its edges, in ascending order.
fn neighbors(nodes: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Grouped {
    Grouped::new(nodes, edges.zip(0..).flat_map(|(nodes, edge)| nodes.map(|node| (node as usize, edge))))
}
