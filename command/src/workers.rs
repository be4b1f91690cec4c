//! The worker threads: as many as there are cores or as `RAYON_NUM_THREADS` says, up to a limit, and at most as many as
//! the system allows the process.

use super::messages::say;
use rayon::{ThreadBuilder, ThreadPoolBuilder};
use std::sync::mpsc::{Sender, channel};
use std::thread::{Builder, available_parallelism};

/// More threads than this, or than there are cores if that is more, slow the work down.
const MOST: usize = 256;

/// Starts the threads. Rayon would start them itself, but panics where the system refuses one.
pub(super) fn start() {
    let cores = available_parallelism().map_or(1, usize::from);
    let given = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok()).filter(|n| *n > 0);
    let requested = given.unwrap_or(cores);
    let most = requested.min(MOST.max(cores));
    if most < requested {
        say(format_args!("warning: RAYON_NUM_THREADS is {requested}, but {most} threads are used"));
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
