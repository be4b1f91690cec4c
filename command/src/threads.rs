//! Threads beside the workers of parallel loops, as far as the system allows them.

use halfline::error::Result;
use halfline::progress::Cancel;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;

/// Runs both, `background` on another thread where the system allows one.
pub(super) fn both<A, B: Send>(own: impl FnOnce() -> A, background: impl Fn() -> B + Sync) -> (A, B) {
    std::thread::scope(|scope| {
        let other = (!is_alone()).then(|| Builder::new().spawn_scoped(scope, &background));
        let first = own();
        match other {
            Some(Ok(running)) => (first, running.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))),
            _ => (first, background()),
        }
    })
}

/// An item, or what came of it, with its number from 0.
type Counted<T> = (u64, Result<T>);

/// Calls `each` with what `next` gives and a lane, and `done` with the results in the order of the items. `next` runs one
/// item ahead; it and each lane have threads of their own, as far as the system allows them. All are cancelled when one
/// fails.
///
/// # Errors
/// The first error in the order of the items.
pub fn pipeline<T: Send, L: Send, R: Send>(
    next: impl FnMut() -> Result<Option<T>> + Send,
    lanes: Vec<L>,
    cancel: &Cancel,
    each: impl Fn(&mut L, T) -> Result<R> + Sync,
    done: impl FnMut(R) -> Result<()>,
) -> Result<()> {
    let has_threads = lanes.len() > 1;
    stages(next, lanes, has_threads, cancel, each, done)
}

/// [`pipeline`] with one lane, which has a thread of its own: it works on an item while `done` works on the one before.
///
/// # Errors
/// As [`pipeline`].
pub(super) fn three_stages<T: Send, L: Send, R: Send>(
    next: impl FnMut() -> Result<Option<T>> + Send,
    lane: L,
    cancel: &Cancel,
    each: impl Fn(&mut L, T) -> Result<R> + Sync,
    done: impl FnMut(R) -> Result<()>,
) -> Result<()> {
    stages(next, vec![lane], true, cancel, each, done)
}

fn stages<T: Send, L: Send, R: Send>(
    mut next: impl FnMut() -> Result<Option<T>> + Send,
    lanes: Vec<L>,
    has_threads: bool,
    cancel: &Cancel,
    each: impl Fn(&mut L, T) -> Result<R> + Sync,
    mut done: impl FnMut(R) -> Result<()>,
) -> Result<()> {
    let (most, lanes, each) = (lanes.len(), Mutex::new(lanes), &each);
    let free = || lanes.lock().unwrap_or_else(PoisonError::into_inner).pop();
    let take = |waiting: &Mutex<Receiver<Counted<T>>>| waiting.lock().unwrap_or_else(PoisonError::into_inner).recv();
    let work = |waiting: &Mutex<Receiver<Counted<T>>>, results: &SyncSender<Counted<R>>| {
        let Some(mut lane) = free() else { return };
        while let Ok((number, item)) = take(waiting) {
            if results.send((number, item.and_then(|item| each(&mut lane, item)))).is_err() {
                return;
            }
        }
    };
    let work = &work;
    let finished = std::thread::scope(|scope| {
        let (items, waiting) = sync_channel(0);
        let next = &mut next;
        let make = move || {
            for number in 0.. {
                let item = next().transpose();
                let is_last = !matches!(item, Some(Ok(_)));
                if item.is_some_and(|item| items.send((number, item)).is_err()) || is_last {
                    return;
                }
            }
        };
        if is_alone() || Builder::new().name("ahead".into()).spawn_scoped(scope, make).is_err() {
            return None;
        }
        let waiting = Arc::new(Mutex::new(waiting));
        let (results, arriving) = sync_channel(0);
        let start = |number| {
            let (waiting, results) = (Arc::clone(&waiting), results.clone());
            Builder::new().name(format!("lane {number}")).spawn_scoped(scope, move || work(&waiting, &results))
        };
        let started = if has_threads { (0..most).map_while(|number| start(number).ok()).count() } else { 0 };
        drop(results);
        let finished = if started > 0 {
            in_order(arriving.iter()).try_for_each(|result| done(result?))
        } else {
            free().map_or(Ok(()), |mut lane| {
                std::iter::from_fn(|| take(&waiting).ok()).try_for_each(|(_, item)| done(each(&mut lane, item?)?))
            })
        };
        // The other threads may wait for a silent pipe, or to hand over what is no longer wanted: they find no receiver.
        cancel.cancel();
        drop((waiting, arriving));
        Some(finished)
    });
    finished.unwrap_or_else(|| {
        let Some(mut lane) = free() else { return Ok(()) };
        while let Some(item) = next()? {
            done(each(&mut lane, item)?)?;
        }
        Ok(())
    })
}

