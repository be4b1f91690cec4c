//! Memory limits and buffer reuse. A request that exceeds the free memory is refused before the work begins, because an
//! overcommitting system would grant it and end the process later. Buffers are reused from frame to frame.

mod free;
mod room;

pub use free::free;
pub use room::{Ledger, SPHERE, check, check_ids, check_spheres, check_wide_ids, entries, extend_to, ids_fit, reserve};

use crate::error::{Error, Result};
use crate::quote::setting::SIZE;
use bytemuck::Zeroable;
use bytemuck::allocation::try_zeroed_vec;
use std::alloc::{Layout, handle_alloc_error};
use std::any::Any;
use std::sync::Mutex;

/// Vectors of earlier frames for reuse: allocating and clearing the pages of every frame takes a third of a frame's
/// time.
#[derive(Debug, Default)]
pub struct Pool(Mutex<Vec<Spare>>);

#[derive(Debug)]
struct Spare {
    /// A `Vec` of some type.
    vector: Box<dyn Any + Send>,
    /// Its size in bytes.
    bytes: u64,
    /// Frames since its last use.
    age: u32,
}

/// Frames after which an unused vector is freed.
const MAX_UNUSED_FRAMES: u32 = 2;

/// Zeros, which the system provides when a thread first writes them.
pub fn zeroed<T: Zeroable>(n: usize) -> Vec<T> {
    let room = Layout::array::<T>(n).unwrap_or(Layout::new::<T>());
    try_zeroed_vec(n).unwrap_or_else(|()| handle_alloc_error(room))
}

impl Pool {
    /// A vector with capacity for `n`, with the contents that an earlier frame left in it: the caller overwrites all of
    /// it.
    pub fn take<T: Send + 'static>(&self, n: usize) -> Vec<T> {
        if n == 0 {
            return Vec::new();
        }
        let mut spares = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let room = |spare: &Spare| spare.vector.downcast_ref::<Vec<T>>().map(Vec::capacity).filter(|c| *c >= n);
        let fits = spares.iter().enumerate().filter_map(|(place, spare)| Some((room(spare)?, place)));
        let Some((_, place)) = fits.min() else { return Vec::new() };
        spares.swap_remove(place).vector.downcast().map_or_else(|_| Vec::new(), |vector| *vector)
    }

    /// A vector of `n` values; the caller overwrites all of them. New ones are zeros, which the system provides when a
    /// thread first writes them.
    ///
    /// # Errors
    /// [`Error::Limits`] when the memory cannot be allocated.
    pub fn values<T: Zeroable + Send + Clone + 'static>(&self, n: usize) -> Result<Vec<T>> {
        let mut vector = self.take(n);
        if vector.capacity() < n {
            return try_zeroed_vec(n).map_err(|()| Error::Limits {
                problem: format!(
                    "{} bytes for one buffer of the frame cannot be allocated",
                    n.saturating_mul(size_of::<T>())
                ),
                mend: format!("render a smaller {SIZE} or fewer buffers"),
            });
        }
        vector.resize(n, T::zeroed());
        Ok(vector)
    }

    /// The same for lists of candidates, where a failed allocation ends the process, as it does for any vector.
    pub fn sized<T: Zeroable + Send + 'static>(&self, n: usize) -> Vec<T> {
        let mut vector = self.take(n);
        if vector.is_empty() {
            return zeroed(n);
        }
        vector.resize_with(n, T::zeroed);
        vector
    }

    /// Keeps a vector for a later frame.
    pub fn put_back<T: Send + 'static>(&self, vector: Vec<T>) {
        if vector.capacity() > 0 {
            let mut spares = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let bytes = (vector.capacity() * size_of::<T>()) as u64;
            spares.push(Spare { vector: Box::new(vector), bytes, age: 0 });
        }
    }

    /// Bytes of all vectors in the pool, which the next frame reuses before it allocates.
    pub fn kept(&self) -> u64 {
        let spares = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        spares.iter().map(|spare| spare.bytes).sum()
    }

    /// Begins a frame: frees vectors that were not used for some frames.
    pub fn next_frame(&self) {
        let mut spares = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        spares.retain_mut(|spare| {
            spare.age += 1;
            spare.age <= MAX_UNUSED_FRAMES
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_reused_and_released() {
        let pool = Pool::default();
        pool.put_back(vec![7u32; 100]);
        pool.put_back(vec![7.0f32; 100]);
        assert_eq!(pool.kept(), 800);
        assert_eq!(pool.take::<f64>(1), [0.0; 0], "none of that type");
        assert_eq!(pool.take::<u32>(101), [0; 0], "none as large");
        assert_eq!(pool.values::<u32>(100).expect("room"), [7; 100], "as it was left");
        assert_eq!(pool.values::<u32>(3).expect("room"), [0; 3], "taken already");
        (0..=MAX_UNUSED_FRAMES).for_each(|_| pool.next_frame());
        assert_eq!(pool.take::<f32>(1), [0.0; 0], "unused vectors are freed");
    }
}
