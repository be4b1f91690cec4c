//! Checks while the bytes of a file are read: for cancellation, and for streams that have no data for too long.

use halfline_ground::error::Error;
use halfline_ground::progress::Watch;
use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The most bytes of a stream of unknown length without a particle or a frame. An uncompressed file ends, so its length
/// is not limited.
pub(super) const SILENCE: u64 = 1 << 29;

/// The most compressed bytes that may decompress to nothing; a block of bzip2 has less than one of 2^20.
const BARREN: u64 = 4 << 20;

/// Checks for cancellation, and counts bytes without data.
#[derive(Clone)]
pub(super) struct Gauge {
    watch: Watch,
    pub(super) counts: Arc<Counts>,
}

/// Bytes without data.
#[derive(Default)]
pub(crate) struct Counts {
    /// Decompressed bytes since the last particle or frame.
    silent: AtomicU64,
    /// Compressed bytes since the last decompressed byte.
    barren: AtomicU64,
}

impl Counts {
    /// Reports a particle, which resets the count of bytes without one.
    pub(crate) fn found(&self) {
        self.silent.store(0, Ordering::Relaxed);
    }

    /// Reports decompressed bytes.
    pub(super) fn unpacked(&self) {
        self.barren.store(0, Ordering::Relaxed);
    }
}

impl Gauge {
    pub(super) fn new(watch: &Watch) -> Self {
        Self { watch: watch.clone(), counts: Arc::default() }
    }

    /// Counts decompressed bytes, of a file of `length` bytes or of 0, a stream of unknown length.
    pub(super) fn pass_silent(&self, bytes: u64, length: u64) -> io::Result<()> {
        self.pass(&self.counts.silent, bytes, SILENCE.max(length))
    }

    /// Adds bytes to a counter with the limit `most`.
    fn pass(&self, count: &AtomicU64, bytes: u64, most: u64) -> io::Result<()> {
        self.watch.check().map_err(io::Error::other)?;
        if count.fetch_add(bytes, Ordering::Relaxed) + bytes <= most {
            return Ok(());
        }
        let problem = format!("{most} bytes of the stream contain no particle");
        let mend = "check that it is a scene or particle file; an uncompressed file may have any length".into();
        Err(io::Error::other(Error::Limits { problem, mend }))
    }
}

/// The bytes of the file; a compressed stream may be endless without containing data.
pub(super) struct FileBytes {
    pub(super) reader: Box<dyn Read + Send>,
    pub(super) gauge: Gauge,
}

impl Read for FileBytes {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.reader.read(bytes)?;
        self.gauge.pass(&self.gauge.counts.barren, read as u64, BARREN)?;
        Ok(read)
    }
}
