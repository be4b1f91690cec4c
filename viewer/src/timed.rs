//! A socket with a time until which it reads and writes, however many pieces that takes.

use std::cell::Cell;
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// A socket and its time.
pub(crate) struct Timed<'a> {
    stream: &'a TcpStream,
    until: Cell<Instant>,
}

impl<'a> Timed<'a> {
    pub(crate) fn new(stream: &'a TcpStream) -> Self {
        Self { stream, until: Cell::new(Instant::now()) }
    }

    /// From now on it reads and writes for so long.
    pub(crate) fn allow(&self, time: Duration) {
        self.until.set(Instant::now() + time);
    }

    /// The time left. A socket's time-out of zero would mean none.
    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.until.get().saturating_duration_since(Instant::now());
        if left < Duration::from_millis(1) { Err(io::ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

impl Read for &Timed<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        (&*self.stream).read(bytes)
    }
}

impl Write for &Timed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        (&*self.stream).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
