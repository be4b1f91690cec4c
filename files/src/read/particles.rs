//! Particles from files of simulations, molecules and scans. A reader returns them frame by frame; the style turns them
//! into spheres.

mod assembly;
mod atom_property;
mod bytes;
mod data;
mod dump;
mod frame;
mod frame_time;
mod gro;
mod gsd;
mod infer;
mod las;
mod layout;
mod left_out;
mod masses;
mod mixed;
mod mmcif;
mod molecule;
mod names;
mod npz;
mod pcd;
mod pdb;
pub(super) mod periodic;
mod placed;
mod ply;
mod poscar;
mod rows;
mod survey;
mod table;
mod trajectory;
pub(super) mod vectors;
mod xyz;

pub(super) use frame::{Column, ParticleFrames, Particles};
pub use frame_time::FrameTime;
pub use infer::{NamedAtoms, NamedElements, elements_of_names};
pub(super) use infer::{ResidueClass, class, is_ion};
pub(super) use layout::{EVERY, Layout, Role, wanted};
pub use periodic::Periodic;
pub use survey::Survey;
pub(super) use survey::{ColumnCounts, Counts, Part};
pub(super) use table::{Table, axes, delimiter, fields, has_content};
pub(super) use vectors::component;

use super::format::Format;
use super::options::{FrameRange, ReadOptions};
use super::source::SceneSource;
use crate::error::{Error, Result};
use std::path::Path;
use trajectory::{Topology, Trajectory};

/// The frames of a particle file; `None` for formats that contain a whole scene.
pub(super) fn open(source: SceneSource, options: &ReadOptions) -> Result<Result<Box<dyn ParticleFrames>, SceneSource>> {
    if !options.columns_named.is_empty() && source.format != Format::Csv {
        let problem = format!("--columns names the columns of tables, but the file is {}", source.format.name());
        return Err(Error::settings(problem, "remove it, or add --format csv if the file is a table"));
    }
    let options = &*options.of_format(source.format);
    let trajectory = matches!(source.format, Format::Xtc | Format::Trr | Format::Dcd);
    let topology = match &options.topology {
        None => None,
        Some(path) if trajectory => Some(topology(path, &source.path, options)?),
        Some(_) => {
            let problem = format!("{} files contain their atoms and take no topology", source.format.name());
            return Err(Error::settings(problem, "remove --topology, or read a trajectory (xtc, trr, dcd)"));
        }
    };
    if topology.is_none() {
        molecule::check(source.format, options)?;
    }
    let frames: Box<dyn ParticleFrames> = match source.format {
        Format::Mmcif => Box::new(mmcif::Mmcif::new(source, options)),
        Format::Gro => Box::new(gro::Gro::new(source, options)),
        Format::Pdb | Format::Pqr | Format::Pdbqt => Box::new(pdb::Pdb::new(source, options)),
        Format::Xyz => Box::new(xyz::Xyz::new(source, options)?),
        Format::Dump => Box::new(dump::Dump::new(source, options)?),
        Format::Data => Box::new(data::LammpsData::new(source, options)?),
        Format::Ply => Box::new(ply::Ply::new(source, options)?),
        Format::Csv => Box::new(table::OneTable::new(source, options)?),
        Format::Npy => Box::new(super::npy::Array::new(source, options)?),
        Format::Npz => Box::new(npz::Npz::new(source, options)?),
        Format::Xtc | Format::Trr | Format::Dcd => Box::new(Trajectory::new(source, topology, options)),
        Format::Poscar => Box::new(poscar::Poscar::new(source, options)),
        Format::Pcd => Box::new(pcd::Pcd::new(source, options)?),
        Format::Las => Box::new(las::Las::new(source, options)?),
        Format::Gsd => Box::new(gsd::Gsd::new(source, options)),
        _ => return Ok(Err(source)),
    };
    Ok(Ok(frames))
}

/// The first frame of the file with the atoms of a trajectory.
fn topology(path: &Path, trajectory: &Path, options: &ReadOptions) -> Result<Topology> {
    let name = path.display();
    let unfit = |problem: String| {
        Err(Error::settings(problem, "use a particle file with the atoms of the trajectory, such as PDB or GRO"))
    };
    if path == Path::new("-") && trajectory == path {
        return unfit("the trajectory and its topology cannot both come from standard input".into());
    }
    let options =
        ReadOptions { topology: None, format: None, frames: FrameRange::first(), survey: None, ..options.clone() };
    let source = SceneSource::open(path, &options)?;
    if matches!(source.format, Format::Xtc | Format::Trr | Format::Dcd) {
        return unfit(format!("the topology {name} is a trajectory, which has positions only"));
    }
    match open(source, &options)? {
        Ok(mut frames) => match frames.next()? {
            Some(atoms) => Ok(Topology { path: path.to_path_buf(), atoms }),
            None => unfit(format!("the topology {name} has no atoms")),
        },
        Err(_) => unfit(format!("the topology {name} is a scene, not a particle file")),
    }
}

/// All frames of a text, for the readers' tests.
#[cfg(test)]
fn read_frames<F: ParticleFrames>(
    text: &str,
    columns: &[&str],
    open: impl Fn(SceneSource, &ReadOptions) -> Result<F>,
) -> Result<Vec<Particles>> {
    use super::style::{Coloring, Scale, Style};
    let columns = columns.iter().map(|name| (*name).to_owned()).collect();
    let scale = Scale::of(columns);
    let style = Style { coloring: Coloring::Column(scale), ..Style::default() };
    let mut frames = open(SceneSource::of_text(text), &ReadOptions { style, ..ReadOptions::default() })?;
    std::iter::from_fn(|| frames.next().transpose()).collect()
}
