//! Opens a file of particles with the reader of its format.

use super::format::Format;
#[cfg(feature = "formats")]
use super::formats::{data, gsd, las, mmcif, npz, pcd, poscar, ptx};
use super::formats::{dump, gro, pdb, ply, xyz};
use super::frame_range::FrameRange;
use super::npy::records;
use super::options::ParticleOptions;
use super::particles::frame::{OneFrame, ParticleFrames, Particles};
use super::particles::identity::{self, Ordered};
use super::particles::joined::{Joined, NUMBERS, Topology};
use super::particles::molecule;
use super::particles::request::Request;
use super::source::SceneSource;
use crate::formats::table::Table;
#[cfg(feature = "formats")]
use crate::formats::trajectory::Trajectory;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::setting::{ATOM_STYLE, COLUMNS, FORMAT, TOPOLOGY};
use std::path::Path;

/// The frames of a particle file, with the atoms of the topology and in the order of the first one; `None` for formats that
/// contain a whole scene.
pub fn open(source: SceneSource, options: &ParticleOptions) -> Result<Result<Box<dyn ParticleFrames>, SceneSource>> {
    let (path, format) = (source.path.clone(), source.format);
    let file = Place::file(path.display().to_string());
    let topology = options.topology.as_deref().map(|name| topology(name, &path, options)).transpose()?;
    let identity = options.identifying(format);
    let mut frames = match listed(source, options.request(format), options)? {
        Ok(frames) => frames,
        Err(source) if topology.is_some() => {
            let problem = format!("{} files contain whole scenes and take no topology", source.format.name());
            return Err(Error::settings(problem, format!("remove {TOPOLOGY}, or read a file of particles")));
        }
        Err(source) => return Ok(Err(source)),
    };
    if let Some(topology) = topology {
        frames = Box::new(Joined::new(frames, file.clone(), topology, identity, has_no_origin(format)));
    }
    if identity.is_some() {
        // The frames that are read have the order of one that is not.
        let first = if options.frames.contains(1) { None } else { first_ids(&path, options) };
        frames = Box::new(Ordered::new(frames, file, options.identity.clone(), first));
    }
    Ok(Ok(frames))
}

/// The numbers of the particles of the file's first frame; `None` where it cannot be read again, or has none.
fn first_ids(path: &Path, options: &ParticleOptions) -> Option<Vec<f64>> {
    if !path.is_file() {
        return None;
    }
    let column = options.identity.column()?;
    let source = SceneSource::open(path, options.known_format(), &options.watch).ok()?;
    let request = Request { columns: vec![column.to_owned()], ..options.request(source.format) };
    let frame = listed(source, request, options).ok()?.ok()?.next().ok()??;
    identity::numbers(&frame, column).map(<[f64]>::to_vec)
}

/// The frames of a particle file as it has them; `None` for formats that contain a whole scene.
pub fn listed(
    mut source: SceneSource,
    request: Request,
    options: &ParticleOptions,
) -> Result<Result<Box<dyn ParticleFrames>, SceneSource>> {
    if !options.columns_named.is_empty() && !matches!(source.format, Format::Csv | Format::Pts) {
        let problem = format!("{COLUMNS} names the columns of tables, but the file is {}", source.format.name());
        return Err(Error::settings(problem, format!("remove it, or add {FORMAT} csv if the file is a table")));
    }
    if options.atom_style.is_some() && options.topology.is_none() && source.format != Format::Data {
        let problem = format!("{ATOM_STYLE} is of LAMMPS data, but the file is {}", source.format.name());
        return Err(Error::settings(problem, "remove it"));
    }
    if options.topology.is_none() {
        molecule::check(source.format, &request)?;
    }
    if has_any_columns(source.format) {
        options.check_columns()?;
    }
    let warning = source.warning.take();
    let frames: Box<dyn ParticleFrames> = match source.format {
        Format::Gro => Box::new(gro::Gro::new(source, request)),
        Format::Pdb | Format::Pqr | Format::Pdbqt => Box::new(pdb::Pdb::new(source, request)),
        Format::Xyz => Box::new(xyz::Xyz::new(source, request)),
        Format::Dump => Box::new(dump::Dump::new(source, request)),
        Format::Ply => one(move || ply::read(source, &request)),
        Format::Csv => {
            let table = Table::open(source, &request)?;
            one(move || table.all())
        }
        Format::Pts => one(move || Table::points(source, &request)?.all()),
        Format::Npy => Box::new(records::Array::new(source, request)),
        Format::Native | Format::Nff => return Ok(Err(SceneSource { warning, ..source })),
        _ => other(source, request, options.topology.is_some())?,
    };
    Ok(Ok(match warning {
        Some(_) => Box::new(Noted { frames, warning }),
        None => frames,
    }))
}

