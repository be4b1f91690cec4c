//! The numbers of a scene's spheres, which a scene owns or shares.

use rayon::prelude::*;
use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

/// A list that owns its values, or shares those of others without copying them: of clones of a scene, or of memory that
/// another library manages. Reads as a slice; [`List::to_mut`] changes it.
pub struct List<T>(Store<T>);

enum Store<T> {
    Own(Vec<T>),
    Shared(Arc<dyn AsRef<[T]> + Send + Sync>),
}

impl<T> List<T> {
    /// A list of values that others hold as well. `values` must give the same slice each time; it is dropped with the last
    /// list that shares it.
    #[must_use]
    pub fn shared(values: Arc<dyn AsRef<[T]> + Send + Sync>) -> Self {
        Self(Store::Shared(values))
    }

    /// The number of values for which there is memory without allocating more.
    pub(crate) fn capacity(&self) -> usize {
        match &self.0 {
            Store::Own(values) => values.capacity(),
            // A shared list must be copied before it grows.
            Store::Shared(_) => 0,
        }
    }
}

impl<T: Clone> List<T> {
    /// The values for changing them; those of a shared list are copied first.
    pub fn to_mut(&mut self) -> &mut Vec<T> {
        if let Store::Shared(values) = &self.0 {
            self.0 = Store::Own((**values).as_ref().to_vec());
        }
        match &mut self.0 {
            Store::Own(values) => values,
            Store::Shared(_) => unreachable!("a shared list was copied"),
        }
    }

    /// The values; those of a shared list are copied.
    #[must_use]
    pub fn into_vec(mut self) -> Vec<T> {
        std::mem::take(self.to_mut())
    }
}

impl<T: Send + Sync + 'static> List<T> {
    /// Makes clones cheap: they share the values from here on.
    pub fn share(&mut self) {
        if let Store::Own(values) = &mut self.0 {
            self.0 = Store::Shared(Arc::new(std::mem::take(values)));
        }
    }
}

impl<T> Deref for List<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Store::Own(values) => values,
            Store::Shared(values) => (**values).as_ref(),
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
            Store::Shared(values) => Store::Shared(Arc::clone(values)),
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

impl<'a, T: Sync> IntoParallelIterator for &'a List<T> {
    type Item = &'a T;
    type Iter = rayon::slice::Iter<'a, T>;

    fn into_par_iter(self) -> Self::Iter {
        (**self).par_iter()
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
        second.to_mut().push(4);
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
