//! The layers of a GSD file: a header, an index of chunks, a list of their names, and the chunks, anywhere in the file
//! (gsd.readthedocs.io/en/stable/file-layer.html). All numbers are little-endian.

use crate::npy::header::Scalar;
use crate::particles::bytes::{BinaryFile, DAMAGED};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check;
use halfline_ground::quote::quote;
use std::collections::HashMap;

/// A file in memory.
pub(super) struct GsdFile {
    bytes: Vec<u8>,
    place: Place,
    /// The numbers of the names of chunks.
    names: HashMap<Vec<u8>, u16>,
    /// The chunks, ordered by frame and name.
    chunks: Vec<Chunk>,
}

/// An array of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Chunk {
    frame: u64,
    name: u16,
    kind: u8,
    pub(super) rows: u64,
    pub(super) columns: u32,
    start: u64,
}

/// The first number of a file.
const MAGIC: u64 = 0x65df_65df_65df_65df;

const HEADER: u64 = 256;

/// Bytes of an entry of the index, and of the list of names.
const ENTRY: u64 = 32;
const NAME: u64 = 64;

fn number(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..).and_then(|bytes| bytes.first_chunk()).map_or(0, |bytes| u64::from_le_bytes(*bytes))
}

impl GsdFile {
    /// Reads the whole file, because its index may be anywhere in it.
    ///
    /// # Errors
    /// [`Error::Scene`] with the byte, [`Error::Limits`], [`Error::Io`].
    pub(super) fn read(mut file: BinaryFile) -> Result<Self> {
        let mut bytes = Vec::new();
        file.all(&mut bytes)?;
        let mut gsd = Self { bytes, place: file.file(), names: HashMap::new(), chunks: Vec::new() };
        if (gsd.bytes.len() as u64) < HEADER || number(&gsd.bytes, 0) != MAGIC {
            return Err(gsd.fail(0, "header", "the file does not begin with the header of GSD"));
        }
        let field = |at: usize| number(&gsd.bytes, at);
        let (index, entries, names, slots) = (field(8), field(16), field(24), field(32));
        let schema = &gsd.bytes[112..176];
        if !schema.starts_with(b"hoomd\0") {
            let name = schema.split(|byte| *byte == 0).next().unwrap_or_default();
            let problem = format!("the schema is {}", quote(name));
            let place = gsd.place.clone().named("byte 112: schema");
            return Err(Error::scene(place, problem, "use a file of the schema hoomd"));
        }
        let version = number(&gsd.bytes, 40) >> 32;
        let list = gsd.part(names, slots.saturating_mul(NAME), 24, "names")?.to_vec();
        gsd.names = if version >> 16 == 1 {
            // Names of a fixed length.
            list.chunks(NAME as usize).map(until_zero).zip(0..).filter(|(name, _)| !name.is_empty()).collect()
        } else {
            list.split(|byte| *byte == 0)
                .map(<[u8]>::to_vec)
                .zip(0..)
                .take_while(|(name, _)| !name.is_empty())
                .collect()
        };
        gsd.chunks = gsd.index(index, entries)?;
        Ok(gsd)
    }

    /// The valid entries of the index, whose chunks are in the file.
    fn index(&self, start: u64, entries: u64) -> Result<Vec<Chunk>> {
        let index = self.part(start, entries.saturating_mul(ENTRY), 8, "index")?;
        check(index.len() as u64, || "the index of the file".into())?;
        let mut chunks = Vec::new();
        for (entry, at) in index.as_chunks::<32>().0.iter().zip((start..).step_by(ENTRY as usize)) {
            let [frame, rows, place, rest] = [0, 8, 16, 24].map(|at| number(entry, at));
            // Entries that are not used yet have no place.
            if place == 0 {
                break;
            }
            let (columns, name, kind) = (rest as u32, (rest >> 32) as u16, (rest >> 48) as u8);
            let chunk = Chunk { frame, name, kind, rows, columns, start: place };
            // Kinds of later versions are not read.
            if let Some(scalar) = scalar(kind) {
                let row = u64::from(columns) * scalar.size() as u64;
                self.part(place, rows.saturating_mul(row), at, "chunk")?;
                chunks.push(chunk);
            }
        }
        // The last of several chunks of one name counts.
        chunks.sort_by_key(|chunk| (chunk.frame, chunk.name));
        Ok(chunks)
    }

