//! Checks of numbers, for every reader and the command line.

use halfline_ground::error::{Error, Place, Result};

/// Largest number of columns or rows. 2j + 1 - W is exact in f32 far beyond it, and id buffers remain addressable.
/// Section 8 of docs/certificate.md.
pub const MAX_SIDE: i64 = 1 << 20;

/// Checks an image size (W, H), for every reader and the command line.
///
/// # Errors
/// [`Error::Scene`] at `place`.
pub fn check_size([width, height]: [i64; 2], place: impl FnOnce() -> Place) -> Result<(u32, u32)> {
    if [width, height].iter().all(|side| (1..=MAX_SIDE).contains(side)) {
        return Ok((width as u32, height as u32));
    }
    let problem = format!("an image cannot have {width} x {height} pixels");
    Err(Error::scene(place(), problem, format!("give two whole numbers between 1 and {MAX_SIDE}")))
}
