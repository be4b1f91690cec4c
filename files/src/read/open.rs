//! Opens a file of particles with the reader of its format.

use super::format::Format;
use super::frame_range::FrameRange;
use super::npy::records;
use super::options::ReadOptions;
use super::particles::frame::{OneFrame, ParticleFrames, Particles};
use super::particles::table::Table;
use super::particles::trajectory::{Topology, Trajectory};
use super::particles::{data, dump, gro, gsd, las, mmcif, molecule, npz, pcd, pdb, ply, poscar, xyz};
use super::source::SceneSource;
use halfline::error::{Error, Result};
use halfline::quote::setting::{COLUMNS, FORMAT, TOPOLOGY};
use std::path::Path;

/// The frames of a particle file; `None` for formats that contain a whole scene.
pub(super) fn open(
    mut source: SceneSource,
    options: &ReadOptions,
) -> Result<Result<Box<dyn ParticleFrames>, SceneSource>> {
    if !options.columns_named.is_empty() && source.format != Format::Csv {
        let problem = format!("{COLUMNS} names the columns of tables, but the file is {}", source.format.name());
        return Err(Error::settings(problem, format!("remove it, or add {FORMAT} csv if the file is a table")));
    }
    let trajectory = matches!(source.format, Format::Xtc | Format::Trr | Format::Dcd);
    let request = options.request(source.format);
    let topology = match &options.topology {
        None => None,
        Some(path) if trajectory => Some(topology(path, &source.path, options)?),
        Some(_) => {
            let problem = format!("{} files contain their atoms and take no topology", source.format.name());
            return Err(Error::settings(problem, format!("remove {TOPOLOGY}, or read a trajectory (xtc, trr, dcd)")));
        }
    };
    if topology.is_none() {
        molecule::check(source.format, &request)?;
    }
    if has_any_columns(source.format) {
        options.check_columns()?;
    }
    let warning = source.warning.take();
    let frames: Box<dyn ParticleFrames> = match source.format {
        Format::Mmcif => Box::new(mmcif::Mmcif::new(source, request)),
        Format::Gro => Box::new(gro::Gro::new(source, request)),
        Format::Pdb | Format::Pqr | Format::Pdbqt => Box::new(pdb::Pdb::new(source, request)),
        Format::Xyz => Box::new(xyz::Xyz::new(source, request)),
        Format::Dump => Box::new(dump::Dump::new(source, request)),
        Format::Data => one(move || data::read(source, &request)),
        Format::Ply => one(move || ply::read(source, &request)),
        Format::Csv => {
            let table = Table::open(source, &request)?;
            one(move || table.all())
        }
        Format::Npy => Box::new(records::Array::new(source, request)),
        Format::Npz => Box::new(npz::Npz::new(source, request)),
        Format::Xtc | Format::Trr | Format::Dcd => Box::new(Trajectory::new(source, topology, &request)),
        Format::Poscar => one(move || poscar::read(source, &request)),
        Format::Pcd => one(move || pcd::read(source, &request)),
        Format::Las => one(move || las::read(source, &request)),
        Format::Gsd => Box::new(gsd::Gsd::new(source, request)),
        _ => return Ok(Err(SceneSource { warning, ..source })),
    };
    Ok(Ok(match warning {
        Some(_) => Box::new(Noted { frames, warning }),
        None => frames,
    }))
}

/// The frames of a file of which something is to be said, which the first that is read says.
struct Noted {
    frames: Box<dyn ParticleFrames>,
    warning: Option<String>,
}

impl ParticleFrames for Noted {
    fn next(&mut self) -> Result<Option<Particles>> {
        let mut frame = self.frames.next()?;
        if let Some(frame) = &mut frame {
            frame.skipped.assumed.extend(self.warning.take());
        }
        Ok(frame)
    }

    fn skip(&mut self) -> Result<bool> {
        self.frames.skip()
    }
}

/// The frames of a file that has one.
fn one(read: impl FnOnce() -> Result<Particles> + Send + 'static) -> Box<dyn ParticleFrames> {
    Box::new(OneFrame::new(read))
}

/// Whether files of this format have columns of any name.
fn has_any_columns(format: Format) -> bool {
    use Format::{Csv, Data, Dump, Las, Npy, Npz, Pcd, Ply, Xyz};
    matches!(format, Csv | Data | Dump | Las | Npy | Npz | Pcd | Ply | Xyz)
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
    let source = SceneSource::open(path, options.known_format(), &options.watch)?;
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
