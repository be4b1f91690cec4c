//! LAZ: points of LAS in compressed chunks (LAZ Specification 1.4, rapidlasso.de). Formats 0 to 3 and 6 to 10 are read, chunk
//! after chunk; the table of chunks behind the points is not needed.
//!
//! The crate laz 0.13 is not used. For a damaged file it allocates the number of chunks that the table names, its sums
//! overflow, which is a panic in debug builds, and a changed sequence of times calls itself until the stack ends, which
//! no check before the call can prevent.

mod arithmetic;
mod color;
mod integer;
mod layer;
mod layered;
mod sequential;
mod time;

use super::format::{PointFormat, u16_at, u32_at};
use crate::particles::bytes::{BinaryFile, DAMAGED};
use arithmetic::{Decoder, INVALID, Source};
use halfline_ground::error::{Error, Result};
use layer::Layer;
use layered::{LAYERS, Layered};
use sequential::Sequential;

/// The compression of the points, from the record `laszip encoded` behind the header.
pub(super) struct LazScheme {
    coding: Coding,
    /// Points per chunk; `None` where every chunk gives its own number.
    chunk: Option<u64>,
    /// Whether chunks are independent, and a number before the first is the place of their table.
    has_table: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Coding {
    Sequential,
    /// By layers, in version 3 or 4.
    Layered(u16),
}

/// The user and the number of that record.
pub(super) const USER: &[u8] = b"laszip encoded\0";
pub(super) const RECORD: u16 = 22204;

const OTHER: &str = "decompress the file, for example with `laszip -i in.laz -o out.las` or `pdal translate`";

/// The points of a file.
pub(super) struct Laz {
    points: Decoder<BinaryFile>,
    scheme: LazScheme,
    format: PointFormat,
    record: usize,
    /// Whether the bytes behind the fields of the format are needed.
    extra: bool,
    /// Points until the next chunk.
    left: u64,
    state: Option<State>,
    first: Vec<u8>,
}

enum State {
    Sequential(Box<Sequential>),
    Layered(Box<Layered>),
}

impl LazScheme {
    /// The scheme of a record; in an error the byte, the problem and the mend.
    pub(super) fn of(record: &[u8], format: PointFormat, size: usize) -> Result<Self, (u64, String, &'static str)> {
        if record.len() < 34 || record.len() < 34 + 6 * usize::from(u16_at(record, 32)) {
            return Err((0, format!("it has only {} bytes", record.len()), DAMAGED));
        }
        let other = |byte, what: String| Err((byte, what, OTHER));
        let (compressor, coder, chunk) = (u16_at(record, 0), u16_at(record, 2), u32_at(record, 12));
        if coder != 0 {
            return other(2, format!("coder {coder}"));
        }
        // The items of a point: number, bytes, version.
        let items: Vec<[u16; 3]> = record[34..]
            .chunks_exact(6)
            .take(u16_at(record, 32).into())
            .map(|item| [0, 2, 4].map(|at| u16_at(item, at)))
            .collect();
        let version = items.first().map_or(0, |item| item[2]);
        let coding = match (compressor, version, format.long) {
            (1 | 2, 2, false) => Coding::Sequential,
            (3, 3 | 4, true) => Coding::Layered(version),
            _ => return other(0, format!("compressor {compressor} in version {version} of this point format")),
        };
        let mut expected = vec![if format.long { [10, 30] } else { [6, 20] }];
        if format.long {
            expected.extend(format.infrared.map(|_| [12, 8]).or(format.color.map(|_| [11, 6])));
        } else {
            expected.extend(format.gps_time.map(|_| [7, 8]));
            expected.extend(format.color.map(|_| [8, 6]));
        }
        let known: usize = expected.iter().map(|item| usize::from(item[1])).sum();
        if known != format.size {
            // A packet of a waveform.
            expected.push([if format.long { 13 } else { 9 }, 29]);
        }
        if let Ok(extra @ 1..) = u16::try_from(size - format.size) {
            expected.push([if format.long { 14 } else { 0 }, extra]);
        }
        if !items.iter().map(|[kind, bytes, _]| [*kind, *bytes]).eq(expected) {
            return Err((34, "the items do not match the point format".into(), DAMAGED));
        }
        if items.iter().any(|item| item[2] != version) || known != format.size && !format.long {
            return other(34, "items of several versions, or waveforms".into());
        }
        let variable = chunk == 0 || chunk == u32::MAX;
        if variable && compressor == 2 {
            return other(12, "chunks of several sizes of these point formats".into());
        }
        let chunk = if compressor == 1 { Some(u64::MAX) } else { (!variable).then_some(chunk.into()) };
        Ok(Self { coding, chunk, has_table: compressor != 1 })
    }
}

impl Laz {
    /// The points from the next byte of a file on, in records of so many bytes; those behind the fields of the format are read
    /// if they are `extra` fields.
    ///
    /// # Errors
    /// Errors of reading the file.
    pub(super) fn new(
        mut file: BinaryFile,
        scheme: LazScheme,
        format: PointFormat,
        record: usize,
        extra: bool,
    ) -> Result<Self> {
        if scheme.has_table {
            file.pass(8, "place of the table of chunks")?;
        }
        let points = Decoder::new(file);
        Ok(Self { points, scheme, format, record, extra, left: 0, state: None, first: Vec::new() })
    }

