//! Trajectories: positions of the same atoms, frame by frame, the periodic cell and velocities, without elements and names. A
//! topology gives these ([`Joined`](crate::particles::joined::Joined)).

mod dcd;
mod ints;
mod moment;
mod trr;
mod xdr;
mod xtc;

use crate::format::Format;
use crate::particles::bytes::BinaryFile;
use crate::particles::frame::{Column, ParticleFrames, Particles};
use crate::particles::layout::is_requested;
use crate::particles::request::Request;
use crate::source::SceneSource;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use halfline_ground::quote::setting::TOPOLOGY;
use moment::Moments;

/// The columns of velocities.
const VELOCITIES: [&str; 3] = ["vx", "vy", "vz"];

/// The reader.
pub(crate) struct Trajectory {
    moments: Box<dyn Moments>,
    /// Whether a topology gives the elements.
    has_topology: bool,
    /// The requested velocities.
    requested: Vec<usize>,
    /// Whether the assumptions were reported, which are the same for all frames.
    has_reported: bool,
}

impl Trajectory {
    pub(crate) fn new(source: SceneSource, has_topology: bool, request: &Request) -> Self {
        let requested: Vec<usize> = (0..3).filter(|k| is_requested(&request.columns, VELOCITIES[*k])).collect();
        let format = source.format;
        let binary = BinaryFile::new(source);
        let moments: Box<dyn Moments> = match format {
            Format::Trr => Box::new(trr::Trr::new(binary, !requested.is_empty())),
            Format::Dcd => Box::new(dcd::Dcd::new(binary)),
            _ => Box::new(xtc::Xtc::new(binary)),
        };
        Self { moments, has_topology, requested, has_reported: false }
    }
}

impl ParticleFrames for Trajectory {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(moment) = self.moments.next()? else { return Ok(None) };
        let mut particles = Particles::default();
        if !self.has_topology && !self.has_reported {
            particles.skipped.assumed.push(format!(
                "a trajectory has no elements; use {TOPOLOGY} FILE with a structure of the same atoms (PDB, GRO, ...) for \
                 elements, radii and names"
            ));
        }
        self.has_reported = true;
        if moment.has_velocities {
            particles.has.extend(VELOCITIES.map(str::to_owned));
        }
        if !moment.velocities.is_empty() {
            for k in &self.requested {
                check(8 * moment.velocities.len() as u64, || "the velocities".into())?;
                let values = moment.velocities.iter().map(|velocity| velocity[*k]).collect();
                particles.columns.push(Column { name: VELOCITIES[*k].to_owned(), values });
            }
        }
        (particles.positions, particles.cell, particles.when) = (moment.positions, moment.cell, moment.when);
        Ok(Some(particles))
    }

    fn skip(&mut self) -> Result<bool> {
        self.moments.skip()
    }
}

#[cfg(test)]
mod tests;
