//! Spheres from a NumPy array file: float64 (or float32, converted exactly) of shape (n, 4) = x, y, z, radius or (n, 7)
//! = also r, g, b, in C or Fortran order and either byte order; as a scene also (n, 3) without radii, and arrays of
//! records with named fields. Rows count from 0, as in NumPy.

pub(super) mod records;
mod rows;

use super::csv::COLUMNS;
use super::input::{Counts, Input};
use super::particles::scalar::Scalar;
use super::particles::survey::Survey;
use crate::error::{Error, Place, Result, relocate};
use crate::memory::check_spheres;
use crate::npy::{DType, Fault as HeaderFault, Header};
use crate::progress::Watch;
use crate::scene::Spheres;
use crate::trailer;
use rows::{Fault, Form, fill_columns, fill_rows};
use std::io::{self, BufRead, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The remedy for spheres.
const MEND: &str = "save a float64 array of shape (n, 4) or (n, 7) with numpy.save";

/// Appends the spheres of the file. Memory grows with the content of the file, not with the counts in its header.
pub(super) fn read(path: &Path, spheres: &mut Spheres, watch: &Watch) -> Result<()> {
    let mut npy = Npy::new(Input::open(path, watch)?, path, MEND);
    let header = npy.header()?;
    npy.read(&header, &[4, 7], spheres, None).map(drop)
}

/// An array file while it is read.
pub(super) struct Npy<R> {
    pub(super) path: PathBuf,
    pub(super) reader: R,
    /// The file's length, or a lower bound.
    pub(super) bytes: u64,
    /// The counters of the input.
    pub(super) counts: Arc<Counts>,
    /// What to save instead of an array that cannot be used.
    pub(super) mend: &'static str,
}

impl Npy<Input> {
    /// The array at the beginning of `reader`.
    pub(super) fn new(reader: Input, path: &Path, mend: &'static str) -> Self {
        let (bytes, counts) = (reader.length(), reader.counts());
        Self { path: path.to_path_buf(), reader, bytes, counts, mend }
    }
}

impl Npy<Input> {
    /// Appends the spheres of an array with one of these widths, which is returned; for a width of 3 the radii are 1.
    /// For a survey the spheres of an array in C order are counted or passed on, block by block.
    fn read(
        &mut self,
        header: &Header,
        widths: &[u64],
        spheres: &mut Spheres,
        survey: Option<&Survey>,
    ) -> Result<usize> {
        let (rows, width) = match header.shape[..] {
            [n, width] if widths.contains(&width) => (n, width as usize),
            ref other => {
                let expected: Vec<_> = widths.iter().map(|width| format!("(n, {width})")).collect();
                return Err(self.fail("shape", format!("found {other:?}, expected {}", expected.join(" or "))));
            }
        };
        let scalar = match &header.dtype {
            DType::Plain(name) => Scalar::of_numpy(name).filter(|scalar| !scalar.is_whole()),
            _ => None,
        };
        let Some(scalar) = scalar else {
            return Err(self.fail("dtype", format!("found {}, expected float64 or float32", header.dtype)));
        };
        let there = rows.min(self.bytes / (scalar.size() * width) as u64);
        if survey.is_none() {
            check_spheres(spheres.len() as u64 + there, width == COLUMNS.len())?;
            spheres.grow(there as usize, width == COLUMNS.len())?;
        }
        let counts = Arc::clone(&self.counts);
        let form = Form { rows, width, scalar, counts: &counts, survey };
        let outcome = match header.fortran {
            false => fill_rows(&mut self.reader, &form, spheres),
            true => fill_columns(&mut self.reader, &form, spheres),
        };
        self.finish(outcome, rows).map(|()| width)
    }
}

impl<R: BufRead> Npy<R> {
    /// The header of the array.
    pub(super) fn header(&mut self) -> Result<Header> {
        Header::read(&mut self.reader).map_err(|fault| match fault {
            HeaderFault::Io(error) => Error::read(&self.path, error),
            fault => self.fail(fault.field(), fault.to_string()),
        })
    }

    /// Converts the error of a row, and checks that nothing follows the last row.
    fn finish(&mut self, outcome: Result<(), Fault>, rows: u64) -> Result<()> {
        match outcome {
            Ok(()) => {}
            Err(Fault::Numbers(found, e)) => return Err(self.cut(e, found, rows)),
            Err(Fault::Row(row, error)) => {
                return Err(relocate(error, |field| self.place(format!("row {row} {field}"))));
            }
        }
        self.end(rows)
    }

    /// Checks that nothing follows the last row but a provenance.
    pub(super) fn end(&mut self, rows: u64) -> Result<()> {
        let mut rest = Vec::new();
        match self.reader.by_ref().take(1 << 17).read_to_end(&mut rest) {
            Ok(_) if rest.is_empty() || trailer::json(&rest).is_some() => Ok(()),
            Ok(_) => Err(self.fail("data", format!("bytes follow the {rows} rows of the header"))),
            Err(e) => Err(Error::read(&self.path, e)),
        }
    }

    /// The error for an array of which only `found` rows could be read.
    pub(super) fn cut(&self, error: io::Error, found: u64, rows: u64) -> Error {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => self.fail("data", format!("the file ends after {found} of {rows} rows")),
            _ => Error::read(&self.path, error),
        }
    }

    pub(super) fn place(&self, field: impl Into<String>) -> Place {
        Place::file(self.path.display().to_string()).named(field)
    }

    pub(super) fn fail(&self, field: &str, problem: impl Into<String>) -> Error {
        Error::scene(self.place(field), problem, self.mend)
    }
}
