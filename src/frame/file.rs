//! Where a buffer goes: the format by the file's ending, `-` for standard output, and files that are either whole
//! or not there.

use super::{Aov, Buffer, npy, png};
use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// What a buffer can be written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Format {
    /// Colour as 8-bit sRGB.
    Png,
    /// Any buffer, as it is.
    Npy,
}

impl Format {
    const ALL: [Self; 2] = [Self::Png, Self::Npy];

    /// The ending that chooses it.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => ".png",
            Self::Npy => ".npy",
        }
    }

    /// Whether a buffer can be written in it.
    pub fn takes(self, aov: Aov) -> bool {
        self == Self::Npy || aov == Aov::Color
    }

    /// The format that `path` ends in, in capitals or not.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        Self::ALL.into_iter().find(|format| format.ending()[1..].eq_ignore_ascii_case(ending))
    }
}

/// One buffer and the file it goes to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    aov: Aov,
    format: Format,
    path: PathBuf,
}

impl Target {
    /// The buffer `aov` at `path`. On standard output (`-`) colour is PNG, everything else .npy.
    ///
    /// # Errors
    /// [`Error::Settings`] naming the file, if its ending names no format that takes this buffer.
    pub fn new(aov: Aov, path: &Path) -> Result<Self> {
        // The first format that takes a buffer is its customary one.
        let mut fitting = Format::ALL.into_iter().filter(|format| format.takes(aov));
        let format =
            if is_standard(path) { fitting.next() } else { Format::of(path).filter(|format| format.takes(aov)) };
        let target = format.map(|format| Self { aov, format, path: path.to_path_buf() });
        target.ok_or_else(|| {
            let endings = fitting.map(Format::ending).collect::<Vec<_>>().join(" or ");
            let problem = format!("{} cannot hold the {aov} buffer", path.display());
            Error::settings(problem, format!("end the name in {endings}"))
        })
    }

    /// Which buffer.
    pub fn aov(&self) -> Aov {
        self.aov
    }

    /// In which format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Where to.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it goes to standard output.
    pub fn is_standard(&self) -> bool {
        is_standard(&self.path)
    }

    /// Whether it can be written, to be asked before the work begins.
    ///
    /// # Errors
    /// See [`check_writable`].
    pub fn check(&self) -> Result<()> {
        check_writable(&self.path)
    }

    /// Writes the buffer; `provenance` goes into formats that have room for words.
    ///
    /// # Errors
    /// [`Error::Settings`] for another buffer than announced or a malformed one, [`Error::Io`] from the system.
    pub fn write(&self, buffer: &Buffer, provenance: &png::Provenance) -> Result<()> {
        if buffer.aov != self.aov {
            let problem = format!("{} was meant for {}, not {}", self.path.display(), self.aov, buffer.aov);
            return Err(Error::settings(problem, "give each target its own buffer"));
        }
        buffer.check()?;
        write_atomically(&self.path, |out| match self.format {
            Format::Png => png::write(buffer, provenance, out),
            Format::Npy => npy::write(buffer, out),
        })
    }
}

/// Whether `path` stands for standard input or output.
pub fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether a file could be put at `path`: its folder exists and takes files, and `path` is no folder itself.
///
/// # Errors
/// [`Error::Io`] naming `path`.
pub fn check_writable(path: &Path) -> Result<()> {
    if is_standard(path) {
        return Ok(());
    }
    let folder = folder(path);
    let refuse = |kind: ErrorKind, why: String| Err(Error::write(path, io::Error::new(kind, why)));
    match fs::metadata(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            refuse(ErrorKind::NotFound, format!("there is no folder {}", folder.display()))
        }
        Err(error) => Err(Error::write(path, error)),
        Ok(found) if !found.is_dir() => {
            refuse(ErrorKind::NotADirectory, format!("{} is not a folder", folder.display()))
        }
        Ok(_) if path.is_dir() => refuse(ErrorKind::IsADirectory, "it is a folder".into()),
        // Permission bits do not tell the whole story; making a file does.
        Ok(_) if !is_special(path) => temporary(path).map(drop).map_err(|error| Error::write(path, error)),
        Ok(_) => Ok(()),
    }
}

/// Lets `fill` write the file at `path` so that nobody ever sees half of it: a temporary file in the same folder
/// takes the name when it is complete, and disappears if anything fails. A link is followed, the bits of a file
/// that is replaced are kept. Standard output, pipes and devices are written as they are.
///
/// # Errors
/// [`Error::Io`] naming `path`, from `fill` or the system.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let written = if is_standard(path) {
        filled(io::stdout().lock(), fill)
    } else if is_special(path) {
        File::options().write(true).open(path).and_then(|file| filled(file, fill))
    } else {
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        replace(&path, fill)
    };
    written.map_err(|error| Error::write(path, error))
}

fn replace(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let file = temporary(path)?;
    filled(file.as_file(), fill)?;
    if let Ok(old) = fs::metadata(path) {
        file.as_file().set_permissions(old.permissions())?;
    }
    file.persist(path).map(drop).map_err(|error| error.error)
}

fn filled(out: impl Write, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    fill(&mut out)?;
    out.flush()
}

fn temporary(path: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".halfline-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file: the user's umask takes away what it takes away.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder(path))
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A pipe or a device, which must not be replaced by a file.
fn is_special(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}
