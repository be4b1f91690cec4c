//! The server: the port, a thread for each connection, and the end.

use crate::exchange::{BUSY, Phase, converse};
use crate::reply::Reply;
use crate::routes::Routes;
use crate::slots::{ConnectionState, Slots};
use crate::stage::{GoOn, Stage};
use crate::timed::Timed;
use std::collections::VecDeque;
use std::io::{self, Read};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// The port that is tried first where none is given.
pub const PORT: u16 = 8642;

/// The most connections at a time: far more than are at work, so that many strangers do not keep the owner out.
const CONNECTIONS: usize = 128;

/// The slowest that an answer may be taken, in bytes a second: a picture through a slow line takes longer than a request.
const SLOWEST: usize = 64 << 10;

/// The time between two looks for the end of the server.
const TICK: Duration = Duration::from_millis(50);
/// The time that connections get to end.
const PATIENCE: Duration = Duration::from_millis(300);

/// The limits of time for connections.
#[derive(Debug, Clone, Copy)]
#[doc(hidden)]
pub struct Times {
    /// A request from its first to its last byte, and the first bytes of an answer.
    pub request: Duration,
    /// A connection until its next request.
    pub idle: Duration,
}

/// A server that listens on 127.0.0.1 and waits for [`run`](Self::run).
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
    times: Times,
}

/// The state that the threads of the server share.
struct Shared {
    routes: Routes,
    token: String,
    times: Times,
    slots: Slots,
    has_ended: AtomicBool,
}

impl Server {
    /// Binds a port of 127.0.0.1: the given one, or else [`PORT`], and a free one if that is taken. Port 0 is a free one.
    pub fn bind(port: Option<u16>) -> io::Result<Self> {
        let at = |port| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
        let listener = match port {
            Some(port) => at(port),
            None => at(PORT).or_else(|_| at(0)),
        }?;
        let address = listener.local_addr()?;
        let mut random = [0; 16];
        getrandom::fill(&mut random).map_err(|error| io::Error::other(format!("no random numbers: {error}")))?;
        let token = random.iter().map(|byte| format!("{byte:02x}")).collect();
        let times = Times { request: Duration::from_secs(10), idle: Duration::from_secs(60) };
        Ok(Self { listener, address, token, times })
    }

    /// With other times, for tests.
    #[doc(hidden)]
    pub fn with_times(self, times: Times) -> Self {
        Self { times, ..self }
    }

    /// The port.
    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// The address of the page, with the token in its fragment, which browsers do not send.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/#{}", self.port(), self.token)
    }

    /// Serves until `stop` is set, or until there was no request for as long as `idle`. It returns within half a second,
    /// also while the stage is at work; what that still does ends with the process.
    pub fn run(self, stage: Arc<dyn Stage>, idle: Option<Duration>, stop: &AtomicBool) -> io::Result<()> {
        let Self { listener, address, token, times } = self;
        let shared = Arc::new(Shared {
            routes: Routes::new(stage),
            token,
            times,
            slots: Slots::new(),
            has_ended: AtomicBool::new(false),
        });
        let acceptor = {
            let shared = shared.clone();
            thread::Builder::new().name("acceptor".into()).spawn(move || shared.accept(&listener))?
        };
        while !stop.load(Ordering::Relaxed)
            && !idle.is_some_and(|idle| shared.slots.are_unused_for(idle))
            && !acceptor.is_finished()
        {
            thread::sleep(TICK);
        }
        shared.has_ended.store(true, Ordering::Relaxed);
        shared.routes.close();
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end && !(acceptor.is_finished() && shared.slots.is_empty()) {
            // A connection of its own wakes the thread that waits for one.
            drop(TcpStream::connect_timeout(&address, TICK));
            shared.slots.close();
            thread::sleep(TICK / 10);
        }
        Ok(())
    }
}

impl Shared {
    /// Accepts connections until the end.
    fn accept(self: &Arc<Self>, listener: &TcpListener) {
        // Closing a connection with unread bytes would destroy the answer before it is read, so that the last few stay.
        let mut refused = VecDeque::new();
        while !self.has_ended.load(Ordering::Relaxed) {
            match listener.accept() {
                Ok(_) if self.has_ended.load(Ordering::Relaxed) => {}
                Ok((stream, _)) => {
                    refused.extend(self.receive(Arc::new(stream)));
                    refused.drain(..refused.len().saturating_sub(CONNECTIONS));
                }
                // Of a connection that is gone already, or there are too many open files.
                Err(_) => thread::sleep(TICK / 5),
            }
        }
    }

    /// Gives a connection a slot and a thread, or returns it refused.
    fn receive(self: &Arc<Self>, stream: Arc<TcpStream>) -> Option<Arc<TcpStream>> {
        let Some(number) = self.slots.take(stream.clone(), CONNECTIONS) else {
            let _ = stream.set_nonblocking(true);
            let _ = Reply::from(BUSY).write(&mut &*stream, false);
            let _ = stream.shutdown(Shutdown::Write);
            return Some(stream);
        };
        let shared = self.clone();
        let serve = move || {
            shared.serve(&stream, number);
            shared.slots.leave(number);
        };
        if thread::Builder::new().name("connection".into()).spawn(serve).is_err() {
            self.slots.leave(number);
        }
        None
    }

    /// Answers the requests of a connection.
    fn serve(&self, stream: &Arc<TcpStream>, number: u64) {
        let timed = Timed::new(stream);
        let _ = stream.set_nodelay(true);
        let goes_on = |phase| {
            let (state, time) = match phase {
                Phase::Idle => (Some(ConnectionState::Waiting), self.times.idle),
                Phase::Reading => (Some(ConnectionState::Reading), self.times.request),
                Phase::Working => (Some(ConnectionState::Working), self.times.request),
                Phase::Writing(bytes) => (None, self.times.request + Duration::from_secs((bytes / SLOWEST) as u64)),
            };
            timed.allow(time);
            let is_here = state.is_none_or(|state| self.slots.set(number, state));
            is_here && !self.has_ended.load(Ordering::Relaxed)
        };
        converse(&timed, &timed, (&self.routes, &self.token, &listens(stream)), &goes_on);
        // With unread bytes the last answer would be lost: the other side gets a while to stop.
        if self.slots.set(number, ConnectionState::Waiting) && stream.shutdown(Shutdown::Write).is_ok() {
            timed.allow(self.times.request.min(Duration::from_secs(1)));
            let mut reader = (&timed).take(1 << 20);
            let _ = io::copy(&mut reader, &mut io::sink());
        }
    }
}

/// Whether the client still waits for its answer, which it does until it closes its side. The socket is tested at most once in each
/// [`TICK`], while nothing is read or written.
fn listens(stream: &Arc<TcpStream>) -> GoOn {
    let (stream, known) = (Arc::clone(stream), Mutex::new((Instant::now(), true)));
    Arc::new(move || {
        // Others need not wait for a thread that asks.
        let Ok(mut known) = known.try_lock() else { return true };
        if known.1 && known.0.elapsed() >= TICK {
            *known = (Instant::now(), is_open(&stream));
        }
        known.1
    })
}

/// Whether the other side of a connection may still send.
fn is_open(stream: &TcpStream) -> bool {
    if stream.set_nonblocking(true).is_err() {
        return true;
    }
    let peeked = stream.peek(&mut [0]);
    let _ = stream.set_nonblocking(false);
    match peeked {
        Ok(bytes) => bytes > 0,
        Err(error) => matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted),
    }
}
