//! The request to a reader of particles: what it keeps and how it treats rows. Selection and style are not part of it.

use super::column_names::ColumnNames;
use super::survey::Survey;
#[cfg(test)]
use super::vectors;
use crate::formats::data::style::AtomStyle;
use crate::frame_range::FrameRange;
use halfline_ground::error::{Error, Result};
use halfline_ground::progress::Watch;
use std::str::FromStr;

/// The request to a reader. Each format uses the part that applies to it.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// The columns to keep, as far as the file has them; `EVERY` is all.
    pub columns: Vec<String>,
    /// The meaning of columns of a table whose names do not say it.
    pub columns_named: ColumnNames,
    /// The atom style of LAMMPS data; `None` takes the style of the file.
    pub atom_style: Option<AtomStyle>,
    /// Whether an item that is not a sphere is an error.
    pub strict: bool,
    /// Whether rows with invalid coordinates or radii are left out and counted.
    pub skip_invalid: bool,
    /// The frames that will be read.
    pub frames: FrameRange,
    /// The number of the model; `None` takes the first.
    pub model: Option<i64>,
    pub altloc: Altloc,
    /// The biological assembly to build.
    pub assembly: Option<String>,
    /// Whether it is kept as operators.
    pub as_operators: bool,
    /// Whether the symmetry of a crystal is not applied.
    pub as_listed: bool,
    /// The survey that counts the particles or passes them on in parts; `None` keeps them.
    pub survey: Option<Survey>,
    /// Cancellation.
    pub watch: Watch,
}

impl Request {
    /// Whether no model is selected.
    pub(crate) fn any_model(&self) -> bool {
        self.model.is_none() && self.frames == FrameRange::first()
    }
}

/// Selection of alternate locations of atoms.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Altloc {
    /// All alternate locations.
    #[default]
    All,
    /// Of each atom, the location with the highest occupancy, the first of equals.
    Highest,
    /// Locations with this identifier, and atoms with one location only.
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

#[cfg(test)]
impl Request {
    /// The request for these columns, for the readers' tests.
    pub(crate) fn of(columns: &[&str]) -> Self {
        let mut columns = columns.iter().map(|name| (*name).to_owned()).collect();
        vectors::request(&mut columns);
        Self { columns, ..Self::default() }
    }
}