/// Numbered values in the order of their numbers, from 0.
fn in_order<T>(mut arriving: impl Iterator<Item = (u64, T)>) -> impl Iterator<Item = T> {
    let mut early = BTreeMap::new();
    (0..).map_while(move |expected| {
        while !early.contains_key(&expected) {
            let (number, value) = arriving.next()?;
            early.insert(number, value);
        }
        early.remove(&expected)
    })
}

/// Whether this is the only thread of the pool; it must then not block on other threads.
fn is_alone() -> bool {
    #[cfg(target_arch = "wasm32")]
    return true;
    #[cfg(not(target_arch = "wasm32"))]
    rayon::current_thread_index().is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use halfline::error::Error;
    use std::sync::Barrier;
    use std::time::Duration;

    /// Numbers up to `last`.
    fn up_to(last: u64) -> impl FnMut() -> Result<Option<u64>> + Send {
        let mut numbers = 1..=last;
        move || Ok(numbers.next())
    }

    #[test]
    fn lanes_work_together_and_results_come_in_order() {
        // Three lanes pass it only together.
        let all = Barrier::new(3);
        let mut results = Vec::new();
        let each = |_: &mut u8, number: u64| {
            all.wait();
            // The first of three takes longest.
            std::thread::sleep(Duration::from_millis(5 * (2 - (number - 1) % 3)));
            Ok(number * number)
        };
        let done = |square| {
            results.push(square);
            Ok(())
        };
        pipeline(up_to(12), vec![0; 3], &Cancel::default(), each, done).expect("no errors");
        assert_eq!(results, (1..=12).map(|n| n * n).collect::<Vec<u64>>());
    }

    #[test]
    fn the_lane_works_while_the_last_item_is_finished() {
        // The lane and the end pass it only together: the end of an item with the next item.
        let both = Barrier::new(2);
        let each = |count: &mut u64, number: u64| {
            *count += 1;
            if number > 1 {
                both.wait();
            }
            Ok((number, *count))
        };
        let mut results = Vec::new();
        let done = |result: (u64, u64)| {
            if result.0 < 5 {
                both.wait();
            }
            results.push(result);
            Ok(())
        };
        three_stages(up_to(5), 0, &Cancel::default(), each, done).expect("no errors");
        assert_eq!(results, (1..=5).map(|n| (n, n)).collect::<Vec<_>>());
    }

    #[test]
    fn the_first_error_in_order_ends_everything() {
        for lanes in [1, 4] {
            let (cancel, mut results) = (Cancel::default(), Vec::new());
            let each = |(): &mut (), number: u64| match number {
                5 => {
                    std::thread::sleep(Duration::from_millis(20));
                    Err(Error::settings("the fifth", "none"))
                }
                6 => Err(Error::settings("the sixth", "none")),
                _ => Ok(number),
            };
            let done = |number| {
                results.push(number);
                Ok(())
            };
            let error = pipeline(up_to(u64::MAX), vec![(); lanes], &cancel, each, done).expect_err("the fifth fails");
            assert!(error.to_string().contains("fifth"), "{error}");
            assert_eq!(results, [1, 2, 3, 4], "{lanes} lanes");
            assert!(cancel.is_cancelled(), "{lanes} lanes");
        }
    }
}
