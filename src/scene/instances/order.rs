//! Copies in the order of their ids: ids without what clip planes remove, and blocks of spheres.

use super::operator::Copies;
use super::{Instances, NumberedSpheres, Part};
use crate::scene::Spheres;
use halfline_ground::error::Result;
use halfline_ground::progress::Watch;

/// Spheres of a block.
const BLOCK: usize = 1 << 17;

/// Copies of a part that follow each other.
#[derive(Debug, Clone, Copy)]
struct Run {
    part: usize,
    /// The numbers of the copies; the end is excluded.
    copies: [u64; 2],
    /// Whether the clip planes keep all spheres.
    is_whole: bool,
}

/// The runs of copies with a sphere that the clip planes may keep, in order.
struct Runs<'a> {
    instances: &'a Instances,
    /// A stack of copies that are not visited yet, each with its part; the last element comes next.
    open: Vec<(usize, Copies)>,
}

impl Iterator for Runs<'_> {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        while let Some((n, copies)) = self.open.pop() {
            let part = &self.instances.parts[n];
            let around = part.placement.image(&copies, &part.clusters.nodes[0].enclosure);
            match (self.instances.clips(&around), halves(&copies)) {
                (Some(false), _) => {}
                (None, Some([first, second])) => self.open.extend([(n, second), (n, first)]),
                (kept, _) => {
                    let first = part.placement.number(copies.0.map(|[first, _]| first));
                    return Some(Run { part: n, copies: [first, first + copies.count()], is_whole: kept.is_some() });
                }
            }
        }
        None
    }
}

/// The two halves of more than one copy. Halves of layers, else of rows, else of columns keep copies together that follow each
/// other.
fn halves(copies: &Copies) -> Option<[Copies; 2]> {
    (0..3).rev().find(|edge| copies.side(*edge) > 1).map(|edge| copies.halved(edge))
}

