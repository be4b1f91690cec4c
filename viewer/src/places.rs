//! A bounded set of open connections. A new one evicts one that is not at work: the oldest without the token, or else
//! the one whose token was used least recently.

use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The activity of a connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Doing {
    Waiting,
    /// It receives a request, or gets a file of the page, for which anyone may ask.
    Reading,
    /// It has shown the token and gets an answer.
    Working,
}

struct Place {
    number: u64,
    stream: Arc<TcpStream>,
    doing: Doing,
    /// When it was opened or, with the token, when it was last used.
    since: Instant,
    /// Whether it has shown the token.
    has_token: bool,
}

impl Place {
    /// The order of eviction, the smallest first: connections without the token, then the oldest; `None` for one at
    /// work.
    fn rank(&self) -> Option<(bool, Instant)> {
        (self.doing != Doing::Working).then_some((self.has_token, self.since))
    }
}

/// The open connections.
pub(crate) struct Places(Mutex<List>);

struct List {
    places: Vec<Place>,
    next: u64,
    /// When the stage last began or ended to work.
    used: Instant,
}

/// The most connections that are at work at a time. Browsers open six.
const WORKING: usize = 8;

impl List {
    fn working(&self) -> usize {
        self.places.iter().filter(|place| place.doing == Doing::Working).count()
    }
}

impl Places {
    pub(crate) fn new() -> Self {
        Self(Mutex::new(List { places: Vec::new(), next: 0, used: Instant::now() }))
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
        if list.places.len() >= most {
            let ranks = list.places.iter().enumerate().filter_map(|(n, place)| Some((place.rank()?, n)));
            let (_, n) = ranks.min()?;
            // Its thread reads the end and leaves.
            let _ = list.places.swap_remove(n).stream.shutdown(Shutdown::Both);
        }
        list.next += 1;
        let number = list.next;
        list.places.push(Place { number, stream, doing: Doing::Waiting, since: Instant::now(), has_token: false });
        Some(number)
    }

    /// Says what a connection does; `false` if its place has been given away, and for work if there is enough of it.
    pub(crate) fn set(&self, number: u64, doing: Doing) -> bool {
        let mut list = self.lock();
        let is_full = list.working() >= WORKING;
        let Some(place) = list.places.iter_mut().find(|place| place.number == number) else { return false };
        if place.doing != doing {
            if doing == Doing::Working && is_full {
                return false;
            }
            let now = Instant::now();
            let is_used = [place.doing, doing].contains(&Doing::Working);
            place.has_token |= doing == Doing::Working;
            place.doing = doing;
            if place.has_token {
                place.since = now;
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
        self.set(number, Doing::Waiting);
        self.lock().places.retain(|place| place.number != number);
    }

    /// Whether nothing was asked for so long.
    pub(crate) fn are_unused_for(&self, time: Duration) -> bool {
        let list = self.lock();
        list.used.elapsed() >= time && !list.places.iter().any(|place| place.doing == Doing::Working)
    }

    /// Closes all connections: those that wait read the end, and answers that are written fail.
    pub(crate) fn close(&self) {
        self.lock().places.iter().for_each(|place| drop(place.stream.shutdown(Shutdown::Both)));
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.lock().places.is_empty()
    }
}
