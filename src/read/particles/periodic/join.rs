//! Joining the particles of molecules that the cell cuts: along bonds, then the parts of each group, a molecule or a residue.

use super::edges::Edges;
use glam::DVec3;
use std::collections::HashMap;

/// Where particles are moved to.
pub(super) struct Joined {
    /// The edges that each is moved back by.
    pub(super) images: Vec<DVec3>,
    /// The molecules that no move makes whole, in the order of their first particles.
    pub(super) endless: Vec<Endless>,
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

/// Moves what is bonded beside each other, and then the parts of each group beside its first particle. The first particle of
/// what is joined stays, and so does what is bonded to its own image. Without groups, only bonds join.
pub(super) fn join(frame: &Edges, positions: &[[f64; 3]], bonds: &[[u32; 2]], groups: &[Option<u64>]) -> Joined {
    let mut joined = Joined { images: vec![DVec3::ZERO; positions.len()], endless: Vec::new() };
    let (parts, stays) = along_bonds(frame, positions, bonds, &mut joined);
    let links = links(groups, &parts);
    let around = Neighbors::new(stays.len(), links.iter().map(|[a, b]| [*a, *b].map(|n| parts[n as usize])));
    // What stays comes first, so that others are moved to it.
    let roots = (0..stays.len()).filter(|part| stays[*part]).chain(0..stays.len());
    let (mut moves, mut known) = (vec![DVec3::ZERO; stays.len()], stays.clone());
    let mut waiting = Vec::new();
    for root in roots {
        if around.of(root).is_empty() || known[root] && !stays[root] {
            continue;
        }
        known[root] = true;
        waiting.push(root);
        while let Some(part) = waiting.pop() {
            for link in around.of(part) {
                let [a, b] = links[*link as usize].map(|n| n as usize);
                let (here, there) = if parts[a] as usize == part { (a, b) } else { (b, a) };
                let other = parts[there] as usize;
                if !std::mem::replace(&mut known[other], true) {
                    let beside = joined.images[here] + moves[part] + frame.images(positions[here], positions[there]);
                    moves[other] = beside - joined.images[there];
                    waiting.push(other);
                }
            }
        }
    }
    joined.images.iter_mut().zip(&parts).for_each(|(images, part)| *images += moves[*part as usize]);
    joined
}

/// Joins along bonds; the number of the part that each particle belongs to, and for each part whether it is bonded to its own
/// image and so stays.
fn along_bonds(
    frame: &Edges,
    positions: &[[f64; 3]],
    bonds: &[[u32; 2]],
    joined: &mut Joined,
) -> (Vec<u32>, Vec<bool>) {
    let around = Neighbors::new(positions.len(), bonds.iter().copied());
    let (mut parts, mut stays) = (vec![NONE; positions.len()], Vec::new());
    let mut members = Vec::new();
    for first in 0..positions.len() {
        if parts[first] != NONE {
            continue;
        }
        let (part, mut is_endless) = (stays.len() as u32, false);
        parts[first] = part;
        members.clear();
        members.push(first);
        let mut next = 0;
        while let Some(&a) = members.get(next) {
            next += 1;
            for bond in around.of(a) {
                let [low, high] = bonds[*bond as usize].map(|n| n as usize);
                let b = low + high - a;
                let beside = joined.images[a] + frame.images(positions[a], positions[b]);
                if parts[b] == NONE {
                    parts[b] = part;
                    joined.images[b] = beside;
                    members.push(b);
                } else {
                    is_endless |= joined.images[b] != beside;
                }
            }
        }
        if is_endless {
            members.iter().for_each(|n| joined.images[*n] = DVec3::ZERO);
            joined.endless.push(Endless { first, size: members.len() as u64 });
        }
        stays.push(is_endless);
    }
    (parts, stays)
}

/// The first particle of each group with one of every other part, in the order of the particles.
fn links(groups: &[Option<u64>], parts: &[u32]) -> Vec<[u32; 2]> {
    let mut first: HashMap<u64, u32> = HashMap::new();
    let link = |(n, group): (usize, &Option<u64>)| {
        let first = *first.entry((*group)?).or_insert(n as u32);
        (parts[first as usize] != parts[n]).then_some([first, n as u32])
    };
    groups.iter().enumerate().filter_map(link).collect()
}

/// For each node of a graph the numbers of its edges, in ascending order.
struct Neighbors {
    starts: Vec<u32>,
    edges: Vec<u32>,
}

impl Neighbors {
    fn new(nodes: usize, edges: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let mut starts = vec![0; nodes + 1];
        edges.clone().flatten().for_each(|node| starts[node as usize + 1] += 1);
        for node in 1..starts.len() {
            starts[node] += starts[node - 1];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; *starts.last().unwrap_or(&0) as usize];
        for (edge, nodes) in edges.enumerate() {
            for node in nodes {
                let place = &mut next[node as usize];
                sorted[*place as usize] = edge as u32;
                *place += 1;
            }
        }
        Self { starts, edges: sorted }
    }

    fn of(&self, node: usize) -> &[u32] {
        &self.edges[self.starts[node] as usize..self.starts[node + 1] as usize]
    }
}
