//! Trajectories: positions of the same atoms, frame by frame, without their elements and names. A topology, any particle
//! file with the same atoms, gives these; the trajectory gives positions, the periodic cell and velocities.

mod dcd;
mod ints;
mod moment;
mod trr;
mod xdr;
mod xtc;

use super::bytes::BinaryFile;
use super::frame::{Column, ParticleFrames, Particles};
use super::layout::is_requested;
use super::request::Request;
use crate::read::format::Format;
use crate::read::source::SceneSource;
use halfline::error::{Error, Place, Result};
use halfline::memory::check;
use halfline::quote::count;
use halfline::quote::setting::TOPOLOGY;
use moment::{Moment, Moments};
use std::path::PathBuf;

/// The columns of a trajectory that a topology may have too, where they belong to another frame.
const OWN: [&str; 18] =
    ["x", "y", "z", "xu", "yu", "zu", "xs", "ys", "zs", "xsu", "ysu", "zsu", "vx", "vy", "vz", "ix", "iy", "iz"];

/// The velocities among them.
const VELOCITIES: [&str; 3] = ["vx", "vy", "vz"];

/// The atoms of a trajectory: their elements, radii, names and columns.
pub(in crate::read) struct Topology {
    pub(in crate::read) path: PathBuf,
    pub(in crate::read) atoms: Particles,
}

/// The reader.
pub(in crate::read) struct Trajectory {
    moments: Box<dyn Moments>,
    file: Place,
    topology: Option<Topology>,
    /// The requested velocities.
    requested: Vec<usize>,
    /// Whether the assumptions were reported, which are the same for all frames.
    has_reported: bool,
}

impl Trajectory {
    pub(in crate::read) fn new(source: SceneSource, topology: Option<Topology>, request: &Request) -> Self {
        let requested: Vec<usize> = (0..3).filter(|k| is_requested(&request.columns, VELOCITIES[*k])).collect();
        let (format, file) = (source.format, Place::file(source.path.display().to_string()));
        let binary = BinaryFile::new(source);
        let moments: Box<dyn Moments> = match format {
            Format::Trr => Box::new(trr::Trr::new(binary, !requested.is_empty())),
            Format::Dcd => Box::new(dcd::Dcd::new(binary)),
            _ => Box::new(xtc::Xtc::new(binary)),
        };
        Self { moments, file, topology, requested, has_reported: false }
    }

    /// The atoms of a topology, at the positions of a frame.
    fn atoms(&self, topology: &Topology, moment: &mut Moment) -> Result<Particles> {
        let atoms = &topology.atoms;
        let (here, there) = (moment.positions.len(), atoms.positions.len());
        // The trajectory has the virtual sites that are left out of the topology.
        if here != there && atoms.listed == here && atoms.places.len() == there {
            let kept = |from: &[[f64; 3]]| atoms.places.iter().filter_map(|n| from.get(*n as usize)).copied().collect();
            (moment.positions, moment.velocities) = (kept(&moment.positions), kept(&moment.velocities));
        } else if here != there {
            let name = topology.path.display();
            let all =
                if atoms.listed > there { format!(" ({} with virtual sites)", atoms.listed) } else { String::new() };
            let problem =
                format!("the trajectory has {}, the topology {name} has {there}{all}", count(here as u64, "atom"));
            return Err(Error::scene(
                self.file.clone().named("number of atoms"),
                problem,
                format!("use the {TOPOLOGY} of the atoms that the trajectory was written for"),
            ));
        }
        let each = size_of::<[f64; 3]>() + 32 + atoms.columns.len() * size_of::<f64>();
        check((there * each) as u64, || format!("{there} atoms of a topology"))?;
        let mut particles = atoms.clone();
        particles.columns.retain(|column| !OWN.contains(&column.name.as_str()));
        particles.has.retain(|name| !OWN.contains(&name.as_str()));
        if self.has_reported {
            particles.skipped = Default::default();
        }
        Ok(particles)
    }
}

impl ParticleFrames for Trajectory {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(mut moment) = self.moments.next()? else { return Ok(None) };
        let mut particles = match &self.topology {
            Some(topology) => self.atoms(topology, &mut moment)?,
            None => Particles::default(),
        };
        if self.topology.is_none() && !self.has_reported {
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
