//! Errors, classified by who can correct them: scene author, caller or machine.

use crate::quote::setting::{ADAPTER, SIZE};
use crate::quote::{printable, shortened};
use std::fmt;
use std::path::{Path, PathBuf};

/// The underlying error, kept as the source of ours.
pub type Source = Box<dyn std::error::Error + Send + Sync>;

/// `Result` with halfline's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Every failure of the library. The variant says who can correct it: the author of the scene, the caller or the owner
/// of the machine. Messages name settings as [`quote::setting`](crate::quote::setting) has them.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The scene cannot be rendered as written: malformed text, a negative radius, a degenerate camera.
    #[error("{place}: {}; {}", printable(problem), printable(mend))]
    Scene {
        /// The place in the scene: file, line, column, field.
        place: Box<Place>,
        /// The problem at this place.
        problem: String,
        /// The remedy: a valid value or a correct spelling.
        mend: String,
        /// The parser's own error, if there was one.
        #[source]
        source: Option<Source>,
    },
    /// The settings name something that does not exist, or contradict each other.
    #[error("{}; {}", printable(problem), printable(mend))]
    Settings {
        /// The setting and its problem.
        problem: String,
        /// The remedy: a setting to change or to remove.
        mend: String,
    },
    /// No adapter fits the request.
    #[error("{}; {}", printable(problem), printable(mend))]
    Adapter {
        /// The request, and the adapters that were found.
        problem: String,
        /// The remedy: a driver to install or an adapter to select.
        mend: String,
    },
    /// The work does not fit the adapter or the memory.
    #[error("{}; {}", printable(problem), printable(mend))]
    Limits {
        /// The quantity that is too large, with the numbers.
        problem: String,
        /// The remedy, such as the largest size that fits.
        mend: String,
    },
    /// The device was lost during the work.
    #[error(
        "the device was lost: {}; try again, with a smaller {} or another {}",
        printable(.0),
        SIZE,
        ADAPTER
    )]
    DeviceLost(String),
    /// The promised accuracy cannot be reached here.
    #[error("{}; {}", printable(problem), printable(mend))]
    Accuracy {
        /// Which promise failed and why.
        problem: String,
        /// A setting that reaches it.
        mend: String,
    },
    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", printable(&path.display().to_string()))]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// Which file; `-` is standard input or output.
        path: PathBuf,
        /// The system's error.
        #[source]
        source: std::io::Error,
    },
    /// The caller cancelled the work.
    #[error("interrupted")]
    Interrupted,
}

impl Error {
    /// An error of the scene at `place`.
    pub fn scene(place: impl Into<Place>, problem: impl Into<String>, mend: impl Into<String>) -> Self {
        Self::Scene { place: Box::new(place.into()), problem: problem.into(), mend: mend.into(), source: None }
    }

    /// An error of the settings.
    pub fn settings(problem: impl Into<String>, mend: impl Into<String>) -> Self {
        Self::Settings { problem: problem.into(), mend: mend.into() }
    }

    /// A file that cannot be read. An [`Error`] that a reader wrapped in an [`std::io::Error`] is returned unchanged. Where the
    /// system read the bytes, but they end early or cannot be decoded, the content is at fault: [`Error::Scene`]; where they
    /// need more memory than there is or a decoder takes, [`Error::Limits`].
    pub fn read(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        use std::io::ErrorKind::{InvalidData, InvalidInput, OutOfMemory, UnexpectedEof};
        let source = match source.downcast::<Self>() {
            Ok(ours) => return ours,
            Err(source) => source,
        };
        let path = path.as_ref();
        let file = path.display();
        let is_of_system = source.raw_os_error().is_some();
        match source.kind() {
            InvalidData | InvalidInput | UnexpectedEof if !is_of_system => {
                Self::scene(Place::file(file.to_string()), source.to_string(), "get the file again")
            }
            OutOfMemory if !is_of_system => Self::Limits {
                problem: format!("{file}: {source}"),
                mend: "read a smaller file, or use a machine with more memory".into(),
            },
            _ => Self::Io { action: "read", path: path.to_path_buf(), source },
        }
    }

