//! The numbers of a scene's spheres, which a scene owns or shares.

use blake3::{Hash, Hasher};
use bytemuck::NoUninit;
use halfline_ground::parallel;
use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

/// A list that owns its values, or shares the values of others without copying them: of clones of a scene, or of memory that
/// another library manages. Reads as a slice; [`List::to_mut`] changes it.
pub struct List<T>(Store<T>);

enum Store<T> {
    Own(Vec<T>),
    /// Values shared by clones. No one can change them.
    Kept(Arc<Kept<T>>),
    /// Values of others, who may change them between frames.
    Foreign(Arc<dyn AsRef<[T]> + Send + Sync>),
}

struct Kept<T> {
    values: Vec<T>,
    digest: OnceLock<Hash>,
    sound: OnceLock<bool>,
}

impl<T> List<T> {
    /// A list of values that others hold as well. `values` must give the same slice each time; it is dropped with the last
    /// list that shares it.
    #[must_use]
    pub fn shared(values: Arc<dyn AsRef<[T]> + Send + Sync>) -> Self {
        Self(Store::Foreign(values))
    }

    /// A list that stands for a longer one and has a part of it: its digest is the digest of the longer one.
    pub(crate) fn part_of(values: Vec<T>, whole: Hash) -> Self {
        Self(Store::Kept(Arc::new(Kept { values, digest: OnceLock::from(whole), sound: OnceLock::new() })))
    }

    /// A list of values that keep the one rule for them; see [`List::is_sound`].
    pub(crate) fn sound(values: Vec<T>) -> Self {
        Self(Store::Kept(Arc::new(Kept { values, digest: OnceLock::new(), sound: OnceLock::from(true) })))
    }

    /// The number of values for which there is memory without allocating more.
    pub(crate) fn capacity(&self) -> usize {
        match &self.0 {
            Store::Own(values) => values.capacity(),
            // A shared list must be copied before it grows.
            Store::Kept(_) | Store::Foreign(_) => 0,
        }
    }
}

impl<T> List<T> {
    /// Whether these are the very values of another list, which no one can change.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        matches!((&self.0, &other.0), (Store::Kept(a), Store::Kept(b)) if Arc::ptr_eq(a, b))
    }

    /// A clone that shares values which no one can change; `None` where there are none such.
    pub(crate) fn kept(&self) -> Option<Self> {
        match &self.0 {
            Store::Kept(kept) => Some(Self(Store::Kept(Arc::clone(kept)))),
            Store::Own(_) | Store::Foreign(_) => None,
        }
    }
}

impl<T: Clone> List<T> {
    /// The values for changing them, copied first where the list is shared.
    pub fn to_mut(&mut self) -> &mut Vec<T> {
        if !matches!(self.0, Store::Own(_)) {
            self.0 = Store::Own(self.to_vec());
        }
        match &mut self.0 {
            Store::Own(values) => values,
            Store::Kept(_) | Store::Foreign(_) => unreachable!("a shared list was copied"),
        }
    }

    /// The values, copied where the list is shared.
    #[must_use]
    pub fn into_vec(mut self) -> Vec<T> {
        std::mem::take(self.to_mut())
    }
}

impl<T: Send + Sync + 'static> List<T> {
    /// Makes clones cheap: they share the values from here on.
    pub fn share(&mut self) {
        if let Store::Own(values) = &mut self.0 {
            let (digest, sound) = (OnceLock::new(), OnceLock::new());
            self.0 = Store::Kept(Arc::new(Kept { values: std::mem::take(values), digest, sound }));
        }
    }
}

/// Values that one job tests.
const VALUES_PER_JOB: usize = 1 << 16;

