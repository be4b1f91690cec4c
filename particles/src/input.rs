//! The decompressed bytes of a scene file. Every reader reads from an [`Input`]. Cancellation ends it, even while a
//! pipe is silent, and a stream that contains no data for too long is an error.

use super::gauge::{Counts, FileBytes, Gauge};
use super::packed::{MAGIC, Packing};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::progress::Watch;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

/// The bytes that a line or a number of a stream of unknown length counts for at least, since short ones take as long.
const LEAST: usize = 32;

/// Bytes per read.
const BLOCK: usize = 1 << 16;

/// The most bytes that are read at once; fewer than may decompress to nothing.
const LARGE: usize = 1 << 20;

/// The interval at which waiting for a silent pipe checks for cancellation.
const PATIENCE: Duration = Duration::from_millis(50);

/// The mark of byte order of UTF-8, which editors and spreadsheets write before a text.
const UTF8_MARK: &[u8; 3] = b"\xef\xbb\xbf";

/// The encoding, as iconv calls it, of a text in UTF-16 with these first 4 bytes: it has a mark of byte order, or every second byte is
/// 0. `None` for another file.
fn utf16_of(start: &[u8]) -> Option<&'static str> {
    let is_letter = |byte: &u8| (b' '..=b'~').contains(byte) || b"\t\n\r".contains(byte);
    match start {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        [a, 0, b, 0] if is_letter(a) && is_letter(b) => Some("UTF-16LE"),
        [0, a, 0, b] if is_letter(a) && is_letter(b) => Some("UTF-16BE"),
        _ => None,
    }
}

fn utf16(file: Place, encoding: &str) -> Error {
    let mend = format!("save it as UTF-8, for example with `iconv -f {encoding} -t UTF-8`");
    Error::scene(file, "this is a text in UTF-16, which is not supported", mend)
}

/// The text of a small file without a mark of byte order.
///
/// # Errors
/// [`Error::Scene`] for a text in UTF-16.
pub fn without_mark<'a>(bytes: &'a [u8], file: &Place) -> Result<&'a [u8]> {
    match utf16_of(&bytes[..bytes.len().min(4)]) {
        Some(encoding) => Err(utf16(file.clone(), encoding)),
        None => Ok(bytes.strip_prefix(UTF8_MARK).unwrap_or(bytes)),
    }
}

