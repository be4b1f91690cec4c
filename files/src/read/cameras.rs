//! Lists of cameras: halfline's own lists, NeRF's transforms.json, poses with intrinsics in the axes of OpenCV, and
//! tables. One reader for JSON and one for CSV; a pose is a camera, a size and optionally intrinsics.
//!
//! Sources: github.com/bmild/nerf and docs.nerf.studio/quickstart/data_conventions.html (transforms.json: columns right,
//! up, back, eye of a 4 x 4 matrix from camera to world); docs.opencv.org, calib3d (x right, y down, z forward).

mod axes;
mod curve;
mod json;
mod keyed;
mod keys;
mod lens;
mod listed;
mod named;
mod table;
#[cfg(test)]
mod tests;

pub use axes::{AxesProblem, check_axes};
pub use curve::curve_of;
pub use lens::{ListedLens, PixelLens, lens_of};
pub use listed::ListedCamera;
pub use named::{LensName, LensProblem, NamedLens};

use halfline::error::{Error, Place, Result};
use halfline_particles::input::without_mark;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// The most bytes of a list.
const LONGEST: u64 = 1 << 28;

/// Reads a list of cameras: JSON, else a table.
///
/// # Errors
/// [`Error::Io`], [`Error::Scene`] with the camera and the field, [`Error::Limits`] for a file that is too long.
pub fn read(path: &Path) -> Result<Vec<ListedCamera>> {
    let mut bytes = Vec::new();
    let opened = File::open(path).and_then(|file| file.take(LONGEST + 1).read_to_end(&mut bytes));
    opened.map_err(|e| Error::read(path, e))?;
    if bytes.len() as u64 > LONGEST {
        let problem = format!("{}: the list of cameras has more than {LONGEST} bytes", path.display());
        return Err(Error::Limits { problem, mend: "split it into several files".into() });
    }
    of_bytes(&bytes, &path.display().to_string())
}

/// Reads a list of cameras from memory; errors refer to it by `name`.
///
/// # Errors
/// As [`read`].
pub fn of_bytes(bytes: &[u8], name: &str) -> Result<Vec<ListedCamera>> {
    let file = Place::file(name);
    let bytes = without_mark(bytes, &file)?;
    let cameras = match bytes.trim_ascii_start().first() {
        None => {
            let mend =
                "use JSON with a list of cameras, frames or poses, or CSV with a header such as eye_x,eye_y,eye_z,..";
            return Err(Error::scene(file, "the file is empty, not a list of cameras", mend));
        }
        Some(b'{' | b'[') => json::read(bytes, &file)?,
        _ => table::read(bytes, &file)?,
    };
    if cameras.is_empty() {
        return Err(Error::scene(file, "the list has no cameras", "add at least one"));
    }
    Ok(cameras)
}
