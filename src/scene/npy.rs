//! Spheres from a NumPy array file: float64 (or float32, widened exactly) of shape (n, 4) = x, y, z, radius or
//! (n, 7) = also r, g, b, in C or Fortran order and either byte order; as a scene also (n, 3) without radii, and arrays
//! of records with named fields. Rows count from 0, as NumPy's do.

mod records;

use super::input::{Counts, Input};
use super::{Spheres, check_color, check_sphere, csv::COLUMNS, relocate};
use crate::error::{Error, Place, Result};
use crate::memory::{check_spheres, reserve};
use crate::progress::Watch;
use crate::trailer;
use npyz::{NpyFile, NpyHeader, Order};
use rayon::prelude::*;
use std::io::{self, BufRead, Read};
use std::path::Path;
use std::sync::Arc;

pub(super) use records::Array;

const MEND: &str = "save a float64 array of shape (n, 4) or (n, 7) with numpy.save";

/// Appends the spheres of the file. Memory grows with what the file holds, never with what its header claims.
pub(super) fn read(path: &Path, spheres: &mut Spheres, watch: &Watch) -> Result<()> {
    let reader = Input::open(path, watch)?;
    let bytes = reader.length();
    let counts = reader.counts();
    let mut npy = Npy { path, reader, bytes, counts };
    let header = npy.header()?;
    npy.read(header, &[4, 7], spheres).map(drop)
}

/// An array file that is being read.
pub(super) struct Npy<'p, R> {
    pub(super) path: &'p Path,
    pub(super) reader: R,
    /// The file's length, or less.
    pub(super) bytes: u64,
    /// Of the input.
    pub(super) counts: Arc<Counts>,
}

impl<R: BufRead> Npy<'_, R> {
    /// Appends the spheres of an array of one of these widths, which is returned; where it is 3, with radii of 1.
    fn read(&mut self, header: NpyHeader, widths: &[u64], spheres: &mut Spheres) -> Result<usize> {
        let (rows, width) = match *header.shape() {
            [n, width] if widths.contains(&width) => (n, width as usize),
            ref other => {
                let wanted: Vec<_> = widths.iter().map(|width| format!("(n, {width})")).collect();
                return Err(self.fail("shape", format!("found {other:?}, wanted {}", wanted.join(" or "))));
            }
        };
        // An element has a byte at least; most have eight.
        let size = header.dtype().num_bytes().unwrap_or(1).max(1) as u64;
        let there = rows.min(self.bytes / (size * width as u64));
        check_spheres(spheres.len() as u64 + there, width == COLUMNS.len())?;
        spheres.grow(there as usize, width == COLUMNS.len())?;
        let order = header.order();
        let plain = PLAIN.into_iter().find(|plain| plain.0 == header.dtype().descr() && order == Order::C);
        if let Some((_, bytes, decode)) = plain {
            let form = Form { rows, width, order, counts: &self.counts };
            let outcome = fill_blocks(&mut self.reader, &form, bytes, decode, spheres);
            return self.finish(outcome, rows).map(|()| width);
        }
        let counts = Arc::clone(&self.counts);
        let form = Form { rows, width, order, counts: &counts };
        let file = match NpyFile::with_header(header, &mut self.reader).try_data::<f64>() {
            Ok(numbers) => {
                let row = fill(numbers, &form, spheres);
                return self.finish(row, rows).map(|()| width);
            }
            Err(file) => file,
        };
        let found = file.header().dtype().descr();
        let row = match file.try_data::<f32>() {
            Ok(numbers) => fill(numbers.map(|x| x.map(f64::from)), &form, spheres),
            Err(_) => return Err(self.fail("dtype", format!("found {found}, wanted float64 or float32"))),
        };
        self.finish(row, rows).map(|()| width)
    }

    /// The header, once it is known to be small and simple. npyz would allocate what a damaged header claims, multiply
    /// its shape without looking, and descend into nested brackets as deep as they go.
    pub(super) fn header(&mut self) -> Result<NpyHeader> {
        let mut bytes = vec![0; 10];
        self.exact(&mut bytes)?;
        if !bytes.starts_with(b"\x93NUMPY") {
            return Err(self.fail("magic", "this is no NumPy array file"));
        }
        let length = match bytes[6] {
            1 => usize::from(u16::from_le_bytes([bytes[8], bytes[9]])),
            _ => {
                bytes.resize(12, 0);
                self.exact(&mut bytes[10..])?;
                u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize
            }
        };
        if length > MAX_HEADER {
            return Err(self.fail("header", format!("{length} bytes of header are more than {MAX_HEADER}")));
        }
        let start = bytes.len();
        bytes.resize(start + length, 0);
        self.exact(&mut bytes[start..])?;
        let text = String::from_utf8_lossy(&bytes[start..]);
        // The parser's own words draw the header over several lines; quoting it says as much.
        let header = if is_simple(&text) { NpyHeader::from_reader(&bytes[..]).ok() } else { None };
        header.ok_or_else(|| {
            let quoted: String = text.trim_end().chars().take(120).collect();
            self.fail("header", format!("{quoted:?} describes no such array"))
        })
    }

    fn exact(&mut self, bytes: &mut [u8]) -> Result<()> {
        self.reader.read_exact(bytes).map_err(|e| match e.kind() {
            io::ErrorKind::UnexpectedEof => self.fail("header", "the file ends within its header"),
            _ => Error::read(self.path, e),
        })
    }

    /// Turns a row's fault into an error, and sees to it that nothing follows the last row.
    fn finish(&mut self, outcome: Result<(), Fault>, rows: u64) -> Result<()> {
        match outcome {
            Ok(()) => {}
            Err(Fault::Numbers(found, e)) if e.kind() == io::ErrorKind::UnexpectedEof => {
                return Err(self.fail("data", format!("the file ends after {found} of {rows} rows")));
            }
            Err(Fault::Numbers(_, e)) => return Err(Error::read(self.path, e)),
            Err(Fault::Row(row, error)) => {
                return Err(relocate(error, |field| self.place(format!("row {row} {field}"))));
            }
        }
        let mut rest = Vec::new();
        match self.reader.by_ref().take(1 << 17).read_to_end(&mut rest) {
            // Behind an array of ours stands where it comes from.
            Ok(_) if rest.is_empty() || trailer::json(&rest).is_some() => Ok(()),
            Ok(_) => Err(self.fail("data", format!("bytes follow the {rows} rows that the header announces"))),
            Err(e) => Err(Error::read(self.path, e)),
        }
    }

    pub(super) fn place(&self, field: impl Into<String>) -> Place {
        Place::file(self.path.display().to_string()).named(field)
    }

    pub(super) fn fail(&self, field: &str, problem: impl Into<String>) -> Error {
        Error::scene(self.place(field), problem, MEND)
    }
}

