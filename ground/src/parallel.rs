//! Parallel loops over blocks of indices. A body is a `&dyn Fn` of a block, so a loop is compiled once for each type of its values and
//! not once for each body; inside a block the body is as fast as any. The results do not depend on the number of threads: values keep
//! the order of their indices, and blocks have the length that the caller gives. A page of a browser has one thread.

use crate::memory::zeroed;
use blake3::Hasher;
use bytemuck::Zeroable;
#[cfg(not(target_arch = "wasm32"))]
use rayon::prelude::*;
use std::cmp::Ordering;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Indices of a block where the work for each is a few instructions.
pub const CHEAP: usize = 1 << 12;

/// Memory that is divided among the blocks that write it, or indices alone.
pub trait Target: Send + Sized {
    /// The number of indices.
    fn count(&self) -> usize;
    /// The parts of the first `count` indices and of the others.
    fn split(self, count: usize) -> [Self; 2];
}

impl Target for Range<usize> {
    fn count(&self) -> usize {
        self.len()
    }
    fn split(self, count: usize) -> [Self; 2] {
        let middle = self.start + count;
        [self.start..middle, middle..self.end]
    }
}

/// One value for each index.
impl<T: Send> Target for &mut [T] {
    fn count(&self) -> usize {
        self.len()
    }
    fn split(self, count: usize) -> [Self; 2] {
        self.split_at_mut(count).into()
    }
}

/// Several values for each index.
#[derive(Debug)]
pub struct Rows<'a, T> {
    /// The values of the indices, one row after the other.
    pub values: &'a mut [T],
    /// The values of one index, at least 1; the last may have fewer.
    pub each: usize,
}

impl<T: Send> Target for Rows<'_, T> {
    fn count(&self) -> usize {
        self.values.len().div_ceil(self.each)
    }
    fn split(self, count: usize) -> [Self; 2] {
        let (first, others) = self.values.split_at_mut(self.values.len().min(count * self.each));
        [first, others].map(|values| Rows { values, each: self.each })
    }
}

/// A target that may be left out; without one there is no limit of the indices.
impl<T: Target> Target for Option<T> {
    fn count(&self) -> usize {
        self.as_ref().map_or(usize::MAX, T::count)
    }
    fn split(self, count: usize) -> [Self; 2] {
        self.map_or([None, None], |target| target.split(count).map(Some))
    }
}

/// Two targets of the same indices.
impl<A: Target, B: Target> Target for (A, B) {
    fn count(&self) -> usize {
        self.0.count().min(self.1.count())
    }
    fn split(self, count: usize) -> [Self; 2] {
        let ([a, c], [b, d]) = (self.0.split(count), self.1.split(count));
        [(a, b), (c, d)]
    }
}

/// Runs `body` for each block of the target's indices, with its part of the target. All blocks are `block` long but the last.
pub fn fill<T: Target>(target: T, block: usize, body: &(dyn Fn(Range<usize>, T) + Sync)) {
    let (count, block) = (target.count(), block.max(1));
    if count <= block {
        if count > 0 {
            body(0..count, target);
        }
        return;
    }
    let mut parts = Vec::with_capacity(count.div_ceil(block));
    let mut others = target;
    for first in (0..count).step_by(block) {
        let range = first..count.min(first + block);
        let [part, rest] = others.split(range.len());
        parts.push(Mutex::new(Some((range, part))));
        others = rest;
    }
    run(parts.len(), &|n| {
        let part = lock(&parts[n]).take();
        if let Some((range, part)) = part {
            body(range, part);
        }
    });
}

/// Runs `job` for each number below `jobs`. The jobs have no type of their own, so this is compiled once for the whole program.
fn run(jobs: usize, job: &(dyn Fn(usize) + Sync)) {
    #[cfg(target_arch = "wasm32")]
    (0..jobs).for_each(job);
    #[cfg(not(target_arch = "wasm32"))]
    (0..jobs).into_par_iter().for_each(job);
}

