//! Atomic files: a file is written completely or not at all, even if the process is killed. The crate atomic-write-file
//! (0.3.1) replaces symbolic links and leaves the unfinished files of killed processes where they are.

use super::rows::Sink;
use halfline::error::{Error, Result};
use halfline_particles::input::{is_special, is_standard};
use stale::folder;
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use tempfile::NamedTempFile;

mod stale;

/// Whether `path` is standard output, by any of its names.
pub fn is_standard_output(path: &Path) -> bool {
    let named = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name));
    is_standard(path) || cfg!(unix) && named
}

/// Whether the process has no standard output.
static NO_OUTPUT: AtomicBool = AtomicBool::new(false);

/// Makes writing to standard output an error, for a process that began without one: the standard library has opened /dev/null
/// in its place, where everything is lost without an error.
pub fn refuse_standard_output() {
    NO_OUTPUT.store(true, Ordering::Relaxed);
}

/// Checks that a file can be created at `path`: its folder exists and is writable, and `path` is not a folder.
///
/// # Errors
/// [`Error::Io`] naming `path`.
pub fn check_writable(path: &Path) -> Result<()> {
    let Destination::File(file) = Destination::of(path).map_err(|error| Error::write(path, error))? else {
        return Ok(());
    };
    let folder = folder(&file);
    let refuse = |kind: ErrorKind, why: String| Err(Error::write(path, io::Error::new(kind, why)));
    match fs::metadata(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            refuse(ErrorKind::NotFound, format!("the folder {} does not exist", folder.display()))
        }
        Err(error) => Err(Error::write(path, error)),
        Ok(found) if !found.is_dir() => {
            refuse(ErrorKind::NotADirectory, format!("{} is not a folder", folder.display()))
        }
        Ok(_) if file.is_dir() => refuse(ErrorKind::IsADirectory, "the path is a folder".into()),
        // Permission bits are not conclusive; creating a file is.
        Ok(_) => Unfinished::new(&file).map(drop).map_err(|error| Error::write(path, error)),
    }
}

/// Lets `fill` write the file at `path` so that a partly written file is never visible: an anonymous file in the same
/// folder gets its name when it is complete and on the disk. A link is followed and kept, whether its target exists or
/// not; the permission bits of a replaced file are kept. Standard output, pipes and devices are written directly.
///
/// # Errors
/// [`Error::Io`] naming `path`, from `fill` or the system; an [`Error`] that `fill` wrapped is returned unchanged.
pub fn write_atomically(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let written = Destination::of(path).and_then(|destination| match destination {
        Destination::Standard => filled(io::stdout().lock(), |out| fill(out)),
        Destination::Special => filled(File::options().write(true).open(path)?, |out| fill(out)),
        Destination::File(path) => replace(&path, |out| fill(out)),
    });
    written.map_err(|error| failure(path, error))
}

/// As [`write_atomically`], with seeking. A pipe gets the file when it is complete.
///
/// # Errors
/// As [`write_atomically`].
pub(super) fn write_anywhere(path: &Path, fill: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<()> {
    let written = Destination::of(path).and_then(|destination| {
        if let Destination::File(path) = destination {
            return replace(&path, |out| fill(out));
        }
        let mut whole = tempfile::tempfile()?;
        filled(&whole, |out| fill(out))?;
        whole.rewind()?;
        match destination {
            Destination::Standard => filled(io::stdout().lock(), |out| io::copy(&mut whole, out).map(drop)),
            _ => io::copy(&mut whole, &mut File::options().write(true).open(path)?).map(drop),
        }
    });
    written.map_err(|error| failure(path, error))
}

/// As [`write_atomically`], by another program: `fill` gets the name of the unfinished file, which the program may open, seek and
/// truncate.
///
/// # Errors
/// As [`write_atomically`]; a pipe or a device cannot be written in this way.
pub fn write_by_program(path: &Path, fill: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    let written = Destination::of(path).and_then(|destination| match destination {
        Destination::File(path) => {
            let mut unfinished = Unfinished::new(&path)?;
            if !unfinished.name().exists() {
                unfinished = Unfinished::Named(stale::new(&path)?);
            }
            fill(&unfinished.name())?;
            unfinished.complete(&path)
        }
        _ => Err(io::Error::other("only a file can be written in several passes")),
    });
    written.map_err(|error| failure(path, error))
}

/// An anonymous file for parts of what will be written to `path`: in its folder, which has room for it, or in the
/// system's folder of temporary files where `path` is a pipe or a device.
pub(super) fn scratch(path: &Path) -> io::Result<File> {
    match Destination::of(path)? {
        Destination::File(file) => tempfile::tempfile_in(folder(&file)),
        _ => tempfile::tempfile(),
    }
}

/// The error of writing `path`, unless it wraps an [`Error`].
fn failure(path: &Path, error: io::Error) -> Error {
    error.downcast::<Error>().unwrap_or_else(|error| Error::write(path, error))
}

/// The kind of destination that a path refers to.
enum Destination {
    Standard,
    /// A pipe or a device, which must not be replaced by a file.
    Special,
    /// A file, existing or not, with all links resolved.
    File(PathBuf),
}

impl Destination {
    fn of(path: &Path) -> io::Result<Self> {
        match path {
            path if is_standard_output(path) && NO_OUTPUT.load(Ordering::Relaxed) => {
                Err(io::Error::other("standard output is closed"))
            }
            path if is_standard_output(path) => Ok(Self::Standard),
            path if is_special(path) => Ok(Self::Special),
            path => followed(path).map(Self::File),
        }
    }
}

/// The target of all links.
fn followed(path: &Path) -> io::Result<PathBuf> {
    // The limit of Linux.
    const LINKS: usize = 40;
    let mut path = path.to_path_buf();
    for _ in 0..LINKS {
        match fs::read_link(&path) {
            Ok(target) => path = folder(&path).join(target),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("the link points to itself"))
}

fn replace(path: &Path, fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>) -> io::Result<()> {
    let unfinished = Unfinished::new(path)?;
    filled(unfinished.file(), fill)?;
    unfinished.complete(path)
}

fn filled<W: Write>(out: W, fill: impl FnOnce(&mut BufWriter<W>) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    fill(&mut out)?;
    out.flush()
}

/// Makes a new name survive a power failure, where the system can.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(not(unix)) {
        return Ok(());
    }
    // A folder may be writable but not readable.
    let Ok(folder) = File::open(folder) else { return Ok(()) };
    match folder.sync_all() {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        synced => synced,
    }
}

