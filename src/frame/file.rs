//! Where buffers go: the format by the file's ending, `-` for standard output, and files that are either whole
//! or not there.

use super::format::{Format, Style};
use super::provenance::{Origin, Provenance};
use super::sheet::Sheet;
use super::{Aov, Frame, encode};
use crate::error::{Error, Result};
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// One file and the buffers that go into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    aovs: Vec<Aov>,
    format: Format,
    style: Style,
    path: PathBuf,
}

impl Target {
    /// The buffers `aovs` at `path`, one or more. On standard output (`-`) colour is PNG, everything else .npy. Where the
    /// style is transparent, alpha goes beside colour into every format that has room for it.
    ///
    /// # Errors
    /// [`Error::Settings`] naming the file, if its ending names no format that takes these buffers.
    pub fn new(aovs: &[Aov], path: &Path, style: Style) -> Result<Self> {
        let fits =
            |format: Format| aovs.iter().all(|aov| format.takes(*aov)) && (aovs.len() == 1 || format.holds_many());
        let customary = if aovs == [Aov::Color] { Format::Png } else { Format::Npy };
        let format = if is_standard(path) { Some(customary) } else { Format::of(path) };
        let Some(format) = format.filter(|format| fits(*format)) else {
            let names = aovs.iter().map(|aov| aov.name()).collect::<Vec<_>>().join(", ");
            let buffers = if aovs.len() == 1 { "buffer" } else { "buffers together" };
            let problem = format!("{} cannot hold the {names} {buffers}", path.display());
            return Err(Error::settings(problem, format!("end the name in {}", Format::endings(fits))));
        };
        Ok(Self::with_format(aovs, path, format, style))
    }

    /// The bare numbers of one buffer at `path`, whatever its name ends in.
    pub fn raw(aov: Aov, path: &Path, style: Style) -> Self {
        Self::with_format(&[aov], path, Format::Raw, style)
    }

    fn with_format(aovs: &[Aov], path: &Path, format: Format, style: Style) -> Self {
        let mut aovs = aovs.to_vec();
        if style.transparent && aovs.contains(&Aov::Color) && format.takes_alpha() {
            aovs.push(Aov::Alpha);
        }
        aovs.sort_unstable();
        aovs.dedup();
        Self { aovs, format, style, path: path.to_path_buf() }
    }

    /// Which buffers, in the order of [`Aov::ALL`].
    pub fn aovs(&self) -> &[Aov] {
        &self.aovs
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

    /// What the file says of where it comes from; .raw has no room for it.
    pub fn provenance(&self, origin: &Origin<'_>) -> Provenance {
        Provenance::new(origin, self.format, &self.aovs, &self.style)
    }

    /// Whether the file is there, whole, and says word for word that it comes from `origin`.
    pub fn is_there(&self, origin: &Origin<'_>) -> bool {
        let there = (!self.is_standard()).then(|| Sheet::read(&self.path).ok()).flatten();
        there.is_some_and(|(format, sheet)| format == self.format && sheet.provenance == self.provenance(origin))
    }

    /// What the format cannot hold of `frame`, in whole sentences.
    pub fn warnings(&self, frame: &Frame) -> Vec<String> {
        let buffers = self.aovs.iter().filter(|_| self.format == Format::Png).filter_map(|aov| frame.get(*aov));
        buffers.filter_map(|buffer| encode::warning(buffer, self.style.unit)).collect()
    }

    /// Writes the buffers of `frame`, and where they come from.
    ///
    /// # Errors
    /// [`Error::Settings`] for a frame that lacks a buffer or holds a malformed one, [`Error::Io`] from the system.
    pub fn write(&self, frame: &Frame, origin: &Origin<'_>) -> Result<()> {
        let refuse = |problem: String| Error::settings(problem, "render it with the buffers that its files take");
        for aov in &self.aovs {
            let buffer = frame.get(*aov);
            buffer
                .ok_or_else(|| refuse(format!("{} was meant for {aov}, which is not there", self.path.display())))?
                .check()?;
        }
        let layers = encode::layers(frame, &self.aovs, self.format, &self.style);
        let sheet = Sheet::new(layers, self.provenance(origin));
        let sheet = sheet.ok_or_else(|| refuse(format!("the buffers do not fill the window {}", origin.window)))?;
        write_sheet(&sheet, self.format, &self.path)
    }
}

/// Writes the file of a sheet as [`write_atomically`] does.
///
/// # Errors
/// [`Error::Io`] naming `path`.
pub fn write_sheet(sheet: &Sheet<'_>, format: Format, path: &Path) -> Result<()> {
    write_atomically(path, |out| sheet.write(format, out))
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
