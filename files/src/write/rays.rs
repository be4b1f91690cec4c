//! Given rays as a NumPy array, in the form that [`crate::read::rays`] reads.

use super::atomic::write_atomically;
use halfline::error::{Error, Result};
use halfline::render::trace::Rays;
use halfline_particles::npy::header::Header;
use std::io;
use std::path::Path;

/// Writes rays to `path` as float64 of shape (count, 7), `ox oy oz dx dy dz tmax`, or (count, 6) without limits. `fill`
/// adds them block by block, `count` in all.
///
/// # Errors
/// Errors of `fill`, [`Error::Io`] naming the file, [`Error::Settings`] for another number of rays.
pub fn write(
    path: &Path,
    count: u64,
    limited: bool,
    fill: impl FnOnce(&mut dyn FnMut(&Rays<'_>) -> Result<()>) -> Result<()>,
) -> Result<()> {
    write_atomically(path, |out| {
        out.write_all(&Header::bytes("<f8", &[count, if limited { 7 } else { 6 }]))?;
        let mut written = 0;
        let mut add = |rays: &Rays<'_>| {
            let mut bytes = Vec::with_capacity(56 * rays.directions.len());
            for (n, direction) in rays.directions.iter().enumerate() {
                let origin = if rays.origins.len() == 1 { &rays.origins[0] } else { &rays.origins[n] };
                let limit = limited.then(|| rays.limits.get(n).unwrap_or(&f64::INFINITY));
                origin.iter().chain(direction).chain(limit).for_each(|x| bytes.extend(x.to_le_bytes()));
            }
            written += rays.directions.len() as u64;
            out.write_all(&bytes).map_err(|error| Error::write(path, error))
        };
        fill(&mut add).map_err(io::Error::other)?;
        if written == count {
            return Ok(());
        }
        let problem = format!("{written} rays were written instead of {count}");
        Err(io::Error::other(Error::settings(problem, "give the number of rays")))
    })
}
