//! Measurements: comparing frames, and speed and error of every method.

pub mod compare;
pub mod export;
pub mod frames;
pub mod picture;
pub mod plot;
pub mod record;
pub mod report;
pub mod run;
pub mod score;
mod subject;
pub mod suite;
pub mod total;
pub mod variant;
pub mod verdict;

use halfline::error::{Error, Place, Result};
pub use halfline::frame::array::{Array, ArrayValue, Values};
use halfline::memory::check;
use halfline_files::write::{npy, png};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// All bytes of a file, or of standard input for `-`, as long as there is memory for twice as many.
///
/// # Errors
/// [`Error::Io`], [`Error::Limits`].
fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    let mut input: Box<dyn Read> = match halfline_files::write::file::is_standard(path) {
        true => Box::new(std::io::stdin().lock()),
        false => Box::new(File::open(path).map_err(|error| Error::read(path, error))?),
    };
    let mut bytes = Vec::new();
    loop {
        let more = bytes.len().max(1 << 16);
        check(more as u64, || format!("more of {} than its first {} bytes", path.display(), bytes.len()))?;
        bytes.reserve_exact(more);
        let read = Read::take(&mut input, more as u64).read_to_end(&mut bytes);
        if read.map_err(|error| Error::read(path, error))? < more {
            return Ok(bytes);
        }
    }
}

/// Reads the array of a .png or .npy file, detected by content; `-` is standard input.
///
/// # Errors
/// [`Error::Io`] for a file that cannot be read, [`Error::Limits`] for one that does not fit into memory,
/// [`Error::Scene`] at a malformed file.
pub fn read_array(path: &Path) -> Result<Array> {
    array_of(&bytes_of(path)?, &path.display().to_string())
}

/// The array in `bytes`, a complete .png or .npy file.
///
/// # Errors
/// [`Error::Scene`] at the file `name`.
pub fn array_of(bytes: &[u8], name: &str) -> Result<Array> {
    if bytes.starts_with(png::MAGIC) {
        png::read(bytes, name)
    } else if bytes.starts_with(npy::MAGIC) {
        npy::read(bytes, name)
    } else {
        Err(Error::scene(Place::file(name), "not a PNG or .npy file", "use a frame that halfline wrote"))
    }
}
