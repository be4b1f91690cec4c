//! GROMACS XTC: frames of compressed positions in XDR
//! (manual.gromacs.org/current/reference-manual/file-formats.html#xtc). Positions are whole numbers divided by the
//! precision, nanometres, and are converted to ångström in f64. The crate molly 0.7 reads it too, but panics on damaged
//! frames and allocates the sizes in their headers.

use super::ints::{self, Packed};
use super::moment::{Moment, Moments};
use super::xdr::{NANOMETRE, SINGLE, atoms, cell, int, real, vectors};
use crate::particles::bytes::{BinaryFile, DAMAGED};
use crate::particles::frame_time::FrameTime;
use halfline_ground::Cell;
use halfline_ground::error::Result;

/// The reader.
pub(super) struct Xtc {
    file: BinaryFile,
    /// The compressed bytes of a frame.
    packed: Vec<u8>,
}

/// The header of a frame.
struct XtcHeader {
    /// Whether the number of compressed bytes has 64 bits.
    long: bool,
    atoms: u64,
    cell: Option<Cell>,
    when: FrameTime,
}

/// The numbers that a frame begins with; the second is for frames whose compressed bytes may need a 64-bit number.
const MAGIC: i32 = 1995;
const MAGIC_64: i32 = 2023;

/// Frames of at most so many atoms are not compressed.
const PLAIN: u64 = 9;

impl Xtc {
    pub(super) fn new(file: BinaryFile) -> Self {
        Self { file, packed: Vec::new() }
    }

    /// The header of the next frame; `None` at the end of the file.
    fn header(&mut self) -> Result<Option<XtcHeader>> {
        if self.file.is_end()? {
            return Ok(None);
        }
        let at = self.file.at();
        let magic = int(&mut self.file, "magic number")?;
        if ![MAGIC, MAGIC_64].contains(&magic) {
            let problem = format!("a frame begins with {magic}, not with {MAGIC} or {MAGIC_64}");
            return Err(self.file.fail(at, "magic number", problem, DAMAGED));
        }
        let atoms = atoms(&mut self.file)?;
        let step = int(&mut self.file, "step")?;
        let time = real(&mut self.file, SINGLE, "time")?;
        let when = FrameTime::of(Some(time), Some(step.into()));
        let cell = cell(&mut self.file, SINGLE)?;
        let at = self.file.at();
        let again = int(&mut self.file, "number of positions")?;
        if i64::from(again) != atoms as i64 {
            let problem = format!("{again} positions of {atoms} atoms");
            return Err(self.file.fail(at, "number of positions", problem, DAMAGED));
        }
        Ok(Some(XtcHeader { long: magic == MAGIC_64, atoms, cell, when }))
    }

    /// The number of compressed bytes, which is at the current byte.
    fn length(&mut self, header: &XtcHeader) -> Result<u64> {
        let (field, at) = ("compressed bytes", self.file.at());
        let length = if header.long {
            i64::from_be_bytes(self.file.bytes(field)?)
        } else {
            i64::from(int(&mut self.file, field)?)
        };
        u64::try_from(length).map_err(|_| self.file.fail(at, field, format!("{length} bytes"), DAMAGED))
    }

    fn compressed(&mut self, header: &XtcHeader) -> Result<Vec<[f64; 3]>> {
        let file = &mut self.file;
        let at = file.at();
        let precision = real(file, SINGLE, "precision")?;
        if !(precision > 0.0 && precision.is_finite()) {
            return Err(file.fail(at, "precision", format!("the precision is {precision}"), DAMAGED));
        }
        let mut extent = [0; 6];
        for x in &mut extent {
            *x = i64::from(int(file, "extent")?);
        }
        let small = int(file, "small index")?;
        let length = self.length(header)?;
        let at = self.file.at();
        self.file.block(length, &mut self.packed, "positions")?;
        let [x0, y0, z0, x1, y1, z1] = extent;
        let packed = Packed { bytes: &self.packed, least: [x0, y0, z0], most: [x1, y1, z1], small };
        let place = |whole: [i64; 3]| whole.map(|x| x as f64 * NANOMETRE / precision);
        let positions = ints::unpack(&packed, header.atoms, place).map_err(|error| match error {
            ints::Fault::Damaged(problem) => self.file.fail(at, "positions", problem, DAMAGED),
            ints::Fault::Other(error) => error,
        })?;
        self.file.pass(padding(length), "padding")?;
        Ok(positions)
    }
}

/// The bytes that fill the last word.
fn padding(length: u64) -> u64 {
    length.wrapping_neg() % 4
}

impl Moments for Xtc {
    fn next(&mut self) -> Result<Option<Moment>> {
        let Some(header) = self.header()? else { return Ok(None) };
        let positions = if header.atoms <= PLAIN {
            vectors(&mut self.file, header.atoms, SINGLE, NANOMETRE, "positions")?
        } else {
            self.compressed(&header)?
        };
        self.file.found();
        Ok(Some(Moment { positions, cell: header.cell, when: header.when, ..Moment::default() }))
    }

    fn skip(&mut self) -> Result<bool> {
        let Some(header) = self.header()? else { return Ok(false) };
        if header.atoms <= PLAIN {
            self.file.pass(12 * header.atoms, "positions")?;
        } else {
            self.file.pass(32, "precision and extent")?;
            let length = self.length(&header)?;
            self.file.pass(length.saturating_add(padding(length)), "positions")?;
        }
        self.file.found();
        Ok(true)
    }
}
