//! The bytes of a scene file, decompressed. Every reader takes its bytes from an [`Input`] and from nowhere else: it ends
//! when the work is cancelled, also while a pipe is silent, and it refuses a stream that goes on without holding anything.

use crate::error::{Error, Result};
use crate::progress::Watch;
use bzip2::bufread::MultiBzDecoder;
use flate2::bufread::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

/// Bytes that a stream of unknown length may have without a particle or a frame among them. A file that is not compressed
/// has an end, so it may be as long as it is.
const SILENCE: u64 = 1 << 29;

/// Bytes of a compressed stream that may decompress to nothing; a block of bzip2 has less than one of 2^20.
const BARREN: u64 = 4 << 20;

/// Bytes that are read at once.
const BLOCK: usize = 1 << 16;

/// How long a silent pipe is waited for before the watch is asked again.
const PATIENCE: Duration = Duration::from_millis(50);

/// An opened file, pipe or standard input.
pub(crate) struct Input {
    reader: Box<dyn BufRead + Send>,
    gauge: Gauge,
    /// Bytes since the gauge was last told.
    since: u64,
    /// Bytes delivered, and the length of a file that is not compressed, else 0.
    delivered: u64,
    length: u64,
    packed: bool,
}

impl Input {
    /// Opens `path`; `-` is standard input. gzip and bzip2 are known by their first bytes.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Interrupted`], [`Error::Limits`] where a pipe needs a thread and there is none.
    pub(crate) fn open(path: &Path, watch: &Watch) -> Result<Self> {
        let metadata = std::fs::metadata(path).ok().filter(|_| path != Path::new("-"));
        let waits =
            path == Path::new("-") || metadata.as_ref().is_some_and(|found| !found.is_file() && !found.is_dir());
        if waits {
            return Self::unpack(Box::new(Pipe::open(path, watch)?), 0, watch).map_err(|e| Error::read(path, e));
        }
        let file = File::open(path).map_err(|e| Error::read(path, e))?;
        let length = metadata.map_or(0, |found| found.len());
        Self::unpack(Box::new(file), length, watch).map_err(|e| Error::read(path, e))
    }

    /// The bytes of any reader, compressed or not.
    ///
    /// # Errors
    /// The reader's own.
    pub(crate) fn of(reader: Box<dyn Read + Send>, watch: &Watch) -> io::Result<Self> {
        Self::unpack(reader, 0, watch)
    }

    fn unpack(raw: Box<dyn Read + Send>, length: u64, watch: &Watch) -> io::Result<Self> {
        let gauge = Gauge { watch: watch.clone(), counts: Arc::default() };
        let mut raw = BufReader::with_capacity(BLOCK, Raw { reader: raw, gauge: gauge.clone() });
        let mut magic = Vec::new();
        (&mut raw).take(3).read_to_end(&mut magic)?;
        let packed = matches!(magic[..], [0x1f, 0x8b, _] | [b'B', b'Z', b'h']);
        let bzip2 = magic.starts_with(b"B");
        let raw = Cursor::new(magic).chain(raw);
        let reader: Box<dyn BufRead + Send> = match packed {
            true if bzip2 => Box::new(BufReader::with_capacity(BLOCK, MultiBzDecoder::new(raw))),
            true => Box::new(BufReader::with_capacity(BLOCK, MultiGzDecoder::new(raw))),
            false => Box::new(raw),
        };
        let length = if packed { 0 } else { length };
        Ok(Self { reader, gauge, since: 0, delivered: 0, length, packed })
    }

    /// Whether the bytes come from a compressed file.
    pub(crate) fn is_packed(&self) -> bool {
        self.packed
    }

    /// The length of a file that is not compressed, else 0: nothing is known.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    /// The first bytes, at most so many; they are delivered again.
    ///
    /// # Errors
    /// As reading.
    pub(crate) fn look(&mut self, most: u64) -> io::Result<Vec<u8>> {
        let mut start = Vec::new();
        self.by_ref().take(most).read_to_end(&mut start)?;
        let rest = std::mem::replace(&mut self.reader, Box::new(io::empty()));
        self.reader = Box::new(Cursor::new(start.clone()).chain(rest));
        self.delivered = 0;
        Ok(start)
    }

