//! Trajectories: positions of the same atoms, frame by frame, the periodic cell and velocities, without elements and names. A
//! topology gives these ([`Joined`](crate::particles::joined::Joined)).

mod dcd;
mod ints;
mod moment;
mod netcdf;
mod trr;
mod xdr;
mod xtc;

use crate::format::{FormatRow, Has, Open, Sign};
use crate::particles::bytes::BinaryFile;
use crate::particles::frame::{Column, ParticleFrames, Particles};
use crate::particles::layout::is_requested;
use crate::particles::request::Request;
use crate::source::Source;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use halfline_ground::quote::setting::TOPOLOGY;
use moment::Moments;

/// A trajectory in this format.
const fn row(name: &'static str, about: &'static str, signs: &'static [Sign], moments: MomentsOf) -> FormatRow {
    let has = &[Has::Molecules, Has::PositionsOnly];
    FormatRow { name, about, signs, has, open: Open::Frames(moments).optional(), ..FormatRow::PLAIN }
}

/// The reader of a format of trajectories.
type MomentsOf = fn(Source, Request, bool) -> Result<Box<dyn ParticleFrames>>;

pub(crate) const XTC: FormatRow = row(
    "xtc",
    "GROMACS trajectory, compressed",
    &[Sign::Bytes(|bytes| matches!(bytes, [0, 0, 7, 0xcb | 0xe7, ..]))],
    |source, request, has_topology| {
        let moments = Box::new(xtc::Xtc::new(BinaryFile::new(source)));
        Ok(Box::new(Trajectory::new(moments, has_topology, requested(&request))))
    },
);

pub(crate) const TRR: FormatRow = row(
    "trr",
    "GROMACS trajectory in full precision",
    &[Sign::Bytes(|bytes| bytes.starts_with(&[0, 0, 7, 0xc9]))],
    |source, request, has_topology| {
        let requested = requested(&request);
        let moments = Box::new(trr::Trr::new(BinaryFile::new(source), !requested.is_empty()));
        Ok(Box::new(Trajectory::new(moments, has_topology, requested)))
    },
);

pub(crate) const DCD: FormatRow = row(
    "dcd",
    "trajectory of CHARMM, NAMD, X-PLOR and LAMMPS",
    &[Sign::Bytes(is_dcd)],
    |source, request, has_topology| {
        let moments = Box::new(dcd::Dcd::new(BinaryFile::new(source)));
        Ok(Box::new(Trajectory::new(moments, has_topology, requested(&request))))
    },
);

pub(crate) const NC: FormatRow = FormatRow {
    endings: &["ncdf", "ncrst", "netcdf"],
    ..row(
        "nc",
        "trajectory or restart file of AMBER, in NetCDF",
        &[Sign::Bytes(|bytes| matches!(bytes, [b'C', b'D', b'F', 1 | 2 | 5, ..]))],
        |source, request, has_topology| {
            let requested = requested(&request);
            let moments = Box::new(netcdf::NetCdf::new(BinaryFile::new(source), !requested.is_empty()));
            Ok(Box::new(Trajectory::new(moments, has_topology, requested)))
        },
    )
};

/// The requested velocities.
fn requested(request: &Request) -> Vec<usize> {
    (0..3).filter(|k| is_requested(&request.columns, VELOCITIES[*k])).collect()
}

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
    fn new(moments: Box<dyn Moments>, has_topology: bool, requested: Vec<usize>) -> Self {
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

/// The length of the first record, 84 bytes in 4 or 8 of either order, and its kind.
fn is_dcd(bytes: &[u8]) -> bool {
    let kind = match bytes {
        [84, 0, 0, 0, 0, 0, 0, 0, kind @ ..] | [0, 0, 0, 0, 0, 0, 0, 84, kind @ ..] => kind,
        [84, 0, 0, 0, kind @ ..] | [0, 0, 0, 84, kind @ ..] => kind,
        _ => return false,
    };
    kind.starts_with(b"CORD") || kind.starts_with(b"VELD")
}

#[cfg(test)]
mod tests;