/// NumPy itself refuses longer headers; ours need about a hundred bytes.
const MAX_HEADER: usize = 10_000;

/// Whether the header holds nothing but plain words, brackets that are not deep, and so few digits that no shape made of
/// them overflows: a product of numbers of 19 decimal digits in all is below 10^19 < 2^64. Within quotes stand names and
/// types, whose sizes have few digits.
fn is_simple(text: &str) -> bool {
    let (mut depth, mut digits, mut quote, mut run) = (0, 0, None, 0);
    for c in text.chars() {
        let digit = c.is_ascii_digit();
        run = if digit { run + 1 } else { 0 };
        match (quote, c) {
            (None, '\'' | '"') => quote = Some(c),
            (Some(open), _) if c == open => quote = None,
            (Some(_), _) if run > 6 => return false,
            (Some(_), _) => {}
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth -= 1,
            (None, _) if digit => digits += 1,
            _ => {}
        }
        let plain = c.is_ascii_alphanumeric() || " \n\t_'\"(){}[],:<>|=.".contains(c);
        if !plain || !(0..=4).contains(&depth) || digits > 19 {
            return false;
        }
    }
    !text.contains("0x") && !text.contains("0X")
}

/// Why the rows could not be taken over.
enum Fault {
    /// The stream gave no more numbers after so many whole rows.
    Numbers(u64, io::Error),
    /// The row holds no sphere.
    Row(u64, Error),
}

/// How a number is read from its bytes.
type Decode = fn(&[u8]) -> f64;

/// What NumPy writes nearly always, as its header names it: bytes of a number, and how they are read.
const PLAIN: [(&str, usize, Decode); 2] = [
    ("'<f8'", 8, |bytes| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes)),
    ("'<f4'", 4, |bytes| bytes.try_into().map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(bytes)))),
];