    /// A file that cannot be written.
    pub fn write(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { action: "write", path: path.as_ref().to_path_buf(), source }
    }
}

/// A place in a scene: file, line, column, field; each may be absent. Lines and columns count from 1.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// The file's name as the user gave it; `None` for a scene made in memory.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: Option<u64>,
    /// Column in characters, from 1.
    pub column: Option<u64>,
    /// The field, such as `camera.up` or `sphere 7 radius`.
    pub field: Option<String>,
}

impl Place {
    /// A place known by its field alone.
    pub fn field(field: impl Into<String>) -> Self {
        Self { field: Some(field.into()), ..Self::default() }
    }

    /// A place known by its file alone.
    pub fn file(file: impl Into<String>) -> Self {
        Self { file: Some(file.into()), ..Self::default() }
    }

    /// The same place with line and column.
    pub fn at(mut self, line: u64, column: u64) -> Self {
        (self.line, self.column) = (Some(line), Some(column));
        self
    }

    /// The same place at a byte offset of `text`, the content of the file. An offset past the end or within a character
    /// gives the end of the text.
    pub fn at_byte(self, text: &str, byte: usize) -> Self {
        let before = text.get(..byte).unwrap_or(text);
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.bytes().filter(|b| *b == b'\n').count() as u64 + 1;
        self.at(line, before[start..].chars().count() as u64 + 1)
    }

    /// The same place with the field's name.
    pub fn named(mut self, field: impl Into<String>) -> Self {
        self.field = Some(field.into());
        self
    }
}

impl From<&str> for Place {
    fn from(field: &str) -> Self {
        Self::field(field)
    }
}

/// The longest field name in a message, in characters; a file may name a column anything.
const MAX_FIELD_CHARS: usize = 80;

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&printable(self.file.as_deref().unwrap_or("scene")))?;
        for number in [self.line, self.column].into_iter().flatten() {
            write!(f, ":{number}")?;
        }
        match &self.field {
            Some(field) => write!(f, ": {}", shortened(field, MAX_FIELD_CHARS)),
            None => Ok(()),
        }
    }
}

/// The element of `all` with this name.
///
/// # Errors
/// [`Error::Settings`] with all names, if none is this.
pub fn by_name<T: Copy>(kind: &str, name: &str, all: &[T], of: impl Fn(T) -> &'static str) -> Result<T> {
    all.iter().copied().find(|x| of(*x) == name).ok_or_else(|| {
        let names: Vec<_> = all.iter().map(|x| of(*x)).collect();
        Error::settings(format!("there is no {kind} '{name}'"), format!("choose from {}", names.join(", ")))
    })
}

/// The list of a type's variants and their names on the command line; with `$kind`, which an unknown name is said to be none
/// of, also the variant of a name.
#[doc(hidden)]
#[macro_export]
macro_rules! named {
    ($type:ident, $kind:literal, $($variant:ident $name:literal)*) => {
        $crate::named! { $type, $($variant $name)* }

        impl std::str::FromStr for $type {
            type Err = $crate::error::Error;
            fn from_str(name: &str) -> $crate::error::Result<Self> {
                $crate::error::by_name($kind, name, &Self::ALL, Self::name)
            }
        }
    };
    ($type:ident, $($variant:ident $name:literal)*) => {
        impl $type {
            /// All of them.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name on the command line.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}
#[doc(hidden)]
pub use named;

/// Moves an error of a check that knows only the field to that field's place in the file.
pub fn relocate(error: Error, place: impl FnOnce(&str) -> Place) -> Error {
    match error {
        Error::Scene { place: old, problem, mend, source } => {
            let place = Box::new(place(old.field.as_deref().unwrap_or_default()));
            Error::Scene { place, problem, mend, source }
        }
        other => other,
    }
}
