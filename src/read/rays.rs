//! Given rays from a file, block by block: a NumPy array, or a table of text.
//!
//! A row is `ox oy oz dx dy dz [tmax]`: origin, direction, and a limit of t, +inf by default. A row is invalid if the
//! origin or the direction is not finite, the direction is zero, or tmax is NaN. A tmax of 0 or less is valid: the ray
//! hits nothing.

mod array;
mod table;
#[cfg(test)]
mod tests;

use super::input::Input;
use crate::error::{Error, Place, Result};
use crate::npy::MAGIC;
use crate::progress::Watch;
use crate::render::trace::Rays;
use array::RayArray;
use std::io::Read;
use std::path::Path;
use table::RayTable;

/// The names of the columns, in the order of a row's numbers.
pub const COLUMNS: [&str; 7] = ["ox", "oy", "oz", "dx", "dy", "dz", "tmax"];

/// The columns without tmax, which is optional.
const REQUIRED: usize = 6;

/// How rays are read.
#[derive(Debug, Clone, Default)]
pub struct RayOptions {
    /// Leaves invalid rows out of the rays and counts them; otherwise the first one is an error.
    pub skip_invalid: bool,
    /// Can cancel the reading.
    pub watch: Watch,
}

/// The rays of consecutive rows.
#[derive(Debug, Default)]
pub struct RayBlock {
    /// The origins of the valid rows, or a single one for all.
    pub origins: Vec<[f64; 3]>,
    /// Their directions, of any length but zero.
    pub directions: Vec<[f64; 3]>,
    /// Their limits, or none at all if the file has none.
    pub limits: Vec<f64>,
    /// The places of the invalid rows in the block, from 0, in ascending order.
    pub invalid: Vec<u32>,
    /// What is wrong with the first of them.
    pub fault: Option<Error>,
}

impl RayBlock {
    /// The number of rows, the invalid ones included.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.directions.len() + self.invalid.len()
    }

    /// The valid rows.
    #[must_use]
    pub fn rays(&self) -> Rays<'_> {
        Rays { origins: &self.origins, directions: &self.directions, limits: &self.limits }
    }

    /// Adds a valid row.
    fn push(&mut self, [ox, oy, oz, dx, dy, dz, tmax]: Row, limited: bool) {
        self.origins.push([ox, oy, oz]);
        self.directions.push([dx, dy, dz]);
        if limited {
            self.limits.push(tmax);
        }
    }

    /// Counts an invalid row, or returns its error where none may be left out.
    fn leave_out(&mut self, options: &RayOptions, fault: impl FnOnce() -> Error) -> Result<()> {
        if !options.skip_invalid {
            return Err(fault());
        }
        self.invalid.push(self.rows() as u32);
        self.fault.get_or_insert_with(fault);
        Ok(())
    }

    /// Adds the rows of another block behind its own.
    fn append(&mut self, mut other: Self) {
        let before = self.rows() as u32;
        self.invalid.extend(other.invalid.iter().map(|place| before + place));
        self.origins.append(&mut other.origins);
        self.directions.append(&mut other.directions);
        self.limits.append(&mut other.limits);
        self.fault = self.fault.take().or(other.fault);
    }
}

/// The numbers of a row.
type Row = [f64; 7];

/// What is wrong with a row: the field and the problem.
fn flaw([ox, oy, oz, dx, dy, dz, tmax]: &Row) -> Option<(&'static str, &'static str)> {
    let finite = |point: [&f64; 3]| point.into_iter().all(|x| x.is_finite());
    if !finite([ox, oy, oz]) {
        Some(("origin", "a coordinate is not finite"))
    } else if !finite([dx, dy, dz]) {
        Some(("direction", "a component is not finite"))
    } else if [dx, dy, dz].into_iter().all(|x| *x == 0.0) {
        Some(("direction", "the direction is zero"))
    } else if tmax.is_nan() {
        Some(("tmax", "the limit is NaN"))
    } else {
        None
    }
}

/// The remedy for an invalid row.
const MEND_ROW: &str = "correct the row, or use --skip-invalid to count it as a miss";

/// An opened file of rays.
pub struct RayReader {
    source: RaySource,
    options: RayOptions,
}

enum RaySource {
    Array(RayArray),
    Table(Box<RayTable>),
}

impl RayReader {
    /// Opens `path`; `-` is standard input. The first bytes show the format: a NumPy array, or text. Both may be
    /// compressed with gzip or bzip2.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read, [`Error::Scene`] for one that has no rays in the form above,
    /// [`Error::Interrupted`].
    pub fn open(path: &Path, options: &RayOptions) -> Result<Self> {
        Self::begin(Input::open(path, &options.watch)?, path, options)
    }

    /// Opens a stream; errors refer to it by `path`.
    ///
    /// # Errors
    /// As [`RayReader::open`].
    pub fn from_reader(reader: impl Read + Send + 'static, path: &Path, options: &RayOptions) -> Result<Self> {
        let input = Input::of(Box::new(reader), &options.watch).map_err(|e| Error::read(path, e))?;
        Self::begin(input, path, options)
    }

    fn begin(mut input: Input, path: &Path, options: &RayOptions) -> Result<Self> {
        let start = input.look(MAGIC.len() as u64).map_err(|e| Error::read(path, e))?;
        let source = if start == MAGIC {
            RaySource::Array(RayArray::open(input, path)?)
        } else if start.starts_with(b"PK") {
            let problem = "an archive (.npz) holds several arrays";
            let mend = "save one array of rays with numpy.save";
            return Err(Error::scene(Place::file(path.display().to_string()), problem, mend));
        } else {
            RaySource::Table(Box::new(RayTable::open(input, path)?))
        };
        Ok(Self { source, options: options.clone() })
    }

    /// The number of rows, where the file says it before they are read.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        match &self.source {
            RaySource::Array(array) => Some(array.count()),
            RaySource::Table(_) => None,
        }
    }

    /// The next rows, at most `most`; `None` after the last.
    ///
    /// # Errors
    /// [`Error::Scene`] for an invalid row, unless they are skipped, and for a file that ends too early or does not end
    /// after its last row; [`Error::Io`], [`Error::Interrupted`].
    pub fn next_block(&mut self, most: usize) -> Result<Option<RayBlock>> {
        self.options.watch.check()?;
        let block = match &mut self.source {
            RaySource::Array(array) => array.block(most, &self.options)?,
            RaySource::Table(table) => table.block(most, &self.options)?,
        };
        Ok(Some(block).filter(|block| block.rows() > 0))
    }
}