    /// The record of the next point.
    ///
    /// # Errors
    /// [`Error::Scene`] where the file ends within the points or a code is not valid, and errors of reading the file.
    pub(super) fn next(&mut self) -> Result<&[u8]> {
        if self.left == 0 {
            self.begin()?;
            self.left -= 1;
            return Ok(&self.first);
        }
        self.left -= 1;
        match &mut self.state {
            Some(State::Sequential(points)) => points.next(&mut self.points),
            Some(State::Layered(points)) => points.next(),
            None => Ok(&self.first),
        }
    }

    /// Reports that particles were found.
    pub(super) fn found(&mut self) {
        self.points.source().found();
    }

    /// Begins a chunk.
    fn begin(&mut self) -> Result<()> {
        // The last chunk's memory is free before the next one's is taken.
        self.state = None;
        let file = self.points.source();
        file.found();
        file.block(self.record as u64, &mut self.first, "points")?;
        match self.scheme.coding {
            Coding::Sequential => {
                self.left = self.scheme.chunk.unwrap_or(u64::MAX);
                self.points.begin()?;
                self.state = Some(State::Sequential(Box::new(Sequential::new(self.format, &self.first))));
            }
            Coding::Layered(version) => {
                let at = file.at();
                let count = u64::from(u32::from_le_bytes(file.bytes("points of a chunk")?));
                self.left = self.scheme.chunk.unwrap_or(count);
                if self.left == 0 {
                    return Err(file.fail(at, "points of a chunk", "there are none", DAMAGED));
                }
                let layers = self.layers()?;
                let points = Layered::new(self.format, &self.first, layers, version == 3);
                self.state = Some(State::Layered(Box::new(points)));
            }
        }
        Ok(())
    }

    /// Reads the layers of a chunk; those that are not needed are skipped.
    fn layers(&mut self) -> Result<Vec<Option<Decoder<Layer>>>> {
        let file = self.points.source();
        let known = LAYERS + usize::from(self.format.color.is_some()) + usize::from(self.format.infrared.is_some());
        let waves = usize::from(self.format.size >= 59);
        let count = known + waves + self.record - self.format.size;
        let mut sizes = Vec::new();
        file.block(4 * count as u64, &mut sizes, "sizes of layers")?;
        let mut layers = Vec::new();
        for (index, size) in sizes.chunks_exact(4).map(|size| u64::from(u32_at(size, 0))).enumerate() {
            // The first layer has what every point has; without bytes it ends within the second.
            let is_needed = index < known || self.extra && index >= known + waves;
            if !is_needed || (size == 0 && index > 0) {
                file.pass(size, "layer")?;
                if is_needed {
                    layers.push(None);
                }
                continue;
            }
            let place = file.file().named(format!("byte {}: layer", file.at()));
            let mut bytes = Vec::new();
            file.block(size, &mut bytes, "layer")?;
            let mut layer = Decoder::new(Layer::new(bytes, place));
            if size > 0 {
                layer.begin()?;
            }
            layers.push(Some(layer));
        }
        Ok(layers)
    }
}

impl Source for BinaryFile {
    fn byte(&mut self) -> Result<u8> {
        self.bytes("points").map(|[byte]| byte)
    }

    fn invalid(&self) -> Error {
        self.fail(self.at(), "points", INVALID, DAMAGED)
    }
}

#[cfg(test)]
mod tests;
