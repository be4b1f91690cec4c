//! A format: a row with its name, its endings, its signs and its reader. The files of the readers have the rows, and `formats.rs` lists them.

use super::packed::WHOLE;
use super::particles::frame::{OneFrame, ParticleFrames, Particles};
use super::particles::request::Request;
use super::source::Source;
use halfline_ground::error::{Error, Place, Result};
use std::fmt::{self, Debug, Formatter};
use std::path::Path;

/// A format of files of particles, or of a scene.
#[derive(Clone, Copy)]
pub struct Format(pub(crate) &'static FormatRow);

/// All that the program knows of a format besides its reader.
pub(crate) struct FormatRow {
    /// The name, which is an ending of its files too.
    pub(crate) name: &'static str,
    /// Its files, as a phrase for lists of formats.
    pub(crate) about: &'static str,
    /// The file name extensions besides the name.
    pub(crate) endings: &'static [&'static str],
    /// The signs by which content is recognised.
    pub(crate) signs: &'static [Sign],
    /// Whether lines can be of the format where the name of the file says so; `None` for its signs of structure and in lines.
    pub(crate) fits: Option<LinesSign>,
    /// The warning about lines that are read as the name of the file says, and may be of another format.
    pub(crate) doubt: fn(&[&str]) -> Option<String>,
    /// The properties of its files.
    pub(crate) has: &'static [Has],
    /// Its reader.
    pub(crate) open: Open,
}

/// Whether the first lines of a file have a format.
pub(crate) type LinesSign = fn(&[&str]) -> bool;

/// A sign of a format, of the surest kind first.
#[derive(Clone, Copy)]
pub(crate) enum Sign {
    /// In the first bytes of a binary file.
    Bytes(fn(&[u8]) -> bool),
    /// In the lines behind a title, which may be any.
    Structure(LinesSign),
    /// In the first lines, which no other format has.
    Signature(LinesSign),
    /// In the first lines; the first format that fits is taken.
    Lines(LinesSign),
}

/// A property of the files of a format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Has {
    /// Atoms of molecules; trajectories have them with the elements of a topology.
    Molecules,
    /// Rows, one after the other, which are read in blocks.
    Blocks,
    /// Columns of any name.
    AnyColumns,
    /// Tables whose columns the caller may name.
    NamedColumns,
    /// A column `id` by which the particles of frames are ordered.
    Ids,
    /// Numbers of atoms in a column of their own name.
    Serials,
    /// Biological assemblies.
    Assemblies,
    /// Numbered models.
    Models,
    /// Alternate locations.
    AlternateLocations,
    /// The symmetry of crystals.
    Symmetry,
    /// The styles of atoms of LAMMPS.
    AtomStyles,
    /// Positions alone, and a cell without its origin: the other files of their programs have the rest.
    PositionsOnly,
}

/// The reader of a format.
#[derive(Clone, Copy)]
pub(crate) enum Open {
    /// None: a file is a whole scene.
    Scene,
    /// A reader of frames; the last argument says whether a topology has the elements.
    Frames(fn(Source, Request, bool) -> Result<Box<dyn ParticleFrames>>),
    /// A reader of the only frame.
    Frame(fn(Source, &Request) -> Result<Particles>),
    /// A reader that this build lacks.
    Lacking,
}

impl Open {
    /// A reader of the feature `formats`.
    pub(crate) const fn optional(self) -> Self {
        if cfg!(feature = "formats") { self } else { Self::Lacking }
    }
}

impl FormatRow {
    /// The properties that most formats have.
    pub(crate) const PLAIN: Self = Self {
        name: "",
        about: "",
        endings: &[],
        signs: &[],
        fits: None,
        doubt: |_| None,
        has: &[],
        open: Open::Scene,
    };

    /// Whether the first lines can be of the format where the name of the file says so.
    pub(crate) fn fits(&self, lines: &[&str]) -> bool {
        let by_signs = |sign: &Sign| matches!(sign, Sign::Structure(is_of) | Sign::Lines(is_of) if is_of(lines));
        self.fits.map_or_else(|| self.signs.iter().any(by_signs), |fits| fits(lines))
    }
}

impl Format {
    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.0.name
    }

    /// Its files, as a phrase for lists of formats.
    #[must_use]
    pub fn about(self) -> &'static str {
        self.0.about
    }

    /// The file name extensions in lower case.
    pub fn endings(self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.0.name).chain(self.0.endings.iter().copied())
    }

    /// Whether its files are of atoms of molecules; files of trajectories are, with the elements of a topology.
    #[must_use]
    pub fn is_of_molecules(self) -> bool {
        self.has(Has::Molecules)
    }

    /// Whether its files are read row by row, in blocks.
    #[must_use]
    pub fn is_in_blocks(self) -> bool {
        self.has(Has::Blocks)
    }

    /// Whether its files are whole scenes.
    #[must_use]
    pub fn is_of_scenes(self) -> bool {
        matches!(self.0.open, Open::Scene)
    }

    pub(crate) fn has(self, property: Has) -> bool {
        self.0.has.contains(&property)
    }

    /// The frames of a source of this format; the source itself for a scene.
    pub(crate) fn frames(
        self,
        source: Source,
        request: Request,
        has_topology: bool,
    ) -> Result<Result<Box<dyn ParticleFrames>, Source>> {
        match self.0.open {
            Open::Scene => Ok(Err(source)),
            Open::Frames(open) => open(source, request, has_topology).map(Ok),
            Open::Frame(read) => Ok(Ok(Box::new(OneFrame::new(move || read(source, &request))))),
            Open::Lacking => {
                let file = Place::file(source.path.display().to_string());
                let problem = format!("this build of halfline does not read the format {}", self.name());
                Err(Error::scene(file, problem, WHOLE))
            }
        }
    }
}

impl PartialEq for Format {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Format {}

impl Debug for Format {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The file name extension in lower case.
pub fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase()
}
