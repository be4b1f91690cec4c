//! The header of a NetCDF file: dimensions, attributes, variables.

use crate::npy::header::{NumberKind, Scalar};
use crate::particles::bytes::{BinaryFile, DAMAGED};
use halfline_ground::error::Result;

/// The variables of a file.
pub(super) struct Header {
    pub(super) frames: Frames,
    pub(super) variables: Vec<Variable>,
    /// The bytes of a record: the numbers of all variables that have one for each frame.
    pub(super) record_size: u64,
}

/// The number of records.
#[derive(Debug, Clone, Copy)]
pub(super) enum Frames {
    Known(u64),
    ToTheEnd,
}

/// A variable.
#[derive(Debug, Clone)]
pub(super) struct Variable {
    pub(super) name: String,
    /// The lengths of its dimensions, 0 for the dimension of the records.
    pub(super) sides: Vec<u64>,
    /// Whether it has numbers for each record.
    pub(super) is_record: bool,
    /// Its numbers, of one record.
    pub(super) count: u64,
    pub(super) scalar: Scalar,
    /// The attribute `scale_factor`.
    pub(super) factor: f64,
    /// Its first byte in the file.
    pub(super) begin: u64,
}

/// The most dimensions, attributes of one thing, and variables; the most dimensions of a variable, and the longest name.
const MOST: u64 = 4096;
const MOST_SIDES: u64 = 1024;
const LONGEST: u64 = 1024;

/// Tags of lists.
const DIMENSION: u32 = 10;
const VARIABLE: u32 = 11;
const ATTRIBUTE: u32 = 12;

/// The number of records of a file that was not closed.
const STREAMING: [u64; 2] = [u32::MAX as u64, u64::MAX];

impl Variable {
    /// Bytes of its numbers, of one record.
    pub(super) fn bytes(&self) -> u64 {
        self.count.saturating_mul(self.scalar.size() as u64)
    }

    /// The same with the bytes that fill the last word.
    fn padded(&self) -> u64 {
        self.bytes().saturating_add(3) & !3
    }
}

/// The numbers of a header, whose sizes differ between the versions of the format.
struct Reading<'a> {
    file: &'a mut BinaryFile,
    version: u8,
    block: Vec<u8>,
}

