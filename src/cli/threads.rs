//! The worker threads: as many as there are cores or as `RAYON_NUM_THREADS` says, up to a limit, and at most as many as
//! the system allows the process.

use super::say;
use halfline::error::Result;
use halfline::progress::Cancel;
use rayon::{ThreadBuilder, ThreadPoolBuilder};
use std::sync::mpsc::{Sender, channel, sync_channel};
use std::thread::{Builder, available_parallelism};

/// More threads than this, or than there are cores if that is more, slow the work down.
const MOST: usize = 256;

/// Starts the threads. Rayon would start them itself, but panics where the system refuses one.
pub(super) fn start() {
    let cores = available_parallelism().map_or(1, usize::from);
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok()).filter(|n| *n > 0);
    let wanted = asked.unwrap_or(cores);
    let most = wanted.min(MOST.max(cores));
    if most < wanted {
        say(format_args!("warning: RAYON_NUM_THREADS is {wanted}, but {most} threads are used"));
    }
    // Threads are started before the pool, which cannot be made twice; each waits for its work.
    let waiting: Vec<_> = (0..most).map_while(|number| waiting_thread(number).ok()).collect();
    if waiting.len() < most {
        let made = waiting.len().max(1);
        say(format_args!("warning: the system allows only {made} of {most} threads, so the work takes longer"));
    }
    // Fails only if there is a pool already.
    let _ = match waiting.len() {
        0 => ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global(),
        made => {
            let mut waiting = waiting.into_iter();
            let hand_over = |thread| {
                let free = waiting.next().and_then(|free| free.send(thread).ok());
                free.ok_or_else(|| std::io::Error::other("the thread has ended"))
            };
            ThreadPoolBuilder::new().num_threads(made).spawn_handler(hand_over).build_global()
        }
    };
}

/// Runs both, `beside` on another thread where the system allows one.
pub(super) fn both<A, B: Send>(own: impl FnOnce() -> A, beside: impl Fn() -> B + Sync) -> (A, B) {
    std::thread::scope(|scope| {
        let other = (!is_alone()).then(|| Builder::new().spawn_scoped(scope, &beside));
        let first = own();
        match other {
            Some(Ok(running)) => (first, running.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))),
            _ => (first, beside()),
        }
    })
}

/// Calls `each` with what `next` gives, in order. `next` runs on another thread where the system allows one, one item
/// ahead, and is cancelled when `each` fails.
///
/// # Errors
/// The first error of either.
pub(super) fn ahead<T: Send>(
    mut next: impl FnMut() -> Result<Option<T>> + Send,
    cancel: &Cancel,
    mut each: impl FnMut(T) -> Result<()>,
) -> Result<()> {
    let done = std::thread::scope(|scope| {
        // An item is handed over when the one before it is done, so there are at most two.
        let (sender, receiver) = sync_channel(0);
        let next = &mut next;
        let make = move || loop {
            let item = next().transpose();
            let is_last = !matches!(item, Some(Ok(_)));
            if sender.send(item).is_err() || is_last {
                return;
            }
        };
        if is_alone() || Builder::new().name("ahead".into()).spawn_scoped(scope, make).is_err() {
            return None;
        }
        let done = receiver.iter().map_while(|item| item).try_for_each(|item| each(item?));
        // The other thread may wait for a silent pipe, or for this one to take its item.
        cancel.cancel();
        drop(receiver);
        Some(done)
    });
    done.unwrap_or_else(|| {
        while let Some(item) = next()? {
            each(item)?;
        }
        Ok(())
    })
}

/// Whether this is the only thread of the pool; it must then not block on other threads.
fn is_alone() -> bool {
    rayon::current_thread_index().is_some()
}

/// A thread that runs the closure it receives.
fn waiting_thread(number: usize) -> std::io::Result<Sender<ThreadBuilder>> {
    let (sender, receiver) = channel::<ThreadBuilder>();
    let run = move || {
        // The allocator reserves addresses for a thread at its first allocation; this makes it happen before memory is
        // checked.
        drop(std::hint::black_box(Box::new(number)));
        if let Ok(thread) = receiver.recv() {
            thread.run();
        }
    };
    Builder::new().name(format!("worker {number}")).spawn(run).map(|_| sender)
}