/// Fills `bytes`, less at the end of the stream; returns how many bytes there were.
///
/// # Errors
/// Errors of the reader.
pub(crate) fn fill(reader: &mut impl Read, bytes: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < bytes.len() {
        match reader.read(&mut bytes[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// Whether `path` is standard input or output.
#[must_use]
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether `path` is a pipe or a device, which is read and written directly and whose extension does not choose a format.
#[must_use]
pub fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// The name in messages of an input that can be read once: standard input, a pipe or a device; `None` for a file.
pub fn read_once(path: &Path) -> Option<&'static str> {
    if is_standard(path) { Some("standard input") } else { is_special(path).then_some("a pipe") }
}

/// An opened file, pipe or standard input.
pub struct Input {
    /// Bytes that were looked at, delivered before the bytes of the reader.
    ahead: Cursor<Vec<u8>>,
    reader: Box<dyn BufRead + Send>,
    gauge: Gauge,
    /// Bytes since the last check.
    since: u64,
    /// Bytes delivered, and the length of an uncompressed file, else 0.
    delivered: u64,
    length: u64,
    packed: bool,
    /// The encoding of a text in UTF-16.
    utf16: Option<&'static str>,
}

impl Input {
    /// Opens `path`; `-` is standard input. Compressed files are detected by their first bytes.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Interrupted`], [`Error::Limits`] where a pipe needs a thread that cannot be started.
    pub fn open(path: &Path, watch: &Watch) -> Result<Self> {
        if read_once(path).is_some() {
            let input = Self::unpack(Box::new(Pipe::open(path, watch)?), 0, watch);
            return input.map_err(|e| Error::read(path, e))?.without_utf16(path);
        }
        let file = File::open(path).map_err(|e| Error::read(path, e))?;
        let length = file.metadata().map_or(0, |found| found.len());
        Self::unpack(Box::new(file), length, watch).map_err(|e| Error::read(path, e))?.without_utf16(path)
    }

    /// The input from any reader, compressed or not.
    ///
    /// # Errors
    /// Errors of the reader.
    pub fn of(reader: Box<dyn Read + Send>, watch: &Watch) -> io::Result<Self> {
        Self::unpack(reader, 0, watch)
    }

    fn unpack(raw: Box<dyn Read + Send>, length: u64, watch: &Watch) -> io::Result<Self> {
        let gauge = Gauge::new(watch);
        let mut raw = BufReader::with_capacity(BLOCK, FileBytes { reader: raw, gauge: gauge.clone() });
        let mut magic = Vec::new();
        (&mut raw).take(MAGIC).read_to_end(&mut magic)?;
        let packing = Packing::of(&magic);
        let raw = Cursor::new(magic).chain(raw);
        let (reader, length): (Box<dyn BufRead + Send>, u64) = match packing {
            Some(packing) => (Box::new(BufReader::with_capacity(BLOCK, packing.reader(raw, &gauge.counts))), 0),
            None => (Box::new(raw), length),
        };
        let (ahead, packed) = (Cursor::default(), packing.is_some());
        let mut input = Self { ahead, reader, gauge, since: 0, delivered: 0, length, packed, utf16: None };
        input.pass_mark()?;
        Ok(input)
    }

    /// Skips the mark of byte order before a text in UTF-8.
    fn pass_mark(&mut self) -> io::Result<()> {
        let start = self.look(4)?;
        self.utf16 = utf16_of(&start);
        if start.starts_with(UTF8_MARK) {
            self.read_exact(&mut [0; UTF8_MARK.len()])?;
            self.length = self.length.saturating_sub(UTF8_MARK.len() as u64);
            self.delivered = 0;
        }
        Ok(())
    }

    /// The input, unless it is a text in UTF-16.
    ///
    /// # Errors
    /// [`Error::Scene`] for such a text.
    pub(crate) fn without_utf16(self, path: &Path) -> Result<Self> {
        match self.utf16 {
            Some(encoding) => Err(utf16(Place::file(path.display().to_string()), encoding)),
            None => Ok(self),
        }
    }

    /// Whether the input is compressed.
    pub(crate) fn is_packed(&self) -> bool {
        self.packed
    }

    /// The length of an uncompressed file; 0 where it is not known.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    /// The position of the next byte in the decompressed content, from 0.
    pub(crate) fn position(&self) -> u64 {
        self.delivered
    }

    /// The bytes of an uncompressed file that were not read yet; `None` where its length is not known.
    pub fn left(&self) -> Option<u64> {
        (self.length > 0).then(|| self.length.saturating_sub(self.delivered))
    }

    /// The first bytes, at most `most`. Later reads deliver them again.
    ///
    /// # Errors
    /// Errors of reading.
    pub fn look(&mut self, most: u64) -> io::Result<Vec<u8>> {
        let mut start = Vec::new();
        self.by_ref().take(most).read_to_end(&mut start)?;
        let mut ahead = start.clone();
        // Bytes of an earlier look that this one left.
        self.ahead.read_to_end(&mut ahead)?;
        self.ahead = Cursor::new(ahead);
        self.delivered = 0;
        Ok(start)
    }

    /// The next bytes: from `ahead`, else from the reader.
    fn source(&mut self) -> &mut (dyn BufRead + Send) {
        let is_ahead = self.ahead.position() < self.ahead.get_ref().len() as u64;
        if is_ahead { &mut self.ahead } else { &mut *self.reader }
    }

    /// Reports a particle, which resets the count of bytes without one.
    pub(crate) fn found(&self) {
        self.gauge.counts.found();
    }

    /// The counters, for a reader that does not hold the input itself.
    pub(crate) fn counts(&self) -> Arc<Counts> {
        Arc::clone(&self.gauge.counts)
    }
}

impl Input {
    /// Bytes in memory, which are not compressed.
    #[must_use]
    pub fn of_bytes(bytes: &[u8]) -> Self {
        let reader = Box::new(Cursor::new(bytes.to_vec()));
        let gauge = Gauge::new(&Watch::default());
        let (ahead, length) = (Cursor::default(), bytes.len() as u64);
        Self { ahead, reader, gauge, since: 0, delivered: 0, length, packed: false, utf16: None }
    }
}

impl Input {
    /// Checks the limit of bytes without a particle, from time to time.
    fn pass_silence(&mut self) -> io::Result<()> {
        if self.since >= BLOCK as u64 {
            let since = std::mem::take(&mut self.since);
            self.gauge.pass_silent(since, self.length)?;
        }
        Ok(())
    }

    /// Notes that `bytes` bytes are there to be delivered; 0 is the end.
    fn arrived(&self, bytes: usize) -> io::Result<()> {
        if bytes == 0 && self.delivered < self.length {
            let problem = format!(
                "the file ended after {} of {} bytes; it may have been changed while it was read",
                self.delivered, self.length
            );
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        }
        if bytes > 0 {
            self.gauge.counts.unpacked();
        }
        Ok(())
    }

    /// Counts delivered bytes.
    fn count(&mut self, bytes: usize) {
        self.since += if self.length > 0 { bytes } else { bytes.max(LEAST) } as u64;
        self.delivered += bytes as u64;
    }
}

impl BufRead for Input {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.pass_silence()?;
        let available = self.source().fill_buf()?.len();
        self.arrived(available)?;
        // What was read is still there; the end is not read twice.
        if available == 0 { Ok(&[]) } else { self.source().fill_buf() }
    }

    fn consume(&mut self, bytes: usize) {
        self.count(bytes);
        self.source().consume(bytes);
    }
}

impl Read for Input {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        if bytes.len() >= BLOCK {
            // Buffers pass large reads on, without a copy of their own.
            self.pass_silence()?;
            let most = bytes.len().min(LARGE);
            let read = self.source().read(&mut bytes[..most])?;
            self.arrived(read)?;
            self.count(read);
            return Ok(read);
        }
        let available = self.fill_buf()?;
        let read = available.len().min(bytes.len());
        bytes[..read].copy_from_slice(&available[..read]);
        self.consume(read);
        Ok(read)
    }
}

/// An input that may be silent for any time: standard input, a named pipe, a device. A separate thread opens and reads
/// it, so that waiting for it can end; the thread ends with the stream or with the process.
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
            mend: "use a regular file, or allow the process more threads".into(),
        })?;
        Ok(Self { blocks, block: Cursor::default(), watch: watch.clone() })
    }
}

