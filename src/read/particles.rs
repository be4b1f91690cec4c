//! Particles from files of simulations, molecules and scans. A reader returns them frame by frame; the style turns them
//! into spheres.

mod assembly;
mod data;
mod dump;
mod frame;
mod gro;
mod infer;
mod layout;
mod masses;
mod mmcif;
mod molecule;
mod names;
mod npz;
mod pdb;
mod ply;
mod rows;
mod scalar;
mod survey;
mod table;
mod xyz;

pub(super) use frame::{Column, ParticleFrames, Particles};
pub(super) use infer::{ResidueClass, class, is_ion};
pub(super) use layout::{EVERY, Layout, Role, component, wanted};
pub(super) use scalar::Scalar;
pub use survey::Survey;
pub(super) use survey::{ColumnCounts, Counts};
pub(super) use table::{Table, axes, delimiter, fields, has_content};

use super::format::Format;
use super::options::ReadOptions;
use super::source::SceneSource;
use crate::error::Result;

/// The frames of a particle file; `None` for formats that contain a whole scene.
pub(super) fn open(source: SceneSource, options: &ReadOptions) -> Result<Result<Box<dyn ParticleFrames>, SceneSource>> {
    molecule::check(source.format, options)?;
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
        _ => return Ok(Err(source)),
    };
    Ok(Ok(frames))
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
    let scale = Scale { columns, map: Default::default(), range: None, log: false };
    let style = Style { coloring: Coloring::Column(scale), ..Style::default() };
    let mut frames = open(SceneSource::of_text(text), &ReadOptions { style, ..ReadOptions::default() })?;
    std::iter::from_fn(|| frames.next().transpose()).collect()
}
