//! Lists of the spheres: operations on all of them alike, whatever values they have.

use super::{Cuts, List, Materials, Spheres};
use blake3::Hasher;
use bytemuck::NoUninit;
use halfline_ground::check::keep;

/// A list of values of the spheres.
trait Values {
    fn keep(&mut self, flags: &[bool]);
    fn share(&mut self);
    /// Takes the values with these indices, in their order.
    fn choose(&mut self, indices: &[u32]);
}

impl<T: Copy + Send + Sync + 'static> Values for List<T> {
    fn keep(&mut self, flags: &[bool]) {
        keep(self.to_mut(), flags);
    }
    fn share(&mut self) {
        Self::share(self);
    }
    fn choose(&mut self, indices: &[u32]) {
        *self = indices.iter().map(|n| self[*n as usize]).collect::<Vec<T>>().into();
    }
}

/// Adds the values of another list with these indices.
fn add<T: Copy>(own: &mut List<T>, other: &List<T>, indices: &[u32]) {
    own.to_mut().extend(indices.iter().map(|n| other[*n as usize]));
}

fn add_some<T: Copy>(own: &mut Option<List<T>>, other: Option<&List<T>>, indices: &[u32]) {
    if let Some(other) = other {
        add(own.get_or_insert_default(), other, indices);
    }
}

fn digest<T: NoUninit + Sync>(list: &List<T>, hasher: &mut Hasher) {
    hasher.update(list.digest().as_bytes());
}

impl Spheres {
    fn lists_mut(&mut self) -> impl Iterator<Item = &mut dyn Values> {
        let Self { centers, radii, colors, materials, opacities, cuts } = self;
        let kinds = materials.as_mut().map(|Materials { of, .. }| of as &mut dyn Values);
        let colors = colors.as_mut().map(|list| list as &mut dyn Values);
        let opacities = opacities.as_mut().map(|list| list as &mut dyn Values);
        let (flags, faces) = match cuts {
            Some(Cuts { of, colors, .. }) => (Some(of as &mut dyn Values), colors.as_mut()),
            None => (None, None),
        };
        let faces = faces.map(|list| list as &mut dyn Values);
        [Some(centers as &mut dyn Values), Some(radii), colors, kinds, opacities, flags, faces].into_iter().flatten()
    }

    /// Removes all spheres, and keeps the memory.
    pub fn clear(&mut self) {
        self.centers.to_mut().clear();
        self.radii.to_mut().clear();
        (self.colors, self.materials, self.opacities, self.cuts) = (None, None, None, None);
    }

    /// Keeps the spheres whose flag is set.
    pub fn keep(&mut self, flags: &[bool]) {
        self.lists_mut().for_each(|list| list.keep(flags));
    }

    /// Makes clones cheap: they share the numbers from here on. A change of shared numbers copies them first.
    pub fn share(&mut self) {
        self.lists_mut().for_each(|list| list.share());
    }

    /// Takes the spheres with these indices, in their order.
    pub(crate) fn choose(&mut self, indices: &[u32]) {
        self.lists_mut().for_each(|list| list.choose(indices));
    }

    /// Adds the spheres of others with these indices, without their materials.
    pub(crate) fn add_chosen(&mut self, others: &Self, indices: &[u32]) {
        add(&mut self.centers, &others.centers, indices);
        add(&mut self.radii, &others.radii, indices);
        add_some(&mut self.colors, others.colors.as_ref(), indices);
        add_some(&mut self.opacities, others.opacities.as_ref(), indices);
    }

    /// Whether all lists but the flags of cuts are the very ones of others, which no one can change.
    pub(crate) fn is_same(&self, others: &Self) -> bool {
        fn same<T>(own: Option<&List<T>>, other: Option<&List<T>>) -> bool {
            own.zip(other).map_or(own.is_none() && other.is_none(), |(own, other)| own.is_same(other))
        }
        fn kinds(spheres: &Spheres) -> Option<&List<u32>> {
            spheres.materials.as_ref().map(|materials| &materials.of)
        }
        self.centers.is_same(&others.centers)
            && self.radii.is_same(&others.radii)
            && same(self.colors.as_ref(), others.colors.as_ref())
            && same(self.opacities.as_ref(), others.opacities.as_ref())
            && same(kinds(self), kinds(others))
    }

    /// Whether all lists but the materials have this length.
    pub(crate) fn have_lengths(&self, count: usize) -> bool {
        let lengths = [self.colors.as_ref().map(|list| list.len()), self.opacities.as_ref().map(|list| list.len())];
        let all = [Some(self.centers.len()), Some(self.radii.len())].into_iter().chain(lengths);
        all.flatten().all(|length| length == count)
    }

    /// The optional lists, in the plural of a message, and whether there are values.
    pub(crate) fn carried(&self) -> [(&'static str, bool); 2] {
        [("colours", self.colors.is_some()), ("opacities", self.opacities.is_some())]
    }

    /// Whether a sphere and one of others have the same numbers, colours and opacities.
    pub(crate) fn is_alike(&self, n: usize, others: &Self, other: usize) -> bool {
        let color = |spheres: &Self, n: usize| spheres.colors.as_ref().map(|colors| colors[n]);
        self.centers[n] == others.centers[other]
            && self.radii[n] == others.radii[other]
            && color(self, n) == color(others, other)
            && self.opacity(n as u32) == others.opacity(other as u32)
    }

    /// Adds the digests of the lists but the materials to a hash.
    pub(crate) fn hash_to(&self, hasher: &mut Hasher) {
        digest(&self.centers, hasher);
        digest(&self.radii, hasher);
        self.colors.iter().for_each(|colors| digest(colors, hasher));
        if let Some(opacities) = &self.opacities {
            hasher.update(b"opacities");
            digest(opacities, hasher);
        }
    }
}