/// Locks a value that only one job uses. A panic in a job ends the whole loop, so the poison of a lock has no meaning.
fn lock<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs both at once, as far as there are threads.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    #[cfg(target_arch = "wasm32")]
    return (a(), b());
    #[cfg(not(target_arch = "wasm32"))]
    rayon::join(a, b)
}

/// The number of threads.
#[must_use]
pub fn threads() -> usize {
    #[cfg(target_arch = "wasm32")]
    return 1;
    #[cfg(not(target_arch = "wasm32"))]
    rayon::current_num_threads()
}

/// Sorts values; the order of equal ones is not kept.
pub fn sort<T: Send>(values: &mut [T], order: impl Fn(&T, &T) -> Ordering + Sync) {
    #[cfg(target_arch = "wasm32")]
    values.sort_unstable_by(order);
    #[cfg(not(target_arch = "wasm32"))]
    values.par_sort_unstable_by(order);
}

/// Adds bytes to a hash.
pub fn hash<'a>(hasher: &'a mut Hasher, bytes: &[u8]) -> &'a mut Hasher {
    #[cfg(target_arch = "wasm32")]
    return hasher.update(bytes);
    #[cfg(not(target_arch = "wasm32"))]
    hasher.update_rayon(bytes)
}

/// Appends the value of each `size` items. Each loop is compiled anew, but the new memory is first written by all threads, not by the one
/// that appends.
pub fn extend<A: Sync, T: Send>(values: &mut Vec<T>, items: &[A], size: usize, of: impl Fn(&[A]) -> T + Send + Sync) {
    #[cfg(target_arch = "wasm32")]
    values.extend(items.chunks_exact(size).map(of));
    #[cfg(not(target_arch = "wasm32"))]
    values.par_extend(items.par_chunks_exact(size).map(of));
}

/// Runs `body` for each chunk of `size` values, with its number; the last may be shorter.
pub fn chunks<T: Send>(values: &mut [T], size: usize, body: &(dyn Fn(usize, &mut [T]) + Sync)) {
    fill(Rows { values, each: size.max(1) }, 1, &|range, rows| body(range.start, rows.values));
}

/// Runs `each` for all values, with their indices; the work for one is a few instructions.
pub fn each<T: Send>(values: &mut [T], each: impl Fn(usize, &mut T) + Sync) {
    fill(values, CHEAP, &|range, part| range.zip(part).for_each(|(n, value)| each(n, value)));
}

/// Runs `each` for the values and the others of their indices, as far as there are both; the work for one is a few instructions.
pub fn zip<T: Send, A: Sync>(values: &mut [T], others: &[A], each: impl Fn(&mut T, &A) + Sync) {
    let count = values.len().min(others.len());
    fill(&mut values[..count], CHEAP, &|range, part| {
        part.iter_mut().zip(&others[range]).for_each(|(value, other)| each(value, other))
    });
}

