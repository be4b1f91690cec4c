//! The file of a drawn legend: SVG or PNG by the extension of its name.

use super::file::write_atomically;
use super::png;
use halfline::error::{Error, Result};
use std::path::Path;

/// Whether a file name has this extension.
fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Whether the file is a PNG, in which letters are pixels.
#[must_use]
pub fn is_png(path: &Path) -> bool {
    ends_in(path, "png")
}

/// Checks that the name of a file is one of a legend, for use before the work begins.
///
/// # Errors
/// [`Error::Settings`] for an extension other than .svg and .png.
pub fn check(path: &Path) -> Result<()> {
    if !is_png(path) && !ends_in(path, "svg") {
        let problem = format!("a legend cannot be written to {}", path.display());
        return Err(Error::settings(problem, "use the file name extension .svg or .png"));
    }
    Ok(())
}

/// Writes a drawing, as SVG and as rows of sRGB levels, to a file in the format of its extension, completely or not at all.
///
/// # Errors
/// [`Error::Io`] naming the file.
pub fn write(path: &Path, svg: &str, size: [usize; 2], levels: &[u8]) -> Result<()> {
    if !is_png(path) {
        return write_atomically(path, |out| out.write_all(svg.as_bytes()));
    }
    let bytes = png::of_levels(size, levels).map_err(|error| Error::write(path, error))?;
    write_atomically(path, |out| out.write_all(&bytes))
}
