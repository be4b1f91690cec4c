//! The time in which a device has work.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use web_time::Instant;

/// The time in which some renderer of a device waits for work that it submitted. Clones measure the same device.
#[derive(Clone, Default)]
pub(super) struct Busy(Arc<Mutex<State>>);

#[derive(Clone, Copy, Default)]
struct State {
    /// The number of renderers that wait, and the time since which one does.
    waiting: u32,
    since: Option<Instant>,
    /// The time before that.
    before: Duration,
}

impl State {
    fn total(&self) -> Duration {
        self.before + self.since.map_or(Duration::ZERO, |since| since.elapsed())
    }
}

impl Busy {
    /// Does `work`, which submits work to the device and waits for it.
    pub(super) fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        self.change(|state| {
            state.since = state.since.or_else(|| Some(Instant::now()));
            state.waiting += 1;
        });
        let done = work();
        self.change(|state| {
            state.waiting -= 1;
            if state.waiting == 0 {
                (state.before, state.since) = (state.total(), None);
            }
        });
        done
    }

    /// The time so far.
    pub(super) fn total(&self) -> Duration {
        self.change(|state| state.total())
    }

    fn change<T>(&self, change: impl FnOnce(&mut State) -> T) -> T {
        // A thread that panicked left the numbers as they were.
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;
    use std::thread;

    const NAP: Duration = Duration::from_millis(20);

    #[test]
    fn time_counts_once_where_two_renderers_wait() {
        let (busy, both) = (Busy::default(), Barrier::new(2));
        let own = busy.clone();
        let start = Instant::now();
        let nap = |busy: &Busy| {
            busy.during(|| {
                both.wait();
                thread::sleep(NAP);
                both.wait();
            });
        };
        thread::scope(|scope| {
            scope.spawn(|| nap(&own));
            nap(&busy);
        });
        assert!((NAP..=start.elapsed()).contains(&busy.total()));
        let total = busy.total();
        thread::sleep(NAP);
        assert_eq!(busy.total(), total, "no renderer waits");
        own.during(|| thread::sleep(NAP));
        assert!(busy.total() >= total + NAP);
    }

    #[test]
    fn time_ends_with_the_last_wait() {
        let busy = Busy::default();
        busy.during(|| {
            busy.during(|| ());
            thread::sleep(NAP);
        });
        assert!(busy.total() >= NAP);
    }
}
