//! Measurements: comparing frames, and speed and error of every method.

pub mod compare;
pub mod export;
pub mod frames;
pub mod picture;
#[cfg(feature = "plots")]
pub mod plot;
pub mod record;
#[cfg(feature = "plots")]
pub mod report;
pub mod run;
pub mod score;
mod subject;
pub mod suite;
pub mod total;
pub mod variant;
pub mod verdict;

use crate::error::{Error, Result};
pub use crate::frame::array::{Array, ArrayValue, Values};
use crate::memory::check;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// All bytes of a file, or of standard input for `-`, as long as there is memory for twice as many.
///
/// # Errors
/// [`Error::Io`], [`Error::Limits`].
fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    let mut input: Box<dyn Read> = match crate::write::file::is_standard(path) {
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
