//! The spheres of a set in clusters: a binary tree that divides them at the median of the longest side of their box.

use super::enclosure::Enclosure;
use glam::DVec3;
use halfline_ground::error::Result;
use halfline_ground::memory::check;

/// The most spheres of a cluster that is not divided.
pub(super) const MAX_UNDIVIDED_SPHERES: usize = 128;

/// The tree.
#[derive(Debug, Clone)]
pub(super) struct Clusters {
    /// The indices of the spheres, cluster by cluster.
    pub(super) order: Vec<u32>,
    /// The first is the root.
    pub(super) nodes: Vec<Cluster>,
}

/// Some spheres of the set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cluster {
    /// Their range in the order; the end is excluded.
    pub(super) range: [u32; 2],
    pub(super) enclosure: Enclosure,
    /// The first of its two halves, which are neighbours; 0 where it is not divided.
    pub(super) halves: u32,
}

impl Clusters {
    /// The clusters of these spheres.
    ///
    /// # Errors
    /// [`Error::Limits`](crate::Error::Limits) where memory is short.
    pub(super) fn of(centers: &[[f64; 3]], radii: &[f64]) -> Result<Self> {
        let each = size_of::<u32>() + 4 * size_of::<Cluster>() / MAX_UNDIVIDED_SPHERES;
        check((radii.len() * each) as u64, || format!("the clusters of {} spheres", radii.len()))?;
        let mut order: Vec<u32> = (0..radii.len() as u32).collect();
        let around = |part: &[u32]| {
            let spheres = part.iter().map(|n| Enclosure::of(centers[*n as usize], radii[*n as usize]));
            spheres.fold(Enclosure::NOTHING, |all, sphere| all.with(&sphere))
        };
        let mut nodes = vec![Cluster { range: [0, order.len() as u32], enclosure: around(&order), halves: 0 }];
        let mut next = 0;
        while let Some(Cluster { range: [first, end], enclosure, .. }) = nodes.get(next).copied() {
            if (end - first) as usize > MAX_UNDIVIDED_SPHERES {
                let axis = longest(enclosure.high - enclosure.low);
                let part = &mut order[first as usize..end as usize];
                let half = part.len() / 2;
                let at = |n: &u32| centers[*n as usize][axis];
                part.select_nth_unstable_by(half, |a, b| at(a).total_cmp(&at(b)));
                let middle = first + half as u32;
                nodes[next].halves = nodes.len() as u32;
                let halves = [[first, middle], [middle, end]];
                for (range, part) in halves.into_iter().zip([&part[..half], &part[half..]]) {
                    nodes.push(Cluster { range, enclosure: around(part), halves: 0 });
                }
            }
            next += 1;
        }
        Ok(Self { order, nodes })
    }
}

/// The axis of the longest side.
pub(super) fn longest(sides: DVec3) -> usize {
    let sides = sides.to_array();
    (1..3).fold(0, |best, axis| if sides[axis] > sides[best] { axis } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_hold_every_sphere_once() {
        let centers: Vec<[f64; 3]> = (0..1000).map(|n| [(n * 7 % 13) as f64, (n * 3 % 11) as f64, n as f64]).collect();
        let radii: Vec<f64> = (0..1000).map(|n| 1.0 + (n % 5) as f64).collect();
        let clusters = Clusters::of(&centers, &radii).expect("memory");
        let mut sorted = clusters.order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..1000));
        for cluster in &clusters.nodes {
            let [first, end] = cluster.range.map(|n| n as usize);
            let spheres = clusters.order[first..end].iter().map(|n| *n as usize);
            let around = spheres.fold(Enclosure::NOTHING, |all, n| all.with(&Enclosure::of(centers[n], radii[n])));
            assert_eq!(around, cluster.enclosure);
            assert!(cluster.halves > 0 || end - first <= MAX_UNDIVIDED_SPHERES);
        }
    }
}