    /// A particle was found: the stream holds something.
    pub(crate) fn found(&self) {
        self.gauge.counts.found();
    }

    /// For a reader that has the input only through others.
    pub(crate) fn counts(&self) -> Arc<Counts> {
        Arc::clone(&self.gauge.counts)
    }
}

#[cfg(test)]
impl Input {
    /// Bytes in memory, for the readers' tests.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Self {
        let reader = Box::new(Cursor::new(bytes.to_vec()));
        let gauge = Gauge { watch: Watch::default(), counts: Arc::default() };
        Self { reader, gauge, since: 0, delivered: 0, length: bytes.len() as u64, packed: false }
    }
}

impl BufRead for Input {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.since >= BLOCK as u64 {
            let since = std::mem::take(&mut self.since);
            self.gauge.pass(&self.gauge.counts.silent, since, SILENCE.max(self.length))?;
        }
        let buffer = self.reader.fill_buf()?;
        if buffer.is_empty() && self.delivered < self.length {
            let problem = format!(
                "it ended after {} of {} bytes: was it changed while it was read?",
                self.delivered, self.length
            );
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        }
        if !buffer.is_empty() {
            self.gauge.counts.barren.store(0, Ordering::Relaxed);
        }
        Ok(buffer)
    }

    fn consume(&mut self, bytes: usize) {
        self.since += bytes as u64;
        self.delivered += bytes as u64;
        self.reader.consume(bytes);
    }
}

impl Read for Input {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let available = self.fill_buf()?;
        let read = available.len().min(bytes.len());
        bytes[..read].copy_from_slice(&available[..read]);
        self.consume(read);
        Ok(read)
    }
}

/// Who may end the reading, and how much has passed in vain.
#[derive(Clone)]
struct Gauge {
    watch: Watch,
    counts: Arc<Counts>,
}

/// What passed in vain.
#[derive(Default)]
pub(crate) struct Counts {
    /// Decompressed bytes since something was found in them.
    silent: AtomicU64,
    /// Compressed bytes since the last decompressed one.
    barren: AtomicU64,
}

impl Counts {
    /// As [`Input::found`].
    pub(crate) fn found(&self) {
        self.silent.store(0, Ordering::Relaxed);
    }
}

impl Gauge {
    /// Adds bytes to a count, of which there may be so many.
    fn pass(&self, count: &AtomicU64, bytes: u64, most: u64) -> io::Result<()> {
        self.watch.check().map_err(io::Error::other)?;
        if count.fetch_add(bytes, Ordering::Relaxed) + bytes <= most {
            return Ok(());
        }
        let problem = format!("{most} bytes of the stream hold neither a sphere nor the end");
        let mend = "is it a scene? of a file that is not compressed, any length is read".into();
        Err(io::Error::other(Error::Limits { problem, mend }))
    }
}

/// Bytes as they come from the file: a compressed stream may be endless and yet hold nothing.
struct Raw {
    reader: Box<dyn Read + Send>,
    gauge: Gauge,
}

impl Read for Raw {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.reader.read(bytes)?;
        self.gauge.pass(&self.gauge.counts.barren, read as u64, BARREN)?;
        Ok(read)
    }
}

/// What may be silent for ever: standard input, a named pipe, a device. A thread of its own opens and reads it, so that
/// whoever waits for it can stop waiting; the thread ends with the stream or with the process.
struct Pipe {
    blocks: Receiver<io::Result<Vec<u8>>>,
    block: Cursor<Vec<u8>>,
    watch: Watch,
}

impl Pipe {
    fn open(path: &Path, watch: &Watch) -> Result<Self> {
        let (sender, blocks) = sync_channel(4);
        let file = (path != Path::new("-")).then(|| path.to_path_buf());
        let started = thread::Builder::new().name("halfline input".into()).spawn(move || deliver(file, &sender));
        started.map_err(|e| Error::Limits {
            problem: format!("{}: no thread could be started to read it: {e}", path.display()),
            mend: "give a file, or allow the process more threads".into(),
        })?;
        Ok(Self { blocks, block: Cursor::default(), watch: watch.clone() })
    }
}