impl<T: Sync> List<T> {
    /// Whether the one rule for the values of this list holds for all of them; tested once for clones.
    pub(crate) fn is_sound(&self, rule: impl Fn(&T) -> bool + Sync) -> bool {
        // Without branches within a job, so that compilers vectorize it.
        let sound = |values: &[T]| values.iter().fold(true, |all, value| all & rule(value));
        let test = |values: &[T]| !parallel::any(values.len(), VALUES_PER_JOB, &|range| !sound(&values[range]));
        match &self.0 {
            Store::Kept(kept) => *kept.sound.get_or_init(|| test(&kept.values)),
            Store::Own(_) | Store::Foreign(_) => test(self),
        }
    }
}

impl<T: NoUninit + Sync> List<T> {
    /// BLAKE3 of the values' bytes; computed once for clones.
    pub(crate) fn digest(&self) -> Hash {
        let digest = |values: &[T]| parallel::hash(&mut Hasher::new(), bytemuck::cast_slice(values)).finalize();
        match &self.0 {
            Store::Kept(kept) => *kept.digest.get_or_init(|| digest(&kept.values)),
            Store::Own(_) | Store::Foreign(_) => digest(self),
        }
    }
}

impl<T> Deref for List<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Store::Own(values) => values,
            Store::Kept(kept) => &kept.values,
            Store::Foreign(values) => (**values).as_ref(),
        }
    }
}

impl<T> Default for List<T> {
    fn default() -> Self {
        Self(Store::Own(Vec::new()))
    }
}

impl<T: Clone> Clone for List<T> {
    fn clone(&self) -> Self {
        Self(match &self.0 {
            Store::Own(values) => Store::Own(values.clone()),
            Store::Kept(kept) => Store::Kept(Arc::clone(kept)),
            Store::Foreign(values) => Store::Foreign(Arc::clone(values)),
        })
    }
}

impl<T: fmt::Debug> fmt::Debug for List<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl<T: PartialEq> PartialEq for List<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: PartialEq> PartialEq<[T]> for List<T> {
    fn eq(&self, other: &[T]) -> bool {
        **self == *other
    }
}

impl<T: PartialEq, const N: usize> PartialEq<[T; N]> for List<T> {
    fn eq(&self, other: &[T; N]) -> bool {
        **self == *other
    }
}

impl<T> From<Vec<T>> for List<T> {
    fn from(values: Vec<T>) -> Self {
        Self(Store::Own(values))
    }
}

impl<T> FromIterator<T> for List<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Self(Store::Own(values.into_iter().collect()))
    }
}

impl<'a, T> IntoIterator for &'a List<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Clone> IntoIterator for List<T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(self) -> Self::IntoIter {
        self.into_vec().into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shared_list_is_copied_before_it_changes() {
        let mut first: List<u8> = vec![1, 2, 3].into();
        let address = first.as_ptr();
        first.share();
        let mut second = first.clone();
        assert_eq!((first.as_ptr(), second.as_ptr()), (address, address), "nothing was copied");
        let digest = first.digest();
        assert_eq!((second.digest(), blake3::hash(&[1, 2, 3])), (digest, digest));
        assert!(first.is_sound(|value| *value < 4) && second.is_sound(|value| *value < 4));
        second.to_mut().push(4);
        assert!(!second.is_sound(|value| *value < 4), "of the changed values");
        assert_ne!(second.digest(), digest, "the digest of the changed values");
        assert_eq!((&first[..], &second[..]), (&[1, 2, 3][..], &[1, 2, 3, 4][..]));
        assert_ne!(second.as_ptr(), address);
        assert_eq!(first.into_vec(), [1, 2, 3]);
    }

    #[test]
    fn the_owner_of_shared_values_lives_as_long_as_the_lists() {
        let owner: Arc<Vec<u8>> = Arc::new(vec![7; 5]);
        let list = List::shared(owner.clone());
        let copy = list.clone();
        assert_eq!((Arc::strong_count(&owner), copy.capacity()), (2 + 1, 0));
        drop((list, copy));
        assert_eq!(Arc::strong_count(&owner), 1);
    }
}
