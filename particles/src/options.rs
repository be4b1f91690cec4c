//! The options for reading particles.

use crate::derived;
use crate::format::{Format, Has};
use crate::formats::data::style::AtomStyle;
use crate::frame_range::FrameRange;
use crate::opened::KnownFormat;
use crate::particles::column_names::ColumnNames;
use crate::particles::frame::Particles;
use crate::particles::identity::Identity;
use crate::particles::layout::EVERY;
use crate::particles::periodic::{self, Periodic};
use crate::particles::request::{Altloc, Request};
use crate::particles::survey::Survey;
use crate::particles::vectors;
use crate::select::candidates;
use crate::select::selection::Selection;
use halfline_ground::error::{Error, Result};
use halfline_ground::progress::Watch;
use std::path::PathBuf;

/// Options for reading particles.
#[derive(Debug, Clone, Default)]
pub struct ParticleOptions {
    /// Whether an item that is not a sphere is an error; otherwise it is counted in [`Skipped`](super::Skipped).
    pub strict: bool,
    /// The file's format; `None` detects it from the content, then from the name.
    pub format: Option<Format>,
    /// The meaning of columns of a table whose names do not say it.
    pub columns_named: ColumnNames,
    /// The atom style of LAMMPS data; `None` takes the style of the file, or one with its number of columns.
    pub atom_style: Option<AtomStyle>,
    /// Whether rows of tables, PTS, XYZ, LAMMPS dump, PLY, PCD, LAS, NPY and NPZ whose coordinates are not finite numbers or whose
    /// radius is not positive are left out and counted; otherwise the first is an error.
    pub skip_invalid: bool,
    /// The frames of a sequence that are read.
    pub frames: FrameRange,
    /// The particle file with the atoms of a trajectory, which gives the elements, radii, colours and columns that its frames
    /// lack: by the column of `identity` where both have it, by rows otherwise.
    pub topology: Option<PathBuf>,
    /// Further files of particles, whose frames go in step with the first file's; the column `file` names each particle's file. A file
    /// with one frame is in all of them.
    pub added: Vec<PathBuf>,
    /// The column that identifies particles, by which the frames of a sequence have the order of its first one.
    pub identity: Identity,
    /// The model number of a PDB or mmCIF file; `None` takes the first.
    pub model: Option<i64>,
    /// Selection of alternate locations.
    pub altloc: Altloc,
    /// The biological assembly to build with the file's operators; `None` takes the atoms as they are.
    pub assembly: Option<String>,
    /// Whether the assembly is kept as operators over its atoms ([`Particles::placed`](crate::Particles::placed)) and not
    /// multiplied out.
    pub as_operators: bool,
    /// Whether the atoms of a small-molecule CIF are taken as listed; otherwise its symmetry fills the cell.
    pub as_listed: bool,
    /// The treatment of the particles of a periodic cell, applied before selections.
    pub periodic: Periodic,
    /// The particles to take: those that one of these selects; all where the list is empty.
    pub select: Vec<Selection>,
    /// The particles to leave out: those that one of these selects.
    pub hide: Vec<Selection>,
    /// Columns that are kept besides, by their names.
    pub columns: Vec<String>,
    /// Selections that the caller evaluates on the frames: their columns are kept.
    pub others: Vec<Selection>,
    /// The columns that are kept, besides those that are named or selected by.
    pub keep: Keep,
    /// Counts the particles with all columns, or passes them on in parts, instead of keeping them.
    #[doc(hidden)]
    pub survey: Option<Survey>,
    /// Cancellation of the reading.
    pub watch: Watch,
}

impl ParticleOptions {
    /// All selections: to take, to hide, and of the caller.
    #[doc(hidden)]
    pub fn all_selections(&self) -> impl Iterator<Item = &Selection> {
        self.select.iter().chain(&self.hide).chain(&self.others)
    }

    /// The columns that the reader must keep, as far as the file has them: those that are named, and the components of
    /// vectors whose length they may be.
    #[doc(hidden)]
    #[must_use]
    pub fn kept_columns(&self) -> Vec<String> {
        let mut columns = self.named_columns();
        vectors::request(&mut columns);
        derived::request(&mut columns);
        if self.keep == Keep::All || self.survey.as_ref().is_some_and(Survey::is_counting) {
            columns.push(EVERY.to_owned());
        }
        columns
    }