/// Rows that are read at once, and then taken apart on all cores.
const BLOCK: usize = 1 << 16;

/// How an array lies in its file.
struct Form<'a> {
    rows: u64,
    width: usize,
    order: Order,
    counts: &'a Counts,
}

/// As [`fill`], of rows that lie one after the other.
fn fill_blocks(
    reader: &mut impl BufRead,
    &Form { rows, width, counts, .. }: &Form<'_>,
    size: usize,
    decode: Decode,
    spheres: &mut Spheres,
) -> Result<(), Fault> {
    let row_bytes = width * size;
    let values = |row: &[u8]| {
        let mut values = [0.0; 7];
        values.iter_mut().zip(row.chunks_exact(size)).for_each(|(value, bytes)| *value = decode(bytes));
        values
    };
    let mut bytes = Vec::new();
    let mut done = 0;
    while done < rows {
        let wanted = row_bytes as u64 * (rows - done).min(BLOCK as u64);
        bytes.clear();
        reader.take(wanted).read_to_end(&mut bytes).map_err(|e| Fault::Numbers(done, e))?;
        let block = bytes.par_chunks_exact(row_bytes);
        let found = block.len() as u64;
        counts.found();
        spheres.grow(block.len(), false).map_err(|e| Fault::Row(done, e))?;
        let sphere = |[x, y, z, radius, ..]: [f64; 7]| ([x, y, z], if width == 3 { 1.0 } else { radius });
        let is_sphere = |row: &[u8]| {
            let (center, radius) = sphere(values(row));
            check_sphere(center, radius, Place::default).is_ok()
        };
        if width <= 4 && spheres.colors.is_none() && block.clone().all(is_sphere) {
            let (centers, radii): (Vec<_>, Vec<_>) = block.map(|row| sphere(values(row))).unzip();
            spheres.centers.extend(centers);
            spheres.radii.extend(radii);
        } else {
            for (row, bytes) in (done..).zip(bytes.chunks_exact(row_bytes)) {
                push(values(bytes), width, spheres).map_err(|e| Fault::Row(row, e))?;
            }
        }
        done += found;
        if (bytes.len() as u64) < wanted {
            return Err(Fault::Numbers(done, io::ErrorKind::UnexpectedEof.into()));
        }
    }
    Ok(())
}

fn fill(
    mut numbers: impl Iterator<Item = io::Result<f64>>,
    &Form { rows, width, order, counts }: &Form<'_>,
    spheres: &mut Spheres,
) -> Result<(), Fault> {
    let mut next = |row| match numbers.next() {
        Some(Ok(x)) => Ok(x),
        Some(Err(e)) => Err(Fault::Numbers(row, e)),
        None => Err(Fault::Numbers(row, io::ErrorKind::UnexpectedEof.into())),
    };
    let mut values = [0.0; 7];
    if order == Order::C {
        for row in 0..rows {
            for value in &mut values[..width] {
                *value = next(row)?;
            }
            counts.found();
            push(values, width, spheres).map_err(|e| Fault::Row(row, e))?;
        }
        return Ok(());
    }
    // Column by column: no row is whole before the last column has begun.
    let mut columns = Vec::new();
    for column in 0..width {
        for row in 0..rows {
            reserve(&mut columns, 1).map_err(|e| Fault::Row(row, e))?;
            columns.push(next(if column + 1 == width { row } else { 0 })?);
            counts.found();
        }
    }
    let rows = columns.len() / width;
    for row in 0..rows {
        for (column, value) in values[..width].iter_mut().enumerate() {
            *value = columns[column * rows + row];
        }
        push(values, width, spheres).map_err(|e| Fault::Row(row as u64, e))?;
    }
    Ok(())
}

fn push([x, y, z, radius, r, g, b]: [f64; 7], width: usize, spheres: &mut Spheres) -> Result<()> {
    let radius = if width == 3 { 1.0 } else { radius };
    check_sphere([x, y, z], radius, Place::default)?;
    let color = (width == COLUMNS.len()).then_some([r as f32, g as f32, b as f32]);
    if let Some(color) = color {
        check_color(color, || Place::field("color"))?;
    }
    spheres.add([x, y, z], radius, color)
}
