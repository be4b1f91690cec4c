//! Values that several owners share.

use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Values, each for as long as an owner keeps it. Clones have the same ones.
pub struct Shared<T>(Arc<Mutex<Vec<Weak<T>>>>);

impl<T> Shared<T> {
    /// The value that `serves`, else one that `make` makes. Other threads wait meanwhile.
    ///
    /// # Errors
    /// Errors of `make`.
    pub fn or_make<E>(&self, serves: impl Fn(&T) -> bool, make: impl FnOnce() -> Result<T, E>) -> Result<Arc<T>, E> {
        // A thread that panicked left whole values.
        let mut values = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        values.retain(|value| value.strong_count() > 0);
        if let Some(value) = values.iter().filter_map(Weak::upgrade).find(|value| serves(value)) {
            return Ok(value);
        }
        let value = Arc::new(make()?);
        values.push(Arc::downgrade(&value));
        Ok(value)
    }
}

impl<T> Default for Shared<T> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_while_it_is_kept_and_serves() {
        let (one, other) = (Shared::<u32>::default(), Shared::default());
        let both = [one.clone(), one];
        let made = |of: &Shared<u32>, n: u32| of.or_make(|value| *value == n, || Ok::<_, ()>(n)).expect("a value");
        let (first, second) = (made(&both[0], 3), made(&both[1], 4));
        assert!(Arc::ptr_eq(&first, &made(&both[1], 3)) && Arc::ptr_eq(&second, &made(&both[0], 4)), "shared");
        assert!(!Arc::ptr_eq(&first, &made(&other, 3)), "of its own");
        assert_eq!(both[0].or_make(|_| false, || Err("none")), Err("none"));
        drop(first);
        let make = || Ok::<_, ()>(5);
        assert_eq!(
            *both[1].or_make(|value| *value == 3, make).expect("a value"),
            5,
            "the first value has no owner left"
        );
        assert_eq!(both[0].0.lock().expect("values").len(), 2);
    }
}
