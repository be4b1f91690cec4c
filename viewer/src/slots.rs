//! A bounded set of open connections. A new one evicts one that is not at work: the oldest without the token, or else
//! the one whose token was used least recently.

use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The activity of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ConnectionState {
    Waiting,
    /// It receives a request, or gets a file of the page, for which anyone may ask.
    Reading,
    /// It has shown the token and gets an answer.
    Working,
}

struct Slot {
    number: u64,
    stream: Arc<TcpStream>,
    state: ConnectionState,
    /// When it was opened or, with the token, when it was last used.
    since: Instant,
    /// Whether it has shown the token.
    has_token: bool,
}

impl Slot {
    /// The order of eviction, the smallest first: connections without the token, then the oldest; `None` for one at
    /// work.
    fn rank(&self) -> Option<(bool, Instant)> {
        (self.state != ConnectionState::Working).then_some((self.has_token, self.since))
    }
}

/// The open connections.
pub(crate) struct Slots(Mutex<List>);

struct List {
    slots: Vec<Slot>,
    next: u64,
    /// When the stage last began or ended to work.
    used: Instant,
}

/// The most connections that are at work at a time. Browsers open six.
const WORKING: usize = 8;

impl List {
    fn working(&self) -> usize {
        self.slots.iter().filter(|slot| slot.state == ConnectionState::Working).count()
    }
}

impl Slots {
    pub(crate) fn new() -> Self {
        Self(Mutex::new(List { slots: Vec::new(), next: 0, used: Instant::now() }))
    }

    fn lock(&self) -> MutexGuard<'_, List> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a connection, and evicts one if there are `most`. Returns its number; `None` if too many are at work.
    pub(crate) fn take(&self, stream: Arc<TcpStream>, most: usize) -> Option<u64> {
        let mut list = self.lock();
        if list.working() >= WORKING {
            return None;
        }
        if list.slots.len() >= most {
            let ranks = list.slots.iter().enumerate().filter_map(|(n, slot)| Some((slot.rank()?, n)));
            let (_, n) = ranks.min()?;
            // Its thread reads the end and leaves.
            let _ = list.slots.swap_remove(n).stream.shutdown(Shutdown::Both);
        }
        list.next += 1;
        let number = list.next;
        list.slots.push(Slot {
            number,
            stream,
            state: ConnectionState::Waiting,
            since: Instant::now(),
            has_token: false,
        });
        Some(number)
    }

    /// Says what a connection does; `false` if its slot has been given away, and for work if there is enough of it.
    pub(crate) fn set(&self, number: u64, state: ConnectionState) -> bool {
        let mut list = self.lock();
        let is_full = list.working() >= WORKING;
        let Some(slot) = list.slots.iter_mut().find(|slot| slot.number == number) else { return false };
        if slot.state != state {
            if state == ConnectionState::Working && is_full {
                return false;
            }
            let now = Instant::now();
            let is_used = [slot.state, state].contains(&ConnectionState::Working);
            slot.has_token |= state == ConnectionState::Working;
            slot.state = state;
            if slot.has_token {
                slot.since = now;
            }
            if is_used {
                list.used = now;
            }
        }
        true
    }

    /// The connection ends.
    pub(crate) fn leave(&self, number: u64) {
        // Only here is the end of work that took until the end of the connection.
        self.set(number, ConnectionState::Waiting);
        self.lock().slots.retain(|slot| slot.number != number);
    }

    /// Whether nothing was asked for so long.
    pub(crate) fn are_unused_for(&self, time: Duration) -> bool {
        let list = self.lock();
        list.used.elapsed() >= time && !list.slots.iter().any(|slot| slot.state == ConnectionState::Working)
    }

    /// Closes all connections: those that wait read the end, and answers that are written fail.
    pub(crate) fn close(&self) {
        self.lock().slots.iter().for_each(|slot| drop(slot.stream.shutdown(Shutdown::Both)));
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.lock().slots.is_empty()
    }
}
