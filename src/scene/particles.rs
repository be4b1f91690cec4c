//! Particles from files of simulations, molecules and scans. A reader returns them frame by frame; the style turns them
//! into spheres.

mod assembly;
mod data;
mod dump;
mod gro;
mod infer;
mod layout;
mod masses;
mod mmcif;
mod molecule;
mod npz;
mod pdb;
mod ply;
mod rows;
mod scalar;
mod table;
mod xyz;

pub(super) use layout::{Layout, Role, component, wanted};
pub(super) use scalar::Scalar;
pub(super) use table::{Table, axes};

use super::source::{Format, SceneSource};
use super::{ReadOptions, Skipped};
use crate::error::{Error, Result};
use crate::memory::{entries, extend_to};
use infer::{Inference, Inferred, Species};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// One frame of particles, as the file has them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Particles {
    /// Positions in the file's unit; nanometres of GROMACS are converted to ångström.
    pub(crate) positions: Vec<[f64; 3]>,
    /// Radii in the same unit; empty if the file has none, NaN for a particle without one.
    pub(crate) radii: Vec<f64>,
    /// Atomic numbers, 0 for an unknown element; empty where the format has no elements.
    pub(crate) elements: Vec<u8>,
    /// Linear RGB; empty if the file has no colours.
    pub(crate) colors: Vec<[f32; 3]>,
    /// The columns of [`ReadOptions::columns`] that the file has, in that order, with a number for every particle.
    /// Names of columns in files are converted to lower case.
    pub(crate) columns: Vec<Column>,
    /// The names of all numeric columns of the file, for messages.
    pub(crate) has: Vec<String>,
    /// For columns of names: the column's name, and the names that its whole numbers, from 0, refer to.
    pub(crate) labels: BTreeMap<String, Vec<String>>,
    /// The periodic cell, if the file has one.
    pub(crate) cell: Option<Cell>,
    /// Names that are not elements, with the number of their particles.
    pub(crate) unknown: BTreeMap<String, u64>,
    /// The other content of a column of symbols, while it is read.
    pub(super) species: Species,
    /// Skipped records and assumptions.
    pub(crate) skipped: Skipped,
    /// The number of particles for which all lists have capacity.
    pub(super) room: usize,
}

/// A column of numbers, one per particle.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) values: Vec<f64>,
}

/// A periodic cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// A corner.
    pub origin: [f64; 3],
    /// The three edges from that corner.
    pub edges: [[f64; 3]; 3],
}

impl Cell {
    /// The point at these fractions of the edges.
    fn place(&self, parts: [f64; 3]) -> [f64; 3] {
        let along = |k: usize| (0..3).map(|edge| parts[edge] * self.edges[edge][k]).sum::<f64>();
        [0, 1, 2].map(|k| self.origin[k] + along(k))
    }
}

impl Particles {
    /// Counts particles with a name that is not an element. The number of different names is limited.
    pub(crate) fn meet_unknown(&mut self, name: &str, count: u64) {
        let keep = self.unknown.len() < 16 || self.unknown.contains_key(name);
        self.count_unknown(if keep { name } else { "others" }, count);
    }

    /// The same for a part of a file, which is small enough to keep all names.
    fn count_unknown(&mut self, name: &str, count: u64) {
        match self.unknown.get_mut(name) {
            Some(known) => *known += count,
            None => drop(self.unknown.insert(name.to_owned(), count)),
        }
    }

    /// Appends the particles of a part with the same columns.
    ///
    /// # Errors
    /// Those of [`Particles::grow`].
    fn append(&mut self, mut more: Self) -> Result<()> {
        self.grow(more.positions.len(), 0)?;
        self.positions.append(&mut more.positions);
        self.radii.append(&mut more.radii);
        self.elements.append(&mut more.elements);
        self.colors.append(&mut more.colors);
        for (column, more) in self.columns.iter_mut().zip(&mut more.columns) {
            column.values.append(&mut more.values);
        }
        more.unknown.iter().for_each(|(name, count)| self.meet_unknown(name, *count));
        self.species.add(more.species);
        Ok(())
    }