    /// A part of the file, whose place is given at byte `offset`.
    fn part(&self, start: u64, length: u64, offset: u64, field: &str) -> Result<&[u8]> {
        let end = start.checked_add(length).filter(|end| *end <= self.bytes.len() as u64);
        end.and_then(|end| self.bytes.get(start as usize..end as usize)).ok_or_else(|| {
            let size = self.bytes.len();
            self.fail(offset, field, &format!("{length} bytes at byte {start} are not in the file of {size} bytes"))
        })
    }

    /// An error of the field at a byte.
    fn fail(&self, byte: u64, field: &str, problem: &str) -> Error {
        Error::scene(self.place.clone().named(format!("byte {byte}: {field}")), problem, DAMAGED)
    }

    /// An error of a chunk of a frame.
    pub(super) fn wrong(&self, frame: u64, name: &str, problem: impl Into<String>) -> Error {
        Error::scene(self.place.clone().named(format!("frame {}: {name}", frame + 1)), problem, DAMAGED)
    }

    /// The number of frames: each has a chunk at least, so there are no more than chunks.
    pub(super) fn frames(&self) -> Result<u64> {
        let Some(last) = self.chunks.last() else { return Ok(0) };
        if last.frame >= self.chunks.len() as u64 {
            let problem = format!("a chunk is of frame {}, but there are {} chunks", last.frame, self.chunks.len());
            return Err(self.fail(8, "index", &problem));
        }
        Ok(last.frame + 1)
    }

    /// A chunk of a frame by its name.
    pub(super) fn chunk(&self, frame: u64, name: &str) -> Option<Chunk> {
        let name = *self.names.get(name.as_bytes())?;
        let after = self.chunks.partition_point(|chunk| (chunk.frame, chunk.name) <= (frame, name));
        self.chunks[..after].last().copied().filter(|chunk| (chunk.frame, chunk.name) == (frame, name))
    }

    /// Whether the file has chunks of a name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.names.contains_key(name.as_bytes())
    }

    /// The numbers of a chunk.
    pub(super) fn numbers(&self, chunk: Chunk) -> impl Iterator<Item = f64> + '_ {
        let scalar = scalar(chunk.kind);
        let size = scalar.map_or(1, Scalar::size);
        let bytes = self.bytes(chunk);
        bytes.chunks_exact(size).map(move |bytes| scalar.map_or(f64::NAN, |scalar| scalar.number(bytes)))
    }

    /// The bytes of a chunk.
    pub(super) fn bytes(&self, chunk: Chunk) -> &[u8] {
        let row = u64::from(chunk.columns) * scalar(chunk.kind).map_or(0, Scalar::size) as u64;
        let end = chunk.start.saturating_add(chunk.rows.saturating_mul(row));
        self.bytes.get(chunk.start as usize..end as usize).unwrap_or_default()
    }
}

/// Bytes up to the first zero.
pub(super) fn until_zero(bytes: &[u8]) -> Vec<u8> {
    bytes.iter().copied().take_while(|byte| *byte != 0).collect()
}

/// The number type of a chunk.
fn scalar(kind: u8) -> Option<Scalar> {
    const KINDS: [&str; 10] = ["|u1", "<u2", "<u4", "<u8", "|i1", "<i2", "<i4", "<i8", "<f4", "<f8"];
    KINDS.get(usize::from(kind).checked_sub(1)?).and_then(|name| Scalar::of_numpy(name))
}
