//! Trajectories and restart files of AMBER (ambermd.org/netcdf/nctraj.xhtml) in the classic formats of NetCDF, CDF-1, CDF-2 and
//! CDF-5 (docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html): variables `coordinates`, `velocities`, `time`,
//! `cell_lengths` and `cell_angles`, a record for each frame. The crate netcdf-reader 0.9 maps the file or keeps the whole of it, and
//! a trajectory may be longer than the memory.

mod header;

use super::moment::{Moment, Moments};
use crate::particles::bytes::{BinaryFile, DAMAGED};
use crate::particles::frame_time::FrameTime;
use crate::particles::molecule;
use halfline_ground::Cell;
use halfline_ground::error::Result;
use halfline_ground::memory::{check, check_ids};
use halfline_ground::quote::list;
use header::{Frames, Header, Variable, header};

/// The reader.
pub(super) struct NetCdf {
    file: BinaryFile,
    /// Whether velocities are requested.
    with_velocities: bool,
    layout: Option<FrameLayout>,
    /// The next frame.
    frame: u64,
    /// The bytes of a variable.
    block: Vec<u8>,
}

/// The variables of a frame, in the order of the file.
struct FrameLayout {
    atoms: u64,
    parts: Vec<(Part, Variable)>,
    frames: Frames,
    /// The first byte of the first frame, and the bytes of each.
    start: u64,
    size: u64,
    has_velocities: bool,
}

/// The variables that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Positions,
    Velocities,
    Time,
    Lengths,
    Angles,
}

const PARTS: [(Part, &str); 5] = [
    (Part::Positions, "coordinates"),
    (Part::Velocities, "velocities"),
    (Part::Time, "time"),
    (Part::Lengths, "cell_lengths"),
    (Part::Angles, "cell_angles"),
];

const NO_COORDINATES: &str = "convert it to XYZ or NPY, or use a trajectory of AMBER";

impl NetCdf {
    pub(super) fn new(file: BinaryFile, with_velocities: bool) -> Self {
        Self { file, with_velocities, layout: None, frame: 0, block: Vec::new() }
    }

    /// Reads the header, if it was not read yet; whether there is a frame more.
    fn advance(&mut self) -> Result<bool> {
        if self.layout.is_none() {
            let header = header(&mut self.file)?;
            self.layout = Some(self.layout_of(header)?);
        }
        Ok(match self.layout.as_ref().map(|layout| layout.frames) {
            Some(Frames::Known(count)) => self.frame < count,
            // The writer did not say how many there are.
            Some(Frames::ToTheEnd) => !self.file.is_end()?,
            None => false,
        })
    }

    fn layout_of(&self, header: Header) -> Result<FrameLayout> {
        let wrong = |field: &str, problem: String, mend: &str| self.file.fail(0, field, problem, mend);
        let Some(positions) = header.variables.iter().find(|variable| variable.name == "coordinates") else {
            let names = list(header.variables.iter().map(|variable| &variable.name));
            let problem = format!("there is no variable coordinates among {names}");
            return Err(wrong("variables", problem, NO_COORDINATES));
        };
        let of_records = positions.is_record;
        let atoms = match positions.sides[usize::from(of_records)..] {
            [atoms, 3] if positions.scalar.is_float() => atoms,
            _ => {
                let problem = format!("the numbers of a frame are {:?}, not floats of (atom, 3)", positions.sides);
                return Err(wrong("coordinates", problem, NO_COORDINATES));
            }
        };
        check_ids(atoms)?;
        if atoms == 0 {
            return Err(wrong("coordinates", "a frame has no atoms".into(), NO_COORDINATES));
        }
        let mut parts = Vec::new();
        for (part, name) in PARTS {
            let is_read = part != Part::Velocities || self.with_velocities;
            let found = header.variables.iter().find(|variable| variable.name == name);
            let Some(variable) = found.filter(|found| is_read && found.is_record == of_records) else { continue };
            let count = match part {
                Part::Positions | Part::Velocities => 3 * atoms,
                Part::Time => 1,
                Part::Lengths | Part::Angles => 3,
            };
            if variable.count != count || !variable.scalar.is_float() {
                let problem = format!("a frame has {} numbers, expected {count} floats", variable.count);
                return Err(wrong(name, problem, DAMAGED));
            }
            parts.push((part, variable.clone()));
        }
        parts.sort_by_key(|(_, variable)| variable.begin);
        let first = header.variables.iter().filter(|variable| variable.is_record == of_records);
        let start = first.map(|variable| variable.begin).min().unwrap_or_default();
        // Restart files have one frame, whose variables are those without records.
        let size = if of_records { header.record_size } else { u64::MAX - start };
        let (mut at, end) = (self.file.at().max(start), start.saturating_add(size));
        for (_, variable) in &parts {
            if variable.begin < at || variable.begin.saturating_add(variable.bytes()) > end {
                let problem =
                    format!("its {} bytes from byte {} on are not in a frame", variable.bytes(), variable.begin);
                return Err(wrong(&variable.name, problem, DAMAGED));
            }
            at = variable.begin + variable.bytes();
        }
        let has_velocities = header.variables.iter().any(|variable| variable.name == "velocities");
        let frames = if of_records { header.frames } else { Frames::Known(1) };
        Ok(FrameLayout { atoms, parts, frames, start, size, has_velocities })
    }