/// The frames of a file in a format of the feature `formats`.
#[cfg(feature = "formats")]
#[expect(clippy::unnecessary_wraps, reason = "a build without these formats refuses")]
fn other(source: SceneSource, request: Request, has_topology: bool) -> Result<Box<dyn ParticleFrames>> {
    Ok(match source.format {
        Format::Data => one(move || data::read(source, &request)),
        Format::Gsd => Box::new(gsd::Gsd::new(source, request)),
        Format::Las => one(move || las::read(source, &request)),
        Format::Npz => Box::new(npz::Npz::new(source, request)),
        Format::Pcd => one(move || pcd::read(source, &request)),
        Format::Poscar => one(move || poscar::read(source, &request)),
        Format::Ptx => one(move || ptx::read(source, &request)),
        Format::Xtc | Format::Trr | Format::Dcd => Box::new(Trajectory::new(source, has_topology, &request)),
        _ => Box::new(mmcif::Mmcif::new(source, request)),
    })
}

#[cfg(not(feature = "formats"))]
fn other(source: SceneSource, _: Request, _: bool) -> Result<Box<dyn ParticleFrames>> {
    let file = Place::file(source.path.display().to_string());
    let problem = format!("this build of halfline does not read the format {}", source.format.name());
    Err(Error::scene(file, problem, crate::WHOLE))
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
    use Format::{Csv, Data, Dump, Las, Npy, Npz, Pcd, Ply, Pts, Ptx, Xyz};
    matches!(format, Csv | Data | Dump | Las | Npy | Npz | Pcd | Ply | Pts | Ptx | Xyz)
}

/// Whether files of this format have a cell and do not say where it begins, which is in the other files of their programs.
fn has_no_origin(format: Format) -> bool {
    matches!(format, Format::Xtc | Format::Trr | Format::Dcd)
}

/// Whether files of this format number their atoms in a column of its own name.
fn has_serials(format: Format) -> bool {
    matches!(format, Format::Pdb | Format::Pqr | Format::Pdbqt | Format::Mmcif | Format::Gro)
}

/// The first frame of the file with the atoms of a trajectory.
fn topology(path: &Path, trajectory: &Path, options: &ParticleOptions) -> Result<Topology> {
    let name = path.display();
    let unfit = |problem: String| {
        Err(Error::settings(problem, "use a particle file with the atoms of the trajectory, such as PDB or GRO"))
    };
    if path == Path::new("-") && trajectory == path {
        return unfit("the trajectory and its topology cannot both come from standard input".into());
    }
    let options =
        ParticleOptions { topology: None, format: None, frames: FrameRange::first(), survey: None, ..options.clone() };
    let source = SceneSource::open(path, options.known_format(), &options.watch)?;
    if matches!(source.format, Format::Xtc | Format::Trr | Format::Dcd) {
        return unfit(format!("the topology {name} is a trajectory, which has positions only"));
    }
    // Frames find its atoms by these.
    let mut request = options.request(source.format);
    if has_any_columns(source.format) {
        request.columns.extend(options.identity.column().into_iter().chain(NUMBERS).map(str::to_owned));
    } else if has_serials(source.format) {
        request.columns.push("serial".to_owned());
    }
    match listed(source, request, &options)? {
        Ok(mut frames) => match frames.next()? {
            Some(atoms) => Ok(Topology { path: path.to_path_buf(), atoms }),
            None => unfit(format!("the topology {name} has no atoms")),
        },
        Err(_) => unfit(format!("the topology {name} is a scene, not a particle file")),
    }
}
