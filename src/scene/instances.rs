//! Copies as operators over one set of spheres: memory holds the set and its operators, not the copies. Groups of
//! copies have enclosing boxes, so that groups that no ray can hit, or that cannot be an extreme, are passed without
//! making their spheres.

mod clusters;
pub(crate) mod enclosure;
mod operator;
mod order;
mod search;

use super::Spheres;
use clusters::{Clusters, longest};
use enclosure::Enclosure;
use glam::DVec3;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::{check_wide_ids, ids_fit};
use operator::{Copies, CopyRule};

pub use halfline_ground::Operator;
pub(crate) use operator::Lattice;
pub use search::CopiedSpheres;

/// Spheres that are copies of fewer, numbered as if all were listed: part by part, copy by copy, each in the order of its
/// spheres, without those that clip planes remove.
#[derive(Debug, Clone)]
pub struct Instances {
    parts: Vec<Part>,
    /// Half spaces whose spheres are kept, as in [`Arrangement`](super::arrange::Arrangement).
    clip: Vec<[f64; 4]>,
    /// The number of all, those that are clipped included.
    total: u64,
}

/// Linear RGB of every copy of a set, in place of the spheres' own.
pub type Tints = Option<Vec<[f32; 3]>>;

/// A set of spheres with its copies.
#[derive(Debug, Clone)]
struct Part {
    spheres: Spheres,
    clusters: Clusters,
    placement: CopyRule,
    /// The number of its first sphere, among all with those that are clipped.
    first: u64,
    tints: Tints,
}

/// Some copies of a cluster.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Group {
    part: u32,
    copies: Copies,
    cluster: u32,
}

/// Spheres with their numbers.
#[derive(Debug, Clone, Default)]
pub(crate) struct NumberedSpheres {
    pub(crate) numbers: Vec<u64>,
    pub(crate) spheres: Spheres,
}

/// The most spheres of a group that is not divided.
const MAX_UNDIVIDED_SPHERES: u64 = clusters::MAX_UNDIVIDED_SPHERES as u64;

impl Instances {
    /// Copies of one set along the edges of a cell.
    ///
    /// # Errors
    /// As [`Instances::by_operators`].
    pub(crate) fn along(spheres: Spheres, lattice: Lattice, clip: &[[f64; 4]]) -> Result<Self> {
        Self::of(vec![(spheres, CopyRule::Lattice(lattice), None)], clip)
    }

    /// Sets of spheres, each with its operators, and the linear RGB of every operator's copy where that is not the spheres'
    /// own. Either all spheres have colours or none.
    ///
    /// # Errors
    /// [`Error::Limits`] for more spheres than 64-bit ids can number, and where memory is short; [`Error::Scene`] for numbers that
    /// are not finite.
    pub fn by_operators(sets: Vec<(Spheres, Vec<Operator>, Tints)>) -> Result<Self> {
        let sets = sets.into_iter().map(|(spheres, operators, tints)| (spheres, CopyRule::Operators(operators), tints));
        Self::of(sets.collect(), &[])
    }

    fn of(sets: Vec<(Spheres, CopyRule, Tints)>, clip: &[[f64; 4]]) -> Result<Self> {
        let (mut parts, mut total) = (Vec::new(), 0u64);
        for (spheres, placement, tints) in sets {
            spheres.check()?;
            let colored = spheres.colors.is_some() || tints.is_some();
            let unlike = parts.first().is_some_and(|part: &Part| part.colors() != colored);
            let uncounted = tints.as_ref().is_some_and(|tints| tints.len() as u64 != placement.count());
            if spheres.materials.is_some() || spheres.opacities.is_some() || unlike || uncounted {
                let problem = "the spheres of copies have materials or opacities, or colours that only some have";
                let mend = "use the same for all, without materials and opacities";
                return Err(Error::scene(Place::field("spheres"), problem, mend));
            }
            let count = (spheres.len() as u64).saturating_mul(placement.count());
            let clusters = Clusters::of(&spheres.centers, &spheres.radii)?;
            parts.push(Part { spheres, clusters, placement, first: total, tints });
            total = total.saturating_add(count);
        }
        check_wide_ids(total)?;
        parts.retain(|part| part.spheres.len() as u64 * part.placement.count() > 0);
        let this = Self { parts, clip: clip.to_vec(), total };
        let around = this.whole().iter().fold(Enclosure::NOTHING, |all, group| all.with(&this.enclosure(group)));
        if total > 0 && !around.is_finite() {
            let problem = "some copies lie beyond the range of f64";
            return Err(Error::scene(Place::field("spheres"), problem, "use fewer copies, or a smaller cell"));
        }
        Ok(this)
    }