    /// The columns that colours, selections, [`Periodic::Unwrap`] and the words of [`Keep::Named`] read.
    #[doc(hidden)]
    pub fn named_columns(&self) -> Vec<String> {
        let mut columns = self.columns.clone();
        let unwrapped = periodic::columns().filter(|_| self.periodic == Periodic::Unwrap).map(str::to_owned);
        let selected = self.all_selections().flat_map(Selection::columns);
        let words = if let Keep::Named(words) = &self.keep { &words[..] } else { &[] };
        let kept = words.iter().flat_map(|word| candidates(word));
        for name in unwrapped.chain(selected).chain(kept) {
            // A column that two words need is kept once.
            if !columns.iter().any(|known| known.eq_ignore_ascii_case(&name)) {
                columns.push(name);
            }
        }
        columns
    }

    /// Checks the number of columns that colours, selections and kept words read, for formats whose columns may have any
    /// name.
    ///
    /// # Errors
    /// [`Error::Settings`] for more than 64.
    pub(crate) fn check_columns(&self) -> Result<()> {
        const MOST_COLUMNS: usize = 64;
        let count = self.named_columns().len();
        if count > MOST_COLUMNS {
            let problem = format!("colours and selections read {count} columns, more than {MOST_COLUMNS}");
            return Err(Error::settings(problem, "use fewer columns"));
        }
        Ok(())
    }

    /// Moves the particles of a frame as the cell asks, and adds the columns that are computed from all of them. Selections are
    /// applied after that.
    ///
    /// # Errors
    /// [`Error::Settings`] for a cell or a column that the frame lacks, [`Error::Limits`] where memory is short.
    #[doc(hidden)]
    pub fn prepare(&self, particles: &mut Particles) -> Result<()> {
        let columns = self.named_columns();
        // The particles of several files were moved by their own cells.
        if self.added.is_empty() {
            periodic::apply(self.periodic, particles)?;
        }
        particles.add_lengths(&columns)?;
        derived::add(particles, &columns)
    }

    /// The columns whose values selections compare as words, by which a column of texts differs from one of numbers.
    #[doc(hidden)]
    pub fn worded_columns(&self) -> Vec<String> {
        self.all_selections().flat_map(Selection::worded_columns).collect()
    }

    /// The format of a file as far as the options say it.
    #[doc(hidden)]
    pub fn known_format(&self) -> KnownFormat {
        match self.format {
            Some(format) => KnownFormat::Given(format),
            None if self.columns_named.is_empty() => KnownFormat::Nothing,
            None => KnownFormat::IfNone(Format::CSV),
        }
    }

    /// The request to the reader of a file of this format. With [`Keep::Molecules`] it has all columns of PDB, PQR, PDBQT, mmCIF
    /// and GRO.
    #[doc(hidden)]
    pub fn request(&self, format: Format) -> Request {
        let all = self.keep == Keep::Molecules && format.has(Has::Serials);
        let mut columns = self.kept_columns();
        columns.extend(all.then(|| EVERY.to_owned()));
        columns.extend(self.identifying(format).map(str::to_owned));
        Request {
            columns,
            columns_named: self.columns_named.clone(),
            atom_style: self.atom_style.clone(),
            strict: self.strict,
            skip_invalid: self.skip_invalid,
            frames: self.frames.clone(),
            model: self.model,
            altloc: self.altloc.clone(),
            assembly: self.assembly.clone(),
            as_operators: self.as_operators,
            as_listed: self.as_listed,
            survey: self.survey.clone(),
            watch: self.watch.clone(),
        }
    }

    /// The column that identifies particles in files of this format; `None` where they are in the order of the rows anyway.
    pub(crate) fn identifying(&self, format: Format) -> Option<&str> {
        let is_alone = self.frames.last() == 1 && self.topology.is_none();
        let may_have = self.identity != Identity::Id || format.has(Has::Ids);
        self.identity.column().filter(|_| !is_alone && may_have && self.survey.is_none())
    }
}

/// The columns of particles that are kept.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Keep {
    /// None.
    #[default]
    Nothing,
    /// All of a molecule (PDB, PQR, PDBQT, mmCIF, GRO, and a trajectory with such a topology); of other files those that
    /// colours and selections read.
    Molecules,
    /// The columns that these words of selections read, and those that colours and selections read.
    Named(Vec<String>),
    /// All.
    All,
}
