//! Schedules frame requests: one at a time, in order of arrival. A request cancels all earlier ones with smaller
//! numbers. A later request with a smaller number, from a page that was loaded again, is rendered in its turn.

use crate::stage::GoOn;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// The requests for frames.
#[derive(Default)]
pub(crate) struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// In the order of arrival, with the one that is rendered.
    requests: Vec<Arc<Request>>,
    is_rendering: bool,
}

/// A request.
struct Request {
    seq: u64,
    is_needless: AtomicBool,
}

/// A request from its arrival to its end.
pub(crate) struct Ticket {
    queue: Arc<Queue>,
    request: Arc<Request>,
    is_rendering: bool,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A request arrives.
    pub(crate) fn arrive(self: &Arc<Self>, seq: u64) -> Ticket {
        let request = Arc::new(Request { seq, is_needless: AtomicBool::new(false) });
        let mut state = self.lock();
        for other in state.requests.iter().filter(|other| other.seq < seq) {
            other.is_needless.store(true, Ordering::Relaxed);
        }
        state.requests.push(request.clone());
        self.changed.notify_all();
        Ticket { queue: Arc::clone(self), request, is_rendering: false }
    }

    /// Makes all requests superseded.
    pub(crate) fn clear(&self) {
        self.lock().requests.iter().for_each(|request| request.is_needless.store(true, Ordering::Relaxed));
        self.changed.notify_all();
    }
}

impl Ticket {
    /// Whether a newer request has arrived.
    pub(crate) fn is_needless(&self) -> bool {
        self.request.is_needless.load(Ordering::Relaxed)
    }

    /// Whether no newer request has arrived, for work that is not done here.
    pub(crate) fn go_on(&self) -> GoOn {
        let request = Arc::clone(&self.request);
        Arc::new(move || !request.is_needless.load(Ordering::Relaxed))
    }

    /// Waits until no earlier request is rendered; `false` if a newer request arrives before.
    pub(crate) fn wait(&mut self) -> bool {
        let mut state = self.queue.lock();
        while !self.is_needless() {
            let first = state.requests.iter().find(|request| !request.is_needless.load(Ordering::Relaxed));
            if !state.is_rendering && first.is_some_and(|first| Arc::ptr_eq(first, &self.request)) {
                state.is_rendering = true;
                self.is_rendering = true;
                return true;
            }
            state = self.queue.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        false
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        let mut state = self.queue.lock();
        state.requests.retain(|request| !Arc::ptr_eq(request, &self.request));
        state.is_rendering &= !self.is_rendering;
        self.queue.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_wins() {
        let queue = Arc::new(Queue::default());
        let mut first = queue.arrive(1);
        assert!(first.wait());
        let mut second = queue.arrive(2);
        let third = queue.arrive(3);
        assert!(first.is_needless() && second.is_needless() && !third.is_needless());
        assert!(!second.wait(), "it returns at once");
        drop((first, second));
        let mut third = third;
        assert!(third.wait());
    }

    #[test]
    fn a_page_that_begins_again_is_served() {
        let queue = Arc::new(Queue::default());
        drop(queue.arrive(5000));
        let old = queue.arrive(5001);
        let mut new = queue.arrive(1);
        assert!(!old.is_needless());
        drop(old);
        assert!(new.wait() && !new.is_needless());
        queue.clear();
        assert!(new.is_needless());
    }

    #[test]
    fn a_ticket_ends_with_its_thread() {
        let queue = Arc::new(Queue::default());
        let result = std::panic::catch_unwind(|| {
            assert!(queue.arrive(1).wait());
            let mut ticket = queue.arrive(2);
            assert!(ticket.wait());
            std::panic::resume_unwind(Box::new("the renderer fails"));
        });
        assert!(result.is_err() && queue.arrive(3).wait());
    }
}