    /// The same without the spheres whose centre c has n.c > d for some of these planes, given as n and d.
    #[must_use]
    pub fn clipped(mut self, planes: &[[f64; 4]]) -> Self {
        self.clip.extend_from_slice(planes);
        self
    }

    /// The number of spheres, those that clip planes remove included.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }

    /// Whether ids of so many need 64 bits.
    #[must_use]
    pub fn are_wide(&self) -> bool {
        !ids_fit(self.total)
    }

    /// Everything that determines the spheres, for a fingerprint.
    pub(crate) fn describe(&self, to: &mut dyn FnMut(&[u8])) {
        to(b"copies");
        for Part { spheres, placement, tints, .. } in &self.parts {
            to(&(spheres.len() as u64).to_le_bytes());
            to(bytemuck::cast_slice(&spheres.centers));
            to(bytemuck::cast_slice(&spheres.radii));
            let colors = tints.as_deref().or(spheres.colors.as_deref()).unwrap_or_default();
            to(&[u8::from(tints.is_some())]);
            to(&(colors.len() as u64).to_le_bytes());
            to(bytemuck::cast_slice(colors));
            match placement {
                CopyRule::Lattice(Lattice { copies, edges }) => {
                    to(b"edges");
                    to(bytemuck::cast_slice(copies));
                    edges.iter().for_each(|edge| to(bytemuck::cast_slice(&edge.to_array())));
                }
                CopyRule::Operators(operators) => {
                    to(b"operators");
                    to(&(operators.len() as u64).to_le_bytes());
                    operators.iter().for_each(|operator| to(bytemuck::cast_slice(operator.0.as_flattened())));
                }
            }
        }
        to(b"clip");
        to(bytemuck::cast_slice(&self.clip));
    }

    /// Whether clip planes may remove some.
    pub(crate) fn is_clipped(&self) -> bool {
        !self.clip.is_empty()
    }

    /// Whether the spheres have colours.
    pub(crate) fn is_colored(&self) -> bool {
        self.parts.first().is_some_and(Part::colors)
    }

    /// Groups that hold all spheres together.
    pub(crate) fn whole(&self) -> Vec<Group> {
        let group = |(n, part): (usize, &Part)| Group { part: n as u32, copies: part.placement.all(), cluster: 0 };
        self.parts.iter().enumerate().map(group).collect()
    }

    /// A box around the spheres of a group.
    pub(crate) fn enclosure(&self, group: &Group) -> Enclosure {
        let part = &self.parts[group.part as usize];
        part.placement.image(&group.copies, &part.clusters.nodes[group.cluster as usize].enclosure)
    }

    /// The number of its spheres.
    pub(crate) fn count(&self, group: &Group) -> u64 {
        let [first, end] = self.parts[group.part as usize].clusters.nodes[group.cluster as usize].range;
        group.copies.count() * u64::from(end - first)
    }

