//! SphereRows from a NumPy array file: numbers of any type (float16 and float32 are converted exactly) of shape (n, 4) = x, y, z, radius
//! or (n, 7) = also r, g, b, in C or Fortran order and either byte order; as a scene also (n, 3) without radii, (frames, n, 3)
//! and so on as a film, and arrays of records with named fields. Rows count from 0, as in NumPy.

pub mod header;
pub(super) mod records;
mod rows;

use super::gauge::Counts;
use super::input::{Input, fill};
use super::particles::left_out::LeftOut;
use super::particles::names::Names;
use super::particles::survey::Survey;
use crate::blocks;
use crate::spheres::SphereRows;
use halfline_ground::error::{Error, Place, Result, relocate};
use halfline_ground::memory::{check, reserve};
use halfline_ground::progress::Watch;
use halfline_ground::trailer;
pub use header::{DType, Fault, Field, Header, MAGIC, NumberKind, Scalar, bits, levels};
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The remedy for spheres.
const MEND: &str = "save a float64 array of shape (n, 4) or (n, 7) with numpy.save";

/// The bytes that are read at a time, so that two blocks fit into a core's cache.
const BLOCK: usize = 1 << 20;

/// Appends the spheres of the file. Memory grows with the content of the file, not with the counts in its header.
pub fn read(path: &Path, spheres: &mut SphereRows, watch: &Watch) -> Result<()> {
    let mut npy = Npy::new(Input::open(path, watch)?, path, MEND);
    let header = npy.header()?;
    npy.spheres(&header, &[4, 7], spheres, None)?;
    npy.end(header.shape[0])
}

/// Passes the spheres of the file on, block by block.
pub fn pass(path: &Path, survey: &Survey, watch: &Watch) -> Result<()> {
    let (mut npy, mut rest) = (Npy::new(Input::open(path, watch)?, path, MEND), SphereRows::default());
    let header = npy.header()?;
    npy.spheres(&header, &[4, 7], &mut rest, Some(survey))?;
    npy.end(header.shape[0])?;
    // An array in Fortran order is not passed on in blocks.
    if rest.is_empty() { Ok(()) } else { survey.take_spheres(&mut rest, true) }
}

/// Whether the spheres of the file have colours.
pub fn is_colored(path: &Path, watch: &Watch) -> Result<bool> {
    let mut npy = Npy::new(Input::open(path, watch)?, path, MEND);
    let header = npy.header()?;
    npy.matrix(&header, &[4, 7]).map(|matrix| matrix.width == 7)
}

/// The bytes of a text of this type of NumPy, and of its letters; `None` for other types, and for texts without letters.
pub(super) fn text_size(kind: &str) -> Option<(usize, usize)> {
    let letter = match kind.as_bytes() {
        [b'<' | b'>' | b'=', b'U', ..] => 4,
        [b'|', b'S' | b'a', ..] => 1,
        _ => return None,
    };
    let size = DType::Plain(kind.to_owned()).bytes()?;
    (1..=LONGEST_TEXT).contains(&size).then_some((size, letter))
}

/// The most bytes of a text.
const LONGEST_TEXT: usize = 1 << 16;

/// A letter in UTF-32, or a byte.
fn letter_of(bytes: &[u8], big: bool) -> char {
    match bytes.first_chunk::<4>() {
        Some(bytes) if big => char::from_u32(u32::from_be_bytes(*bytes)).unwrap_or(char::REPLACEMENT_CHARACTER),
        Some(bytes) => char::from_u32(u32::from_le_bytes(*bytes)).unwrap_or(char::REPLACEMENT_CHARACTER),
        None => char::from(bytes[0]),
    }
}

