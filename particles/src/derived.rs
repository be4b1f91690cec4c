//! Columns that are computed from all particles of a frame: neighbours within a distance, and the place of a residue in its chain.

mod spectrum;

use super::near::counts;
use super::particles::frame::{Column, Particles};
use super::particles::periodic::images::Images;
use super::particles::residues;
use glam::DVec3;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::check;
use halfline_ground::parallel;
use halfline_ground::quote::quote;
use halfline_ground::quote::setting::STREAM;
use std::f64::consts::PI;

/// A column that is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Derived {
    /// The number of other particles whose centres are at most this far away, in all images of a periodic cell.
    Coordination(f64),
    /// The particles within this distance, itself among them, over the volume of that ball.
    Density(f64),
    /// The place of the particle's residue in its chain.
    Spectrum,
    /// The distance from the mean of all positions.
    Distance,
}

/// The words of those with a distance, which follows a colon.
const COORDINATION: &str = "coordination";
const DENSITY: &str = "density";
const SPECTRUM: &str = "spectrum";
const DISTANCE: &str = "distance";

/// The most images of particles and cells that a distance reaches, which are looked at one by one: some ten seconds.
const MOST_IMAGES: u64 = 1 << 30;

impl Derived {
    /// The column that a name means; `None` for others.
    ///
    /// # Errors
    /// [`Error::Settings`] for a distance that is missing or not positive.
    fn of(name: &str) -> Result<Option<Self>> {
        let name = name.to_ascii_lowercase();
        let (word, distance) = name.split_once(':').map_or((&name[..], None), |(word, text)| (word, Some(text)));
        let column = match word {
            SPECTRUM if distance.is_none() => return Ok(Some(Self::Spectrum)),
            DISTANCE if distance.is_none() => return Ok(Some(Self::Distance)),
            COORDINATION => Self::Coordination,
            DENSITY => Self::Density,
            _ => return Ok(None),
        };
        let distance = distance.and_then(|text| text.parse().ok()).filter(|x: &f64| *x > 0.0 && x.is_finite());
        match distance {
            Some(distance) => Ok(Some(column(distance))),
            None => {
                let problem = format!("{} has no distance within which particles are neighbours", quote(&name));
                Err(Error::settings(problem, format!("give it behind a colon, such as {word}:3.5")))
            }
        }
    }

    fn values(self, particles: &Particles) -> Result<Vec<f64>> {
        Ok(match self {
            Self::Coordination(reach) => neighbors(particles, reach)?.into_iter().map(|count| count as f64).collect(),
            Self::Density(reach) => {
                let volume = 4.0 / 3.0 * PI * reach.powi(3);
                neighbors(particles, reach)?.into_iter().map(|count| (count + 1) as f64 / volume).collect()
            }
            Self::Spectrum => spectrum::places(particles)?,
            Self::Distance => distances(particles)?,
        })
    }
}

/// The distance of each particle from the mean of all positions.
fn distances(particles: &Particles) -> Result<Vec<f64>> {
    if !particles.placed.is_empty() {
        let problem = "distances from the middle need all copies of an assembly in memory";
        return Err(Error::settings(problem, "remove the column, or use an assembly that fits into memory"));
    }
    let positions = &particles.positions;
    let Some(first) = positions.first().copied().map(DVec3::from_array) else { return Ok(Vec::new()) };
    // Sums of differences, which keep their digits far from the origin.
    let away = |position: &[f64; 3]| DVec3::from_array(*position) - first;
    let middle = positions.iter().map(away).sum::<DVec3>() / positions.len() as f64;
    Ok(parallel::map(positions, |position| (away(position) - middle).length()))
}

/// The number of other particles within a distance of each.
fn neighbors(particles: &Particles, reach: f64) -> Result<Vec<u64>> {
    if !particles.placed.is_empty() {
        let problem = "neighbours need all copies of an assembly in memory";
        return Err(Error::settings(problem, "remove the column, or use an assembly that fits into memory"));
    }
    let images = Images::of(particles.cell.as_ref(), particles.open_edges, reach)?;
    let (count, cells) = (particles.positions.len() as u64, images.shifts.len() as u64);
    if count.saturating_mul(cells) > MOST_IMAGES {
        let problem = format!("the distance {reach} needs {cells} periodic cells around each of {count} particles");
        return Err(Error::settings(problem, "give a smaller one"));
    }
    let positions = images.wrapped(&particles.positions);
    counts(&positions, &images.shifts, reach)
}

/// Adds the columns that computed ones read.
pub(super) fn request(requested: &mut Vec<String>) {
    if requested.iter().any(|name| name.eq_ignore_ascii_case(SPECTRUM)) {
        requested.extend(residues::COLUMNS.iter().chain(&spectrum::COLUMNS).map(|name| (*name).to_owned()));
    }
}

/// Adds the computed columns among these names, unless the file has a column of the name.
///
/// # Errors
/// [`Error::Settings`] for a name without its distance, and for a file that lacks what a column is computed from;
/// [`Error::Limits`] where memory is short.
pub fn add(particles: &mut Particles, requested: &[String]) -> Result<()> {
    for name in requested {
        if particles.column(name).is_some() {
            continue;
        }
        if let Some(column) = Derived::of(name)? {
            check(8 * particles.positions.len() as u64, || format!("the column {name}"))?;
            let values = column.values(particles)?;
            particles.columns.push(Column { name: name.clone(), values });
        }
    }
    Ok(())
}

/// Returns an error for a computed column among these names, for particles that are a part of a frame.
///
/// # Errors
/// [`Error::Settings`].
pub fn refuse(part: &Particles, requested: &[String]) -> Result<()> {
    let is_computed = |name: &&String| part.column(name).is_none() && matches!(Derived::of(name), Ok(Some(_)));
    match requested.iter().find(is_computed) {
        None => Ok(()),
        Some(name) => {
            let problem = format!("{STREAM}: the column {} is computed from all particles in memory", quote(name));
            Err(Error::settings(problem, format!("use another column, or remove {STREAM}")))
        }
    }
}

#[cfg(test)]
mod tests;
