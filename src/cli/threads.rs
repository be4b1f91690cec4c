//! The threads that share the work: as many as there are cores or as `RAYON_NUM_THREADS` says, within reason, and no more
//! than the system lets the process have.

use super::say;
use rayon::{ThreadBuilder, ThreadPoolBuilder};
use std::sync::mpsc::{Sender, channel};
use std::thread::{Builder, available_parallelism};

/// Threads beyond this number and beyond the number of cores are only a burden.
const MOST: usize = 256;

/// Starts the threads. Rayon starts them by itself otherwise, and panics where the system refuses one.
pub(super) fn start() {
    let cores = available_parallelism().map_or(1, usize::from);
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok()).filter(|n| *n > 0);
    let wanted = asked.unwrap_or(cores);
    let most = wanted.min(MOST.max(cores));
    if most < wanted {
        say(format_args!("warning: RAYON_NUM_THREADS asks for {wanted} threads: {most} are used"));
    }
    // Threads are made before the pool, which cannot be made twice: each waits for what it is to run.
    let waiting: Vec<_> = (0..most).map_while(|number| waiting_thread(number).ok()).collect();
    if waiting.len() < most {
        let made = waiting.len().max(1);
        say(format_args!("warning: the system allows {made} of {most} threads: the work takes longer"));
    }
    // Fails only where there is a pool already.
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

/// Whether this thread is the only one that does the pool's work: then nothing may wait for it elsewhere.
pub(super) fn is_alone() -> bool {
    rayon::current_thread_index().is_some()
}

/// A thread that runs what it is sent.
fn waiting_thread(number: usize) -> std::io::Result<Sender<ThreadBuilder>> {
    let (sender, receiver) = channel::<ThreadBuilder>();
    let run = move || {
        // The allocator gives a thread addresses of its own with its first request: before memory is checked, not after.
        drop(std::hint::black_box(Box::new(number)));
        if let Ok(thread) = receiver.recv() {
            thread.run();
        }
    };
    Builder::new().name(format!("worker {number}")).spawn(run).map(|_| sender)
}
