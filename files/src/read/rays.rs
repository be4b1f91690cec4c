//! Given rays from a file, block by block: a NumPy array, or a table of text.
//!
//! A row is `ox oy oz dx dy dz [tmax]`: origin, direction, and a limit of t, +inf by default. A row is invalid if the
//! origin or the direction is not finite, the direction is zero, or tmax is NaN. A tmax of 0 or less is valid: the ray
//! hits nothing.

mod array;
mod block;
mod table;
#[cfg(test)]
mod tests;

use array::RayArray;
use halfline::error::{Error, Place, Result};
use halfline_particles::input::Input;
use halfline_particles::npy::header::MAGIC;
use std::io::Read;
use std::path::Path;
use table::RayTable;

pub use block::{COLUMNS, RayBlock, RayOptions};

/// An opened file of rays.
pub struct RayReader {
    source: RaySource,
    options: RayOptions,
}

enum RaySource {
    Array(Box<RayArray>),
    Table(Box<RayTable>),
}

impl RayReader {
    /// Opens `path`; `-` is standard input. The first bytes show the format: a NumPy array, or text. Both may be
    /// compressed with gzip, bzip2, xz or Zstandard.
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
            RaySource::Array(Box::new(RayArray::open(input, path)?))
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
