//! GROMACS TRR: frames of positions, velocities and forces as real numbers in XDR
//! (manual.gromacs.org/current/reference-manual/file-formats.html#trr). Nanometres are converted to ångström; velocities
//! stay in nm/ps, as in GRO. Frames without positions are skipped and not counted.

use super::moment::{Moment, Moments};
use super::xdr::{DOUBLE, NANOMETRE, SINGLE, atoms, cell, int, real, vectors};
use crate::npy::header::Scalar;
use crate::particles::bytes::{BinaryFile, DAMAGED};
use crate::particles::frame_time::FrameTime;
use halfline_ground::error::Result;

/// The reader.
pub(super) struct Trr {
    file: BinaryFile,
    /// Whether velocities are read.
    moving: bool,
}

/// The number that a frame begins with.
const MAGIC: i32 = 1993;

/// The name of the format, which follows it.
const VERSION: &[u8; 12] = b"GMX_trn_file";

/// The parts of a frame, in the order of their sizes in its header.
const PARTS: [&str; 10] = [
    "input record",
    "energies",
    "box",
    "virial",
    "pressure",
    "topology",
    "symbols",
    "positions",
    "velocities",
    "forces",
];
const BOX: usize = 2;
const POSITIONS: usize = 7;
const VELOCITIES: usize = 8;

/// The header of a frame.
struct TrrHeader {
    /// The bytes of the parts.
    sizes: [u64; 10],
    atoms: u64,
    real: Scalar,
    when: FrameTime,
}

impl TrrHeader {
    fn has(&self, part: usize) -> bool {
        self.sizes[part] > 0
    }

    /// The bytes of the parts in this range.
    fn bytes(&self, parts: std::ops::Range<usize>) -> u64 {
        self.sizes[parts].iter().sum()
    }
}

impl Trr {
    pub(super) fn new(file: BinaryFile, moving: bool) -> Self {
        Self { file, moving }
    }

    /// The header of the next frame; `None` at the end of the file.
    fn header(&mut self) -> Result<Option<TrrHeader>> {
        let file = &mut self.file;
        if file.is_end()? {
            return Ok(None);
        }
        let at = file.at();
        let magic = int(file, "magic number")?;
        // The length of the name with and without the zero behind it.
        let lengths = [int(file, "version")?, int(file, "version")?];
        let version: [u8; 12] = file.bytes("version")?;
        if magic != MAGIC || lengths != [13, 12] || version != *VERSION {
            let problem = format!("a frame does not begin with {MAGIC} and GMX_trn_file");
            return Err(file.fail(at, "magic number", problem, DAMAGED));
        }
        let mut sizes = [0; 10];
        for (size, part) in sizes.iter_mut().zip(PARTS) {
            let (at, bytes) = (file.at(), int(file, part)?);
            let wrong = || file.fail(at, part, format!("the size is {bytes} bytes"), DAMAGED);
            *size = u64::try_from(bytes).map_err(|_| wrong())?;
        }
        let (at, atoms) = (file.at(), atoms(file)?);
        let precision = Self::real(&sizes, atoms);
        let sizes_fit = precision.is_some_and(|real| {
            let fits = |part: usize, numbers: u64| [0, numbers * real.size() as u64].contains(&sizes[part]);
            (BOX..=4).all(|part| fits(part, 9)) && (POSITIONS..10).all(|part| fits(part, 3 * atoms))
        });
        let Some(precision) = precision.filter(|_| sizes_fit) else {
            let problem = format!("the sizes of the parts of a frame do not fit {atoms} atoms");
            return Err(file.fail(at, "number of atoms", problem, DAMAGED));
        };
        let step = int(file, "step")?;
        file.pass(4, "number of energies")?;
        let time = real(file, precision, "time")?;
        file.pass(precision.size() as u64, "lambda")?;
        let when = FrameTime::of(Some(time), Some(step.into()));
        Ok(Some(TrrHeader { sizes, atoms, real: precision, when }))
    }

    /// The precision, from the size of a part; single where all are empty.
    fn real(sizes: &[u64; 10], atoms: u64) -> Option<Scalar> {
        let parts = [(BOX, 9), (3, 9), (4, 9), (POSITIONS, 3 * atoms), (VELOCITIES, 3 * atoms), (9, 3 * atoms)];
        match parts.into_iter().find(|(part, _)| sizes[*part] > 0) {
            None => Some(SINGLE),
            Some((part, numbers)) => {
                [SINGLE, DOUBLE].into_iter().find(|real| sizes[part] == numbers * real.size() as u64)
            }
        }
    }

    /// The header of the next frame with positions.
    fn positioned(&mut self) -> Result<Option<TrrHeader>> {
        while let Some(header) = self.header()? {
            if header.has(POSITIONS) {
                return Ok(Some(header));
            }
            self.file.pass(header.bytes(0..10), "frame without positions")?;
            self.file.found();
        }
        Ok(None)
    }
}

impl Moments for Trr {
    fn next(&mut self) -> Result<Option<Moment>> {
        let Some(header) = self.positioned()? else { return Ok(None) };
        let (file, real) = (&mut self.file, header.real);
        file.pass(header.bytes(0..BOX), "input record")?;
        let cell = if header.has(BOX) { cell(file, real)? } else { None };
        file.pass(header.bytes(BOX + 1..POSITIONS), "virial")?;
        let positions = vectors(file, header.atoms, real, NANOMETRE, "positions")?;
        let moving = self.moving && header.has(VELOCITIES);
        let velocities = if moving { vectors(file, header.atoms, real, 1.0, "velocities")? } else { Vec::new() };
        let passed = if moving { VELOCITIES + 1 } else { VELOCITIES };
        file.pass(header.bytes(passed..10), "velocities and forces")?;
        file.found();
        Ok(Some(Moment { positions, has_velocities: header.has(VELOCITIES), velocities, cell, when: header.when }))
    }

    fn skip(&mut self) -> Result<bool> {
        let Some(header) = self.positioned()? else { return Ok(false) };
        self.file.pass(header.bytes(0..10), "frame")?;
        self.file.found();
        Ok(true)
    }
}