    /// Moves to the next frame. The last one may lack the bytes that fill it.
    fn pass_frame(&mut self) -> Result<()> {
        self.frame += 1;
        let ends =
            self.layout.as_ref().map(|layout| layout.start.saturating_add(self.frame.saturating_mul(layout.size)));
        self.file.skip(ends.unwrap_or_default().saturating_sub(self.file.at()))?;
        self.file.found();
        Ok(())
    }
}

/// Moves to this byte of a file.
fn pass_to(file: &mut BinaryFile, byte: u64, field: &str) -> Result<()> {
    let left = byte.saturating_sub(file.at());
    file.pass(left, field)
}

/// The numbers of a variable.
fn numbers(variable: &Variable, block: &[u8]) -> impl Iterator<Item = f64> {
    let (scalar, factor) = (variable.scalar, variable.factor);
    block.chunks_exact(scalar.size()).map(move |bytes| scalar.number(bytes) * factor)
}

fn vectors(variable: &Variable, block: &[u8], atoms: u64) -> Result<Vec<[f64; 3]>> {
    check(24 * atoms, || format!("the {}", variable.name))?;
    let mut numbers = numbers(variable, block);
    let mut three = || Some([numbers.next()?, numbers.next()?, numbers.next()?]);
    Ok(std::iter::from_fn(&mut three).collect())
}

impl Moments for NetCdf {
    fn next(&mut self) -> Result<Option<Moment>> {
        if !self.advance()? {
            return Ok(None);
        }
        let Self { file, layout: Some(layout), block, .. } = self else { return Ok(None) };
        let offset = self.frame.saturating_mul(layout.size);
        let (mut moment, mut time) = (Moment { has_velocities: layout.has_velocities, ..Moment::default() }, None);
        let mut sides = [None; 2];
        for (part, variable) in &layout.parts {
            pass_to(file, variable.begin.saturating_add(offset), &variable.name)?;
            let at = file.at();
            file.block(variable.bytes(), block, &variable.name)?;
            let mut first = [0.0; 3];
            first.iter_mut().zip(numbers(variable, block)).for_each(|(to, x)| *to = x);
            match part {
                Part::Positions => moment.positions = vectors(variable, block, layout.atoms)?,
                Part::Velocities => moment.velocities = vectors(variable, block, layout.atoms)?,
                Part::Time => time = Some(first[0]),
                Part::Lengths | Part::Angles if !first.iter().all(|x| x.is_finite()) => {
                    return Err(file.fail(at, &variable.name, "a number of the cell is not finite", DAMAGED));
                }
                Part::Lengths => sides[0] = Some(first),
                Part::Angles => sides[1] = Some(first),
            }
        }
        moment.cell = cell(sides);
        moment.when = FrameTime::of(time, None);
        self.pass_frame()?;
        Ok(Some(moment))
    }

    fn skip(&mut self) -> Result<bool> {
        if !self.advance()? {
            return Ok(false);
        }
        if let Some(FrameLayout { size, parts, .. }) = &self.layout {
            let ends = parts.last().map_or(0, |(_, last)| last.begin.saturating_add(last.bytes()));
            pass_to(&mut self.file, ends.saturating_add(self.frame.saturating_mul(*size)), "skipped frame")?;
        }
        self.pass_frame()?;
        Ok(true)
    }
}

/// The cell of these lengths and angles in degrees; rectangular without angles, none where the lengths are 0.
fn cell([lengths, angles]: [Option<[f64; 3]>; 2]) -> Option<Cell> {
    lengths
        .filter(|lengths| *lengths != [0.0; 3])
        .and_then(|lengths| molecule::cell(lengths, angles.unwrap_or([90.0; 3])))
}

#[cfg(test)]
mod tests;