/// The value of each block of the target's indices, in the order of the blocks.
pub fn blocks<T: Target, V: Send>(target: T, block: usize, of: &(dyn Fn(Range<usize>, T) -> V + Sync)) -> Vec<V> {
    let block = block.max(1);
    let values: Vec<_> = (0..target.count().div_ceil(block)).map(|_| Mutex::new(None)).collect();
    fill(target, block, &|range, part| {
        let place = &values[range.start / block];
        let value = of(range, part);
        *lock(place) = Some(value);
    });
    values.into_iter().filter_map(|value| value.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// The values that `body` appends for each block of `0..count`, in the order of the blocks.
pub fn collect<T: Send>(count: usize, block: usize, body: &(dyn Fn(Range<usize>, &mut Vec<T>) + Sync)) -> Vec<T> {
    joined(blocks(0..count, block, &|range, _| {
        let mut part = Vec::new();
        body(range, &mut part);
        part
    }))
}

/// The values of all parts, one part after the other.
fn joined<T>(mut parts: Vec<Vec<T>>) -> Vec<T> {
    if parts.len() <= 1 {
        return parts.pop().unwrap_or_default();
    }
    let mut all = Vec::with_capacity(parts.iter().map(Vec::len).sum());
    parts.iter_mut().for_each(|part| all.append(part));
    all
}

/// The values of the numbers below `count`, in their order.
pub fn values<T: Send>(count: usize, block: usize, each: impl Fn(usize) -> T + Sync) -> Vec<T> {
    collect(count, block, &|range, out| out.extend(range.map(&each)))
}

/// The same of plain values, which are written in place; the work for each is a few instructions.
pub fn from_fn<T: Zeroable + Send>(count: usize, each: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = zeroed(count);
    self::each(&mut values, |n, value| *value = each(n));
    values
}

/// The plain values of the items, in their order; the work for each is a few instructions.
pub fn map<A: Sync, T: Zeroable + Send>(items: &[A], each: impl Fn(&A) -> T + Sync) -> Vec<T> {
    let mut values = zeroed(items.len());
    zip(&mut values, items, |value, item| *value = each(item));
    values
}

/// The values reduced to one by `both`, which may be applied in any order; the work for each is a few instructions.
pub fn reduce<T: Copy + Send + Sync>(values: &[T], start: T, both: impl Fn(T, T) -> T + Sync) -> T {
    let of = |values: &[T]| values.iter().fold(start, |all, value| both(all, *value));
    of(&blocks(0..values.len(), CHEAP, &|range, _| of(&values[range])))
}

/// The values of each block of `0..count`, in the order of the blocks.
///
/// # Errors
/// The error of the first block that has one, in the order of the blocks. Blocks behind one that failed may not be run.
pub fn try_collect<T: Send, E: Send>(
    count: usize,
    block: usize,
    of: &(dyn Fn(Range<usize>) -> Result<Vec<T>, E> + Sync),
) -> Result<Vec<T>, E> {
    let failed = AtomicUsize::new(usize::MAX);
    let parts = blocks(0..count, block, &|range, _| {
        let first = range.start;
        let part = if first < failed.load(Relaxed) { of(range) } else { Ok(Vec::new()) };
        if part.is_err() {
            failed.fetch_min(first, Relaxed);
        }
        part
    });
    parts.into_iter().collect::<Result<_, E>>().map(joined)
}

/// The number of indices below `count` for which `is` holds; the work for each is a few instructions.
pub fn count(count: usize, is: impl Fn(usize) -> bool + Sync) -> usize {
    blocks(0..count, CHEAP, &|range, _| range.filter(|n| is(*n)).count()).into_iter().sum()
}

/// The place of the first item for which `is` holds; the work for each is a few instructions.
pub fn position<A: Sync>(items: &[A], is: impl Fn(&A) -> bool + Sync) -> Option<usize> {
    let none = |range: Range<usize>| match items[range.clone()].iter().position(&is) {
        Some(n) => Err(range.start + n),
        None => Ok(Vec::<()>::new()),
    };
    try_collect(items.len(), CHEAP, &none).err()
}

/// Whether `is` holds for a block of `0..count`. Blocks behind one may not be asked.
pub fn any(count: usize, block: usize, is: &(dyn Fn(Range<usize>) -> bool + Sync)) -> bool {
    let none = |range| if is(range) { Err(()) } else { Ok(Vec::<()>::new()) };
    try_collect(count, block, &none).is_err()
}

/// Whether `is` holds for all items; the work for each is a few instructions.
pub fn all<A: Sync>(items: &[A], is: impl Fn(&A) -> bool + Sync) -> bool {
    !any(items.len(), CHEAP, &|range| !items[range].iter().all(&is))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lengths around the lengths of blocks.
    const CASES: [(usize, usize); 9] = [(0, 1), (1, 1), (1, 4), (3, 4), (4, 4), (5, 4), (17, 4), (1000, 7), (5, 0)];

    fn with_threads(test: impl Fn() + Sync + Send) {
        for threads in [1, 2, 16] {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(&test);
        }
    }

    #[test]
    fn blocks_are_those_of_chunks() {
        with_threads(|| {
            for (count, block) in CASES {
                let all: Vec<usize> = (0..count).collect();
                let expected: Vec<_> = all.chunks(block.max(1)).map(|chunk| chunk[0]..chunk[0] + chunk.len()).collect();
                assert_eq!(collect(count, block, &|range, out| out.push(range)), expected, "{count}, {block}");
                let (mut ones, mut threes) = (vec![0; count], vec![0; (3 * count).saturating_sub(1)]);
                let target = ((&mut ones[..], None::<&mut [u8]>), Rows { values: &mut threes, each: 3 });
                fill(target, block, &|range, ((one, none), three)| {
                    assert!(expected.contains(&range) && one.len() == range.len() && none.is_none());
                    one.iter_mut().zip(range.clone()).for_each(|(one, n)| *one = n);
                    three.values.iter_mut().zip(3 * range.start..).for_each(|(three, n)| *three = n);
                });
                assert_eq!(ones, all);
                assert!(threes.iter().enumerate().all(|(n, three)| n == *three));
            }
        });
    }

    #[test]
    fn values_keep_their_order() {
        with_threads(|| {
            for (count, block) in CASES {
                let even = collect(count, block, &|range, out| out.extend(range.filter(|n| n % 2 == 0)));
                assert_eq!(even, (0..count).filter(|n| n % 2 == 0).collect::<Vec<_>>());
                let digits = blocks(0..count, block, &|range, _| range.map(|n| n.to_string()).collect::<String>());
                let expected: String = (0..count).map(|n| n.to_string()).collect();
                assert_eq!(digits.concat(), expected);
            }
            assert_eq!(map(&[1, 2, 3], |n| n * n), [1, 4, 9]);
        });
    }

    #[test]
    fn loops_over_many_values_are_those_of_one_thread() {
        with_threads(|| {
            for count in [0, 1, CHEAP, 3 * CHEAP + 1] {
                let mixed = from_fn(count, |n| n * 7919 % 10_007);
                assert_eq!(mixed, (0..count).map(|n| n * 7919 % 10_007).collect::<Vec<_>>());
                assert_eq!((values(count, 5, |n| mixed[n]), map(&mixed, |n| *n)), (mixed.clone(), mixed.clone()));
                assert_eq!(reduce(&mixed, 0, usize::max), mixed.iter().copied().max().unwrap_or(0));
                let most = count.saturating_sub(1);
                assert_eq!(position(&mixed, |n| *n == 10_007), None);
                assert_eq!(position(&mixed, |n| *n == 7919), (count > 1).then_some(1));
                assert!(all(&mixed, |n| *n < 10_007) && (count == 0 || !all(&mixed, |n| *n != mixed[most])));
                let (mut sorted, mut sums, mut more) = (mixed.clone(), mixed.clone(), vec![1]);
                sort(&mut sorted, usize::cmp);
                zip(&mut sums, &mixed, |sum, n| *sum += n);
                extend(&mut more, &mixed, 2, |pair| pair[1]);
                assert!(sorted.is_sorted() && sorted.len() == count);
                assert!(more[1..].iter().eq(mixed.iter().skip(1).step_by(2)));
                assert!(sums.iter().zip(&mixed).all(|(sum, n)| *sum == 2 * n));
                let bytes: Vec<u8> = mixed.iter().map(|n| *n as u8).collect();
                assert_eq!(hash(&mut Hasher::new(), &bytes).finalize(), blake3::hash(&bytes));
            }
        });
    }

    #[test]
    fn the_error_is_that_of_the_first_block_that_fails() {
        with_threads(|| {
            for wrong in [0, 1, 500, 998] {
                let part = |range: Range<usize>| {
                    if range.end > wrong { Err(range.start) } else { Ok(range.collect::<Vec<_>>()) }
                };
                assert_eq!(try_collect(1000, 10, &part), Err(wrong / 10 * 10));
                assert!(any(1000, 10, &|range| range.contains(&wrong)));
            }
            assert_eq!(try_collect::<_, ()>(25, 10, &|range| Ok(range.collect())), Ok((0..25).collect()));
            assert!(!any(1000, 10, &|range| range.contains(&1000)));
        });
    }
}