impl Reading<'_> {
    fn word(&mut self, field: &str) -> Result<u32> {
        self.file.bytes(field).map(u32::from_be_bytes)
    }

    /// A count or a length: 8 bytes in CDF-5, else 4.
    fn count(&mut self, field: &str) -> Result<u64> {
        if self.version == 5 { self.file.bytes(field).map(u64::from_be_bytes) } else { self.word(field).map(u64::from) }
    }

    /// A place in the file: 4 bytes in CDF-1, else 8.
    fn place(&mut self, field: &str) -> Result<u64> {
        if self.version == 1 { self.word(field).map(u64::from) } else { self.file.bytes(field).map(u64::from_be_bytes) }
    }

    /// A count that is at most `most`.
    fn limited(&mut self, most: u64, field: &str) -> Result<u64> {
        let (at, count) = (self.file.at(), self.count(field)?);
        if count <= most {
            return Ok(count);
        }
        Err(self.file.fail(at, field, format!("{count} is more than {most}"), DAMAGED))
    }

    /// The number of entries of a list with this tag; 0 where it is absent.
    fn list(&mut self, tag: u32, field: &str) -> Result<u64> {
        let (at, found) = (self.file.at(), self.word(field)?);
        let count = self.limited(MOST, field)?;
        match (found, count) {
            (found, count) if found == tag => Ok(count),
            (0, 0) => Ok(0),
            _ => Err(self.file.fail(at, field, format!("a list begins with {found}, not with {tag}"), DAMAGED)),
        }
    }

    fn name(&mut self, field: &str) -> Result<String> {
        let length = self.limited(LONGEST, field)?;
        self.file.block(length.next_multiple_of(4), &mut self.block, field)?;
        Ok(String::from_utf8_lossy(&self.block[..length as usize]).into_owned())
    }

    /// The type of numbers.
    fn scalar(&mut self, field: &str) -> Result<Scalar> {
        let (at, code) = (self.file.at(), self.word(field)?);
        let (kind, size) = match code {
            1 => (NumberKind::Signed, 1),
            2 | 7 => (NumberKind::Unsigned, 1),
            3 => (NumberKind::Signed, 2),
            4 => (NumberKind::Signed, 4),
            5 => (NumberKind::Float, 4),
            6 => (NumberKind::Float, 8),
            8 => (NumberKind::Unsigned, 2),
            9 => (NumberKind::Unsigned, 4),
            10 => (NumberKind::Signed, 8),
            11 => (NumberKind::Unsigned, 8),
            _ => return Err(self.file.fail(at, field, format!("there is no type {code}"), DAMAGED)),
        };
        Ok(Scalar::of(kind, size, true))
    }

    /// Passes the attributes; returns `scale_factor`, if it is among them.
    fn attributes(&mut self) -> Result<Option<f64>> {
        let (field, mut factor) = ("attributes", None);
        for _ in 0..self.list(ATTRIBUTE, field)? {
            let name = self.name(field)?;
            let (scalar, count) = (self.scalar(field)?, self.count(field)?);
            let bytes = count.saturating_mul(scalar.size() as u64).saturating_add(3) & !3;
            if name == "scale_factor" && count == 1 {
                self.file.block(bytes, &mut self.block, field)?;
                factor = Some(scalar.number(&self.block));
            } else {
                self.file.pass(bytes, field)?;
            }
        }
        Ok(factor)
    }

    fn variable(&mut self, dimensions: &[u64]) -> Result<Variable> {
        let field = "variables";
        let name = self.name(field)?;
        let mut sides = Vec::new();
        for _ in 0..self.limited(MOST_SIDES, field)? {
            let (at, number) = (self.file.at(), self.count(field)?);
            let side = usize::try_from(number).ok().and_then(|number| dimensions.get(number));
            let none = || self.file.fail(at, field, format!("there is no dimension {number}"), DAMAGED);
            sides.push(*side.ok_or_else(none)?);
        }
        let factor = self.attributes()?.filter(|factor| factor.is_finite()).unwrap_or(1.0);
        let scalar = self.scalar(field)?;
        // The size follows from the dimensions; the word has no room for the size of a large variable.
        self.count(field)?;
        let begin = self.place(field)?;
        let is_record = sides.first() == Some(&0);
        let count = sides[usize::from(is_record)..].iter().fold(1, |all: u64, side| all.saturating_mul(*side));
        Ok(Variable { name, sides, is_record, count, scalar, factor, begin })
    }
}

/// Reads the header.
///
/// # Errors
/// [`Error::Scene`](halfline_ground::Error::Scene) with the byte.
pub(super) fn header(file: &mut BinaryFile) -> Result<Header> {
    let [c, d, f, version]: [u8; 4] = file.bytes("magic number")?;
    if [c, d, f] != *b"CDF" || ![1, 2, 5].contains(&version) {
        let problem = "the file does not begin with CDF and 1, 2 or 5";
        return Err(file.fail(0, "magic number", problem, "use a NetCDF file of a classic format"));
    }
    let mut reading = Reading { file, version, block: Vec::new() };
    let count = reading.count("number of records")?;
    let frames = if count == STREAMING[usize::from(version == 5)] { Frames::ToTheEnd } else { Frames::Known(count) };
    let mut dimensions = Vec::new();
    for _ in 0..reading.list(DIMENSION, "dimensions")? {
        reading.name("dimensions")?;
        dimensions.push(reading.count("dimensions")?);
    }
    reading.attributes()?;
    let mut variables = Vec::new();
    for _ in 0..reading.list(VARIABLE, "variables")? {
        variables.push(reading.variable(&dimensions)?);
    }
    let records: Vec<&Variable> = variables.iter().filter(|variable| variable.is_record).collect();
    let record_size = match records[..] {
        // A single one is not padded.
        [variable] => variable.bytes(),
        _ => records.iter().fold(0, |all: u64, variable| all.saturating_add(variable.padded())),
    };
    Ok(Header { frames, variables, record_size })
}