    /// Finishes a column of symbols: finds the elements of names, and removes virtual sites.
    fn settle_species(&mut self) {
        let (said, sites) = std::mem::take(&mut self.species).settle(&mut self.elements);
        self.skipped.assumed.extend(said);
        self.leave_sites_out(sites);
    }

    fn leave_sites_out(&mut self, there: bool) {
        if there {
            let stays: Vec<bool> = self.elements.iter().map(|code| !infer::is_site(*code)).collect();
            self.keep(&stays);
        }
    }

    /// Finishes an inference: removes virtual sites and returns what to report.
    fn infer(&mut self, inference: Inference) -> Vec<String> {
        let read = self.elements.len() as u64;
        let inferred = inference.finish(&mut self.elements);
        self.leave_sites_out(inferred.sites() > 0);
        let said = inferred.sentences(read);
        self.count_unknown_atoms(inferred);
        said
    }

    /// Counts unknown atoms by the names that an inference numbered, and sets their atomic number to 0.
    fn count_unknown_atoms(&mut self, inferred: Inferred) {
        let mut counts = vec![0; inferred.names.len()];
        for element in &mut self.elements {
            if let Some(slot) = infer::unknown(*element) {
                counts[slot] += 1;
                *element = 0;
            }
        }
        self.unknown = inferred.names.into_iter().zip(counts).filter(|(_, count)| *count > 0).collect();
    }

    /// Keeps the particles whose flag is set.
    fn keep(&mut self, stays: &[bool]) {
        keep(&mut self.positions, stays);
        keep(&mut self.radii, stays);
        keep(&mut self.elements, stays);
        keep(&mut self.colors, stays);
        self.columns.iter_mut().for_each(|column| keep(&mut column.values, stays));
    }

    /// Reserves capacity for `more` particles in every list, counting `beside` bytes per particle that the reader
    /// keeps: an endless file must not fill the memory.
    ///
    /// # Errors
    /// [`Error::Limits`].
    pub(crate) fn grow(&mut self, more: usize, beside: usize) -> Result<()> {
        let n = self.positions.len();
        if n + more <= self.room {
            return Ok(());
        }
        let columns = self.columns.len() * size_of::<f64>();
        // A list that is empty after the first particle stays empty.
        let of = |is_empty: bool, bytes: usize| if is_empty { 0 } else { bytes };
        let [radius, element, color] =
            [of(self.radii.is_empty(), 8), of(self.elements.is_empty(), 1), of(self.colors.is_empty(), 12)];
        let room = entries(n, more, size_of::<[f64; 3]>() + radius + element + color + columns + beside, "spheres")?;
        extend_to(&mut self.positions, room)?;
        if radius > 0 {
            extend_to(&mut self.radii, room)?;
        }
        if element > 0 {
            extend_to(&mut self.elements, room)?;
        }
        if color > 0 {
            extend_to(&mut self.colors, room)?;
        }
        for column in &mut self.columns {
            extend_to(&mut column.values, room)?;
        }
        self.room = room;
        Ok(())
    }
}

/// Keeps the values whose flag is set; an empty list stays empty.
fn keep<T>(values: &mut Vec<T>, stays: &[bool]) {
    let mut flags = stays.iter();
    values.retain(|_| flags.next().copied().unwrap_or(true));
}

/// A file of particles, frame by frame.
pub(crate) trait ParticleFrames: Send {
    /// The next frame; `None` after the last.
    ///
    /// # Errors
    /// [`Error::Scene`] with line and column, [`Error::Io`].
    fn next(&mut self) -> Result<Option<Particles>>;

    /// Skips the next frame; returns `false` after the last.
    ///
    /// # Errors
    /// As [`ParticleFrames::next`].
    fn skip(&mut self) -> Result<bool> {
        Ok(self.next()?.is_some())
    }
}

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

/// Selection of alternate locations of atoms.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Altloc {
    /// All alternate locations.
    #[default]
    All,
    /// The one with the highest occupancy, the first of equals.
    Highest,
    /// Those with this identifier, and atoms without one.
    Named(String),
}

