//! The options for reading a scene.

mod named;

use super::format::Format;
use super::particles::{EVERY, Periodic, Survey, periodic, vectors};
use super::select::candidates;
use super::select::selection::Selection;
use super::style::Style;
use crate::error::{Error, Result};
use crate::progress::Watch;
use std::borrow::Cow;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

pub use named::ColumnNames;

/// Options for reading a scene.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// Whether an item that is not a sphere is an error; otherwise it is counted in [`crate::scene::Skipped`].
    pub strict: bool,
    /// The file's format; `None` detects it from the content, then from the name.
    pub format: Option<Format>,
    /// The meaning of columns of a table whose names do not say it.
    pub columns_named: ColumnNames,
    /// Whether rows of tables, XYZ, LAMMPS dump and PLY text whose coordinates are not finite numbers or whose radius is
    /// not positive are left out and counted; otherwise the first is an error.
    pub skip_invalid: bool,
    /// The frames of a sequence that are read.
    pub frames: FrameRange,
    /// What the frames of a sequence have in common.
    pub hold: Hold,
    /// The particle file with the atoms of a trajectory, which gives their elements, radii and columns.
    pub topology: Option<PathBuf>,
    /// The model number of a PDB or mmCIF file; `None` takes the first.
    pub model: Option<i64>,
    /// Selection of alternate locations.
    pub altloc: Altloc,
    /// The biological assembly to build with the file's operators; `None` takes the atoms as they are.
    pub assembly: Option<String>,
    /// Whether the assembly is kept as operators over its atoms ([`SceneFrame::instances`](crate::read::SceneFrame::instances)) and not
    /// multiplied out. Selections, and colours by coordinates, then are errors.
    pub as_operators: bool,
    /// Whether the atoms of a small-molecule CIF are taken as listed; otherwise its symmetry fills the cell.
    pub as_listed: bool,
    /// What is done about the particles of a periodic cell, before they are selected.
    pub periodic: Periodic,
    /// The particles to take: those that one of these selects; all where the list is empty.
    pub select: Vec<Selection>,
    /// The particles to leave out: those that one of these selects.
    pub hide: Vec<Selection>,
    /// Particles that the caller wants to know, such as those that a camera looks at:
    /// [`SceneFrame::marks`](crate::read::SceneFrame::marks).
    pub marks: Vec<Selection>,
    /// The style of the particles.
    pub style: Style,
    /// The columns that the scene keeps ([`SceneFrame::columns`](crate::read::SceneFrame::columns)).
    pub keep: Keep,
    /// Counts the particles with all columns, or passes them on in parts, instead of keeping them; see
    /// [`info`](fn@crate::read::info) and [`SphereBlocks`](crate::read::SphereBlocks).
    pub survey: Option<Survey>,
    /// Cancellation of the reading.
    pub watch: Watch,
}

impl ReadOptions {
    /// Whether an expression selects particles.
    pub(super) fn selects(&self) -> bool {
        let all = self.select.iter().chain(&self.hide).chain(&self.marks).chain(self.style.selections());
        all.count() > 0
    }

    /// The columns that the reader must keep, as far as the file has them: those that are named, and the components of
    /// velocities.
    #[must_use]
    pub fn columns(&self) -> Vec<String> {
        let mut columns = self.named_columns();
        vectors::request(&mut columns);
        columns
    }

    /// The columns that colours, selections and molecules name.
    pub(super) fn named_columns(&self) -> Vec<String> {
        if self.survey.as_ref().is_some_and(Survey::is_counting) {
            return vec![EVERY.to_owned()];
        }
        if self.keep == Keep::All {
            return vec![EVERY.to_owned()];
        }
        let mut columns: Vec<String> = self.style.columns().to_vec();
        if self.periodic == Periodic::Unwrap {
            let more = periodic::columns().filter(|name| !columns.iter().any(|known| known.eq_ignore_ascii_case(name)));
            columns.extend(more.map(str::to_owned).collect::<Vec<_>>());
        }
        for selection in self.select.iter().chain(&self.hide).chain(&self.marks).chain(self.style.selections()) {
            columns.extend(
                selection
                    .columns()
                    .into_iter()
                    .filter(|name| {
                        // A column that two words need is kept once.
                        !columns.iter().any(|known| known.eq_ignore_ascii_case(name))
                    })
                    .collect::<Vec<_>>(),
            );
        }
        if let Keep::Named(words) = &self.keep {
            for name in words.iter().flat_map(|word| candidates(word)) {
                if !columns.iter().any(|known| known.eq_ignore_ascii_case(&name)) {
                    columns.push(name);
                }
            }
        }
        columns
    }

    /// The options for a file of this format: of molecules all columns are kept.
    pub(super) fn of_format(&self, format: Format) -> Cow<'_, Self> {
        use Format::{Gro, Mmcif, Pdb, Pdbqt, Pqr};
        match self.keep == Keep::Molecules && matches!(format, Pdb | Pqr | Pdbqt | Mmcif | Gro) {
            true => Cow::Owned(Self { keep: Keep::All, ..self.clone() }),
            false => Cow::Borrowed(self),
        }
    }
}

/// The columns of particles that a scene keeps.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Keep {
    /// None.
    #[default]
    Nothing,
    /// All of a molecule (PDB, PQR, PDBQT, mmCIF, GRO, and a trajectory with such a topology); of other files those that
    /// colours and selections read.
    Molecules,
    /// Those that these words of selections read, and those that colours and selections read.
    Named(Vec<String>),
    /// All.
    All,
}

/// Where default radii and ranges of colours come from, so that the frames of a film do not flicker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hold {
    /// From the first frame of the file, whether it is selected or not: a frame read alone is the same as in a film.
    #[default]
    First,
    /// The camera and the range of colours from all frames, which the caller has read before; see
    /// [`Scale::range`](crate::read::style::Scale::range). The radius and the colours of names from the first.
    All,
    /// From each frame by itself.
    None,
}

impl Hold {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::First, Self::All, Self::None];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::First => "first",
            Self::All => "all",
            Self::None => "none",
        }
    }
}

impl FromStr for Hold {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        crate::error::by_name("hold", name, Self::ALL, Self::name)
    }
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

/// Frames of a sequence, counted from 1: `2`, `1-10`, `1-3,5,7-20:2`, `5-` to the last.
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