/// A shape as NumPy prints it.
pub(super) fn shown(shape: &[u64]) -> String {
    match shape {
        [side] => format!("({side},)"),
        sides => format!("({})", sides.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// An array file while it is read.
pub struct Npy<R> {
    pub path: PathBuf,
    pub reader: R,
    /// The file's length, or a lower bound.
    pub(super) bytes: u64,
    /// The counters of the input.
    pub(super) counts: Arc<Counts>,
    /// The remedy in errors: the array to save instead.
    pub(super) mend: &'static str,
    /// The invalid rows that are left out; `None` where they are errors.
    pub(super) left_out: Option<LeftOut>,
}

/// The rows of an array of two dimensions.
#[derive(Clone, Copy)]
pub struct Matrix {
    pub rows: u64,
    pub width: usize,
    pub scalar: Scalar,
}

impl Matrix {
    /// Bytes of a row.
    pub fn row(&self) -> usize {
        self.width * self.scalar.size()
    }
}

impl Npy<Input> {
    /// The array at the beginning of `reader`.
    pub fn new(reader: Input, path: &Path, mend: &'static str) -> Self {
        let (bytes, counts) = (reader.length(), reader.counts());
        Self { path: path.to_path_buf(), reader, bytes, counts, mend, left_out: None }
    }
}

impl<R: BufRead> Npy<R> {
    /// The header of the array.
    pub fn header(&mut self) -> Result<Header> {
        Header::read(&mut self.reader).map_err(|fault| match fault {
            Fault::Io(error) => Error::read(&self.path, error),
            fault => self.fail(fault.field(), fault.to_string()),
        })
    }

    /// The rows of an array of numbers that has one of these widths. Colours are floats.
    pub fn matrix(&self, header: &Header, widths: &[u64]) -> Result<Matrix> {
        let (rows, width) = match header.shape[..] {
            [rows, width] if widths.contains(&width) => (rows, width as usize),
            _ => {
                let expected: Vec<_> = widths.iter().map(|width| format!("(n, {width})")).collect();
                let problem = format!("found {}, expected {}", shown(&header.shape), expected.join(" or "));
                return Err(self.fail("shape", problem));
            }
        };
        let is_colored = widths.contains(&4) && width == 7;
        let scalar = header.dtype.scalar().filter(|scalar| !(is_colored && scalar.is_whole()));
        let expected = if is_colored { "floats" } else { "integers or floats of at most 8 bytes" };
        let unknown = || self.fail("dtype", format!("found {}, expected {expected}", header.dtype));
        Ok(Matrix { rows, width, scalar: scalar.ok_or_else(unknown)? })
    }

    /// Replaces the content of `block` by rows of `row` bytes, at most `most`; returns their number, which is 0 at the end.
    pub fn block(&mut self, most: u64, row: usize, block: &mut Vec<u8>) -> io::Result<u64> {
        // The content of an earlier block is overwritten, not cleared.
        block.resize(most.min((blocks::at_most(BLOCK) / row).max(1) as u64) as usize * row, 0);
        let filled = fill(&mut self.reader, block)?;
        block.truncate(filled - filled % row);
        self.counts.found();
        Ok((filled / row) as u64)
    }

    /// The numbers of an array, in the order of its indices, the last one fastest. Memory grows with the data read.
    pub(super) fn numbers(&mut self, header: &Header) -> Result<Vec<f64>> {
        let Some(scalar) = header.dtype.scalar() else {
            let is_plain = matches!(header.dtype, DType::Plain(_));
            let expected = if is_plain { "integers or floats of at most 8 bytes" } else { "numbers" };
            return Err(self.fail("dtype", format!("found {}, expected {expected}", header.dtype)));
        };
        let shape = &header.shape;
        let width = if shape.len() > 1 { shape[shape.len() - 1] } else { 1 };
        let rows = if shape.len() > 1 { shape[..shape.len() - 1].iter().product() } else { shape.iter().product() };
        let numbers = self.stored(rows, width, scalar, |numbers| numbers.checked_div(width).unwrap_or(rows))?;
        if !header.fortran || shape.len() < 2 {
            return Ok(numbers);
        }
        check(8 * numbers.len() as u64, || "the array in the order of its rows".into())?;
        // The first index is the fastest in the file.
        let place = |at: usize| {
            let (mut rest, mut place) = (at, 0);
            let mut step = numbers.len();
            for side in shape.iter().rev().map(|side| *side as usize) {
                step /= side;
                place += rest % side * step;
                rest /= side;
            }
            place
        };
        Ok((0..numbers.len()).map(|at| numbers[place(at)]).collect())
    }

    /// The texts of an array of one dimension, numbered in the order of their first occurrence.
    pub(super) fn texts(&mut self, header: &Header) -> Result<(Vec<f64>, Names)> {
        let kind = if let DType::Plain(kind) = &header.dtype { kind.as_str() } else { "" };
        let (Some((size, letter)), [rows]) = (text_size(kind), &header.shape[..]) else {
            return Err(self.fail("dtype", format!("found {}, expected texts in (n,)", header.dtype)));
        };
        let (mut values, mut names, mut block, mut left) = (Vec::new(), Names::default(), Vec::new(), *rows);
        while left > 0 {
            let read = self.block(left, size, &mut block);
            match read.map_err(|error| self.cut(error, rows - left, *rows))? {
                0 => return Err(self.cut(io::ErrorKind::UnexpectedEof.into(), rows - left, *rows)),
                found => left -= found,
            }
            reserve(&mut values, block.len() / size)?;
            for text in block.chunks_exact(size) {
                let text: String =
                    text.chunks_exact(letter).map(|bytes| letter_of(bytes, kind.starts_with('>'))).collect();
                values.push(names.number(text.trim_end_matches('\0').as_bytes())?.into());
            }
        }
        Ok((values, names))
    }

    /// The numbers of an array in the order of the file; `complete` has the rows that are complete with so many numbers.
    fn stored(&mut self, rows: u64, width: u64, scalar: Scalar, complete: impl Fn(u64) -> u64) -> Result<Vec<f64>> {
        let (mut numbers, mut block) = (Vec::new(), Vec::new());
        let (size, mut left) = (scalar.size(), rows * width);
        while left > 0 {
            let read = self.block(left, size, &mut block);
            let done = complete(numbers.len() as u64);
            match read.map_err(|error| self.cut(error, done, rows))? {
                0 => return Err(self.cut(io::ErrorKind::UnexpectedEof.into(), done, rows)),
                found => left -= found,
            }
            reserve(&mut numbers, block.len() / size)?;
            numbers.extend(block.chunks_exact(size).map(|number| scalar.number(number)));
        }
        Ok(numbers)
    }

    /// Checks that nothing follows the last row but a provenance.
    pub fn end(&mut self, rows: u64) -> Result<()> {
        let mut rest = Vec::new();
        match self.reader.by_ref().take(1 << 17).read_to_end(&mut rest) {
            Ok(_) if rest.is_empty() || trailer::json(&rest).is_some() => Ok(()),
            Ok(_) => Err(self.fail("data", format!("bytes follow the {rows} rows of the header"))),
            Err(e) => Err(Error::read(&self.path, e)),
        }
    }

    /// The error for an array where only `found` rows could be read.
    pub fn cut(&self, error: io::Error, found: u64, rows: u64) -> Error {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => self.fail("data", format!("the file ends after {found} of {rows} rows")),
            _ => Error::read(&self.path, error),
        }
    }

    /// The error of a row.
    pub(super) fn in_row(&self, row: u64, error: Error) -> Error {
        relocate(error, |field| self.place(format!("row {row} {field}")))
    }

    pub fn place(&self, field: impl Into<String>) -> Place {
        Place::file(self.path.display().to_string()).named(field)
    }

    pub(super) fn fail(&self, field: &str, problem: impl Into<String>) -> Error {
        Error::scene(self.place(field), problem, self.mend)
    }
}