/// Sends what a file, or standard input, holds; nobody to take it is the end.
fn deliver(file: Option<PathBuf>, blocks: &SyncSender<io::Result<Vec<u8>>>) {
    let opened: io::Result<Box<dyn Read>> = match file {
        Some(path) => File::open(path).map(|file| Box::new(file) as Box<dyn Read>),
        None => Ok(Box::new(io::stdin().lock())),
    };
    let mut reader = match opened {
        Ok(reader) => reader,
        Err(error) => return drop(blocks.send(Err(error))),
    };
    loop {
        let mut block = vec![0; BLOCK];
        let block = match reader.read(&mut block) {
            Ok(0) => return,
            Ok(read) => {
                block.truncate(read);
                Ok(block)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => Err(error),
        };
        let failed = block.is_err();
        if blocks.send(block).is_err() || failed {
            return;
        }
    }
}

impl Read for Pipe {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = self.block.read(bytes)?;
            if read > 0 || bytes.is_empty() {
                return Ok(read);
            }
            match self.blocks.recv_timeout(PATIENCE) {
                Ok(block) => self.block = Cursor::new(block?),
                Err(RecvTimeoutError::Timeout) => self.watch.check().map_err(io::Error::other)?,
                Err(RecvTimeoutError::Disconnected) => return Ok(0),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Cancel;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn gz(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).expect("in memory");
        encoder.finish().expect("in memory")
    }

    fn error_of(mut input: Input) -> Error {
        let error = io::copy(&mut input, &mut io::sink()).expect_err("an endless stream");
        Error::read("text", error)
    }

    #[test]
    fn an_endless_empty_stream_is_refused_also_when_compressed() {
        let watch = Watch::default();
        let plain = Input::of(Box::new(io::repeat(b'\n')), &watch).expect("opened");
        assert!(matches!(error_of(plain), Error::Limits { .. }));
        // Zeros compress to a thousandth, and empty members to nothing.
        let bomb = gz(&vec![b' '; 1 << 24]);
        for members in [bomb, gz(b"")] {
            let mut at = 0;
            let endless = std::iter::repeat_with(move || {
                at = (at + 1) % members.len();
                members[(at + members.len() - 1) % members.len()]
            });
            let input = Input::of(Box::new(Bytes(endless)), &watch).expect("opened");
            assert!(input.is_packed());
            assert!(matches!(error_of(input), Error::Limits { .. }));
        }
    }

    /// An iterator of bytes as a reader.
    struct Bytes<I>(I);

    impl<I: Iterator<Item = u8>> Read for Bytes<I> {
        fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
            Ok(bytes.iter_mut().zip(&mut self.0).map(|(byte, next)| *byte = next).count())
        }
    }

    #[test]
    fn a_stream_with_content_is_read_until_it_is_cancelled() {
        let cancel = Cancel::default();
        let watch = Watch::default().cancelled_by(&cancel);
        let mut input = Input::of(Box::new(io::repeat(b'\n')), &watch).expect("opened");
        let mut block = vec![0; 1 << 20];
        for _ in 0..3 * (SILENCE >> 20) {
            input.read_exact(&mut block).expect("found again and again");
            input.found();
        }
        cancel.cancel();
        assert!(matches!(error_of(input), Error::Interrupted));
    }

    #[test]
    fn the_first_bytes_are_read_again() {
        let mut input = Input::of(Box::new(Cursor::new(gz(b"abcdef"))), &Watch::default()).expect("opened");
        assert_eq!(input.look(4).expect("bytes"), b"abcd");
        let mut all = Vec::new();
        input.read_to_end(&mut all).expect("bytes");
        assert_eq!(all, b"abcdef");
    }

    #[test]
    fn a_file_that_shrinks_while_it_is_read_is_an_error() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.csv");
        std::fs::write(&path, vec![b'\n'; 1 << 20]).expect("a file");
        let mut input = Input::open(&path, &Watch::default()).expect("opened");
        File::options().write(true).open(&path).and_then(|file| file.set_len(1 << 19)).expect("shorter");
        let error = io::copy(&mut input, &mut io::sink()).expect_err("cut short").to_string();
        assert!(error.contains("524288 of 1048576"), "{error}");
    }
}