impl Instances {
    fn runs(&self) -> Runs<'_> {
        let open = self.parts.iter().enumerate().map(|(n, part)| (n, part.placement.all())).rev();
        Runs { instances: self, open: open.collect() }
    }

    /// The ids of the spheres with these ascending numbers, which the clip planes keep, and the number of all that they keep.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub(crate) fn ids(&self, numbers: &[u64], watch: &Watch) -> Result<(Vec<u64>, u64)> {
        if !self.is_clipped() {
            return Ok((numbers.to_vec(), self.total));
        }
        let (mut ids, mut count) = (Vec::with_capacity(numbers.len()), 0);
        for Run { part: n, copies: [first, end], is_whole } in self.runs() {
            watch.check()?;
            let part = &self.parts[n];
            let each = part.spheres.len() as u64;
            let [low, high] = [first, end].map(|copy| part.first + copy * each);
            let inside = &numbers[ids.len()..];
            let inside = &inside[..inside.partition_point(|number| *number < high)];
            if is_whole {
                ids.extend(inside.iter().map(|number| count + (number - low)));
                count += high - low;
                continue;
            }
            let mut next_inside = inside.iter().peekable();
            part.placement.each(&part.placement.one(first), |_, place| {
                for (number, center) in (low..).zip(&part.spheres.centers[..]) {
                    if self.keeps(place(*center)) {
                        if next_inside.next_if_eq(&&number).is_some() {
                            ids.push(count);
                        }
                        count += 1;
                    }
                }
            });
        }
        Ok((ids, count))
    }

    /// The first spheres that the clip planes keep: this many, if there are.
    pub(crate) fn first(&self, count: usize) -> NumberedSpheres {
        let mut found = NumberedSpheres::default();
        for Run { part, copies: [first, end], .. } in self.runs() {
            let part = &self.parts[part];
            for copy in first..end {
                self.add(part, &part.placement.one(copy), 0..part.spheres.len() as u32, &mut found);
                if found.numbers.len() >= count {
                    return found;
                }
            }
        }
        found
    }

    /// All spheres in blocks, in the order of their ids.
    pub fn blocks(&self) -> impl Iterator<Item = Spheres> + Send + '_ {
        let mut runs = self.runs();
        let (mut run, mut at): (Option<Run>, [u64; 2]) = (None, [0; 2]);
        std::iter::from_fn(move || {
            let mut block = NumberedSpheres::default();
            while block.numbers.len() < BLOCK {
                let Some(Run { part, copies: [_, end], .. }) = run.filter(|run| at[0] < run.copies[1]) else {
                    run = runs.next();
                    let Some(next) = run else { break };
                    at = [next.copies[0], 0];
                    continue;
                };
                let part: &Part = &self.parts[part];
                let (count, room) = (part.spheres.len() as u64, (BLOCK - block.numbers.len()) as u64);
                let ([copy, first], last) = (at, count.min(at[1] + room));
                self.add(part, &part.placement.one(copy), first as u32..last as u32, &mut block);
                at = if last == count { [copy + 1, 0] } else { [copy, last] };
                debug_assert!(copy < end);
            }
            (!block.numbers.is_empty()).then_some(block.spheres)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::arrange::Arrangement;
    use crate::scene::instances::CopiedSpheres;
    use crate::scene::{Cell, SphereSource};

    fn atoms(count: usize) -> Spheres {
        let mut spheres = Spheres::default();
        for n in 0..count {
            let [x, y, z] = [7, 11, 13].map(|k| (n * k % 29) as f64 / 29.0);
            spheres.push([x, y, z], 0.1 + 0.01 * (n % 3) as f64, Some([x as f32, y as f32, z as f32]));
        }
        spheres
    }

    const CELL: Cell = Cell { origin: [0.0; 3], edges: [[1.0, 0.1, 0.0], [-0.3, 1.1, 0.0], [0.2, 0.1, -0.9]] };

    #[test]
    fn ids_and_blocks_are_those_of_copies_in_memory() {
        for clip in [
            vec![],
            vec![[0.3, 0.5, -0.7, 2.5]],
            vec![[1.0, 0.0, 0.1, 2.1], [-1.0, 0.2, 0.0, -0.9]],
            vec![[0.0, 0.0, 1.0, -90.0]],
        ] {
            let arrangement = Arrangement { copies: [5, 3, 4], clip: clip.clone(), ..Arrangement::default() };
            let mut whole = atoms(300);
            let instances = arrangement.copies(&whole, Some(&CELL)).expect("copies");
            arrangement.apply(&mut whole, Some(&CELL), &Watch::default()).expect("memory");
            let (mut all, mut colors) = (Spheres::default(), Vec::new());
            for block in instances.blocks() {
                all.centers.to_mut().extend(&block.centers[..]);
                all.radii.to_mut().extend(&block.radii[..]);
                colors.extend(block.colors.expect("colours").into_vec());
            }
            assert!(all.centers == whole.centers && all.radii == whole.radii, "{clip:?}");
            assert!(whole.colors.as_ref().is_none_or(|whole| colors == whole[..]), "{clip:?}");
            let mut found = NumberedSpheres::default();
            instances.whole().iter().for_each(|group| spheres_of(&instances, group, &mut found));
            let mut order: Vec<usize> = (0..found.numbers.len()).collect();
            order.sort_by_key(|n| found.numbers[*n]);
            let numbers: Vec<u64> = order.iter().map(|n| found.numbers[*n]).collect();
            let (ids, count) = instances.ids(&numbers, &Watch::default()).expect("not cancelled");
            assert!(count == whole.len() as u64 && ids.into_iter().eq(0..count), "{clip:?}");
            assert!(order.iter().zip(&whole.centers[..]).all(|(n, center)| found.spheres.centers[*n] == *center));
            let few: Vec<u64> = numbers.iter().copied().step_by(37).collect();
            let ids = instances.ids(&few, &Watch::default()).expect("not cancelled").0;
            assert!(ids.into_iter().eq((0..count).step_by(37)), "{clip:?}");
            assert_eq!(instances.first(33).numbers.get(..33), numbers.get(..33));
            let found =
                CopiedSpheres { instances: &instances, watch: &Watch::default() }.ends().expect("not cancelled");
            assert_eq!(found, whole.bounds(), "{clip:?}");
        }
    }

    /// The spheres of the leaves below a group.
    fn spheres_of(instances: &Instances, group: &crate::scene::instances::Group, to: &mut NumberedSpheres) {
        let mut parts = Vec::new();
        match instances.divide(group, &mut parts) {
            true => parts.iter().for_each(|part| spheres_of(instances, part, to)),
            false => instances.spheres_of(group, to),
        }
    }
}