impl FromStr for Altloc {
    type Err = Error;
    /// `all`, `highest`, or a name such as `A`.
    fn from_str(text: &str) -> Result<Self> {
        match text {
            "all" => Ok(Self::All),
            "highest" => Ok(Self::Highest),
            "" => Err(Error::settings(
                "the identifier of the alternate location is empty",
                "use all, highest or an identifier such as A",
            )),
            name => Ok(Self::Named(name.to_owned())),
        }
    }
}

/// ParticleFrames of a sequence, counted from 1: `2`, `1-10`, `1-3,5,7-20:2`, `5-` to the last.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameRange(Vec<(RangeInclusive<u64>, u64)>);

impl FrameRange {
    /// The first frame only.
    #[must_use]
    pub fn first() -> Self {
        Self(vec![(1..=1, 1)])
    }

    /// Whether frame `number` is selected.
    #[must_use]
    pub fn contains(&self, number: u64) -> bool {
        self.0.iter().any(|(range, step)| range.contains(&number) && (number - range.start()).is_multiple_of(*step))
    }

    /// The most frames that can be selected; frames in several ranges count for each.
    #[must_use]
    pub fn count(&self) -> u64 {
        let each = |(range, step): &(RangeInclusive<u64>, u64)| (range.end() - range.start()) / step + 1;
        self.0.iter().map(each).fold(0, u64::saturating_add)
    }

    /// The frame numbers, range by range.
    pub fn numbers(&self) -> impl Iterator<Item = u64> + Clone + '_ {
        // `step_by` takes a usize; a longer step than that ends any range.
        let step = |step: u64| usize::try_from(step).unwrap_or(usize::MAX);
        self.0.iter().flat_map(move |(range, by)| range.clone().step_by(step(*by)))
    }

    /// The number of the last frame, [`u64::MAX`] for an open end.
    #[must_use]
    pub fn last(&self) -> u64 {
        self.0.iter().map(|(range, _)| *range.end()).max().unwrap_or(1)
    }
}

impl Default for FrameRange {
    fn default() -> Self {
        Self::first()
    }
}

impl FromStr for FrameRange {
    type Err = Error;
    fn from_str(text: &str) -> Result<Self> {
        let part = |part: &str| {
            let (range, step) = part.split_once(':').unwrap_or((part, "1"));
            let (first, last) = match range.split_once('-') {
                Some((first, "")) => (first.parse().ok()?, u64::MAX),
                Some((first, last)) => (first.parse().ok()?, last.parse().ok()?),
                None => (range.parse().ok()?, range.parse().ok()?),
            };
            let step: u64 = step.parse().ok()?;
            (first >= 1 && first <= last && step >= 1).then_some((first..=last, step))
        };
        text.split(',').map(|text| part(text.trim())).collect::<Option<_>>().map(Self).ok_or_else(|| {
            let problem = format!("`{text}` is not a selection of frames");
            Error::settings(problem, "use numbers from 1: 2, 1-10, 1-3,5,7-20:2, or 5- to the last")
        })
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
    let scale = Scale { columns, map: Default::default(), range: None, log: false };
    let style = Style { coloring: Coloring::Column(scale), ..Style::default() };
    let mut frames = open(SceneSource::of_text(text), &ReadOptions { style, ..ReadOptions::default() })?;
    std::iter::from_fn(|| frames.next().transpose()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_named_by_ranges() {
        let frames = |text: &str| -> Vec<u64> {
            let range: FrameRange = text.parse().expect("frames");
            (1..=12).filter(|n| range.contains(*n)).collect()
        };
        assert_eq!(frames("2"), [2]);
        assert_eq!(frames("1-3,5,7-12:2"), [1, 2, 3, 5, 7, 9, 11]);
        assert_eq!(frames("10-"), [10, 11, 12]);
        assert_eq!("3-4,2".parse::<FrameRange>().expect("frames").last(), 4);
        for bad in ["", "0", "0-3", "3-2", "1:0", "a", "1-2-3", "1,,2"] {
            bad.parse::<FrameRange>().expect_err(bad);
        }
    }
}