    /// Adds the parts of a group to `to`; returns whether it is divided.
    pub(crate) fn divide(&self, group: &Group, to: &mut Vec<Group>) -> bool {
        if self.count(group) <= MAX_UNDIVIDED_SPHERES {
            return false;
        }
        let part = &self.parts[group.part as usize];
        let cluster = &part.clusters.nodes[group.cluster as usize];
        let copies = &group.copies;
        if copies.count() > 1 {
            match &part.placement {
                CopyRule::Operators(_) => {
                    let [first, end] = copies.0[0];
                    let one = |n: u32| Group { copies: part.placement.one(n.into()), ..*group };
                    to.extend((first..end).map(one));
                }
                CopyRule::Lattice(Lattice { edges, .. }) => {
                    // The copies are divided along the edge that they extend farthest along. Edges of no length are divided
                    // too.
                    let lengths = [0, 1, 2].map(|k| f64::from(copies.side(k) - 1) * edges[k].length());
                    let longest = longest(DVec3::from_array(lengths));
                    let axis = [longest].into_iter().chain(0..3).find(|k| copies.side(*k) > 1).unwrap_or(longest);
                    to.extend(copies.halved(axis).map(|copies| Group { copies, ..*group }));
                }
            }
        } else if cluster.halves > 0 {
            to.extend([0, 1].map(|n| Group { cluster: cluster.halves + n, ..*group }));
        } else {
            return false;
        }
        true
    }

    /// Adds the spheres of a group that the clip planes keep.
    pub(crate) fn spheres_of(&self, group: &Group, to: &mut NumberedSpheres) {
        let part = &self.parts[group.part as usize];
        let [first, end] = part.clusters.nodes[group.cluster as usize].range.map(|n| n as usize);
        self.add(part, &group.copies, part.clusters.order[first..end].iter().copied(), to);
    }

    /// Adds these copies of some spheres of a part, as far as the clip planes keep them.
    fn add(&self, part: &Part, copies: &Copies, indices: impl Iterator<Item = u32> + Clone, to: &mut NumberedSpheres) {
        let NumberedSpheres { numbers, spheres } = to;
        let (own, count) = (&part.spheres, part.spheres.len() as u64);
        let (centers, radii) = (spheres.centers.to_mut(), spheres.radii.to_mut());
        let mut colors = part.colors().then(|| spheres.colors.get_or_insert_default().to_mut());
        part.placement.each(copies, |copy, place| {
            for index in indices.clone() {
                let n = index as usize;
                let center = place(own.centers[n]);
                if !self.keeps(center) {
                    continue;
                }
                numbers.push(part.first + copy * count + u64::from(index));
                centers.push(center);
                radii.push(own.radii[n]);
                if let Some(colors) = &mut colors {
                    colors.extend(part.color(copy, n));
                }
            }
        });
    }

    /// Whether the clip planes keep a sphere with this centre.
    fn keeps(&self, center: [f64; 3]) -> bool {
        self.clip.iter().all(|plane| is_kept(*plane, DVec3::from_array(center)))
    }

    /// Whether the clip planes keep all spheres of a box (`Some(true)`) or none.
    pub(crate) fn clips(&self, around: &Enclosure) -> Option<bool> {
        let mut all = true;
        for [x, y, z, d] in &self.clip {
            let [least, most] = around.along(DVec3::new(*x, *y, *z), DVec3::ZERO);
            if least > *d {
                return Some(false);
            }
            all &= most <= *d;
        }
        all.then_some(true)
    }
}

impl Part {
    fn colors(&self) -> bool {
        self.spheres.colors.is_some() || self.tints.is_some()
    }

    /// The colour of a sphere of a copy.
    fn color(&self, copy: u64, index: usize) -> Option<[f32; 3]> {
        match (&self.tints, &self.spheres.colors) {
            (Some(tints), _) => Some(tints[copy as usize]),
            (None, Some(colors)) => Some(colors[index]),
            (None, None) => None,
        }
    }
}

/// Whether a plane (x, y, z, d) keeps a sphere with this centre.
pub(crate) fn is_kept([x, y, z, d]: [f64; 4], center: DVec3) -> bool {
    DVec3::new(x, y, z).dot(center) <= d
}