/// Sends the content of a file or of standard input; stops when the receiver is gone.
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
    use crate::gauge::SILENCE;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use halfline_ground::progress::Cancel;
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
        // Blanks compress to a thousandth, and empty members to nothing.
        let bomb = gz(&vec![b' '; 1 << 24]);
        // An xz stream without blocks, an empty frame of Zstandard, and one to be skipped.
        let xz = b"\xfd7zXZ\0\0\x04\xe6\xd6\xb4\x46\0\0\0\0\x1c\xdf\x44\x21\x1f\xb6\xf3\x7d\x01\0\0\0\0\x04YZ";
        let frame = [0x28, 0xb5, 0x2f, 0xfd, 0x20, 0, 1, 0, 0];
        let skipped = [0x50, 0x2a, 0x4d, 0x18, 1, 0, 0, 0, 7];
        for members in [bomb, gz(b""), xz.to_vec(), frame.to_vec(), skipped.to_vec()] {
            let mut at = 0;
            let endless = std::iter::repeat_with(move || {
                at = (at + 1) % members.len();
                members[(at + members.len() - 1) % members.len()]
            });
            // The first bytes of the content are looked at when it is opened.
            let error = match Input::of(Box::new(Bytes(endless)), &watch) {
                Ok(input) => error_of(input),
                Err(error) => Error::read("text", error),
            };
            assert!(matches!(error, Error::Limits { .. }), "{error}");
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
            input.read_exact(&mut block).expect("the stream is endless");
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