/// A file that is being written.
enum Unfinished {
    /// It disappears with the process.
    Nameless(File),
    /// It has a temporary name until it is complete, where the system has no anonymous files.
    Named(NamedTempFile),
}

impl Unfinished {
    /// An unfinished file for `path`.
    fn new(path: &Path) -> io::Result<Self> {
        nameless(folder(path)).map_or_else(|| stale::new(path).map(Self::Named), |file| Ok(Self::Nameless(file)))
    }

    fn file(&self) -> &File {
        match self {
            Self::Nameless(file) => file,
            Self::Named(file) => file.as_file(),
        }
    }

    /// The name by which another process of this user can open it while it is open here.
    fn name(&self) -> PathBuf {
        match self {
            #[cfg(target_os = "linux")]
            Self::Nameless(file) => {
                use std::os::fd::AsRawFd;
                format!("/proc/{}/fd/{}", std::process::id(), file.as_raw_fd()).into()
            }
            #[cfg(not(target_os = "linux"))]
            Self::Nameless(_) => PathBuf::new(),
            Self::Named(file) => file.path().to_path_buf(),
        }
    }

    /// Makes it the file at `path`, with the permission bits of the one that it replaces.
    fn complete(self, path: &Path) -> io::Result<()> {
        let file = self.file();
        if let Ok(old) = fs::metadata(path)
            && old.permissions() != file.metadata()?.permissions()
        {
            file.set_permissions(old.permissions())?;
        }
        // Before it gets its name: after a power failure the name must not refer to an empty file.
        file.sync_all()?;
        self.take_name(path)?;
        sync_folder(folder(path))
    }

    /// Replaces the file at `path`. The file stays open, and so locked, until it has its name: another thread or process that
    /// writes the same file would remove an unlocked one as stale.
    fn take_name(self, path: &Path) -> io::Result<()> {
        match self {
            // A link can only be made where there is no file; replacing one takes two steps.
            Self::Nameless(file) => give_name(&file, path).or_else(|_| replace_by(&file, path)),
            Self::Named(file) => file.persist(path).map(drop).map_err(|error| error.error),
        }
    }
}

/// Replaces the file at `path` by an anonymous one, or by a copy of it where it cannot be linked.
fn replace_by(file: &File, path: &Path) -> io::Result<()> {
    stale::lock(file);
    match stale::named(path, |name| give_name(file, name)) {
        Ok(named) => named.persist(path).map_err(|error| error.error),
        Err(_) => copied(file, path)?.persist(path).map(drop).map_err(|error| error.error),
    }
}

/// A named copy of a file that cannot be linked here.
fn copied(mut file: &File, path: &Path) -> io::Result<NamedTempFile> {
    let mut named = stale::new(path)?;
    file.rewind()?;
    io::copy(&mut file, &mut named)?;
    named.as_file().set_permissions(file.metadata()?.permissions())?;
    named.as_file().sync_all()?;
    Ok(named)
}

/// An anonymous file in `folder`, where the system supports it.
#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> Option<File> {
    use rustix::fs::OFlags;
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = File::options();
    options.read(true).write(true).mode(0o666).custom_flags(OFlags::TMPFILE.bits() as i32);
    options.open(folder).ok()
}

#[cfg(not(target_os = "linux"))]
fn nameless(_: &Path) -> Option<File> {
    None
}

/// Links an anonymous file to a name.
#[cfg(target_os = "linux")]
fn give_name(file: &File, name: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let nameless = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, nameless, CWD, name, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(target_os = "linux"))]
fn give_name(_: &File, _: &Path) -> io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}

#[cfg(all(test, target_os = "linux"))]
mod tests;
