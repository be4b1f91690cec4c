//! Names of unfinished files. They are needed where a complete file replaces another, and on file systems without
//! anonymous files (NFS, file systems of macOS and Windows). The unfinished file of a killed process is removed by the next
//! process that writes the same file, if its lock shows that it is abandoned.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::Path;
use tempfile::{Builder, NamedTempFile};

/// Prefix and suffix of the name of an unfinished file.
const PREFIX: &str = ".halfline-";
const SUFFIX: &str = ".part";

/// Creates an unfinished file for `path` beside it with `make`, which fails with `AlreadyExists` where the name is
/// taken.
pub(super) fn named<R>(path: &Path, make: impl Fn(&Path) -> io::Result<R>) -> io::Result<NamedTempFile<R>> {
    let own = own_name(path);
    for _ in 0..2 {
        let made = Builder::new().prefix(&own).suffix(SUFFIX).rand_bytes(0).make_in(folder(path), &make);
        let taken = |error: &io::Error| error.kind() == ErrorKind::AlreadyExists;
        if !made.as_ref().is_err_and(taken) || !remove_stale(&folder(path).join(format!("{own}{SUFFIX}"))) {
            match made {
                Err(error) if taken(&error) => break,
                made => return made.map_err(bare),
            }
        }
    }
    // Another process is writing the same file.
    Builder::new().prefix(PREFIX).suffix(SUFFIX).make_in(folder(path), make).map_err(bare)
}

/// A new empty file that will replace `path`.
pub(super) fn new(path: &Path) -> io::Result<NamedTempFile> {
    named(path, |name| {
        let mut options = File::options();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o666);
        let file = options.open(name)?;
        lock(&file);
        // Between its creation and its lock another process may have removed it as stale.
        if is_at(&file, name) { Ok(file) } else { Err(ErrorKind::AlreadyExists.into()) }
    })
}

/// The name of the unfinished file for `path`: the same for all processes of this machine since it was started, since
/// locks do not show writers on other machines.
fn own_name(path: &Path) -> String {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let mut hash = blake3::Hasher::new();
    hash.update(boot.as_bytes()).update(path.file_name().unwrap_or_default().as_encoded_bytes());
    format!("{PREFIX}{}", &hash.finalize().to_hex()[..16])
}

/// Locks a file for the lifetime of this process; returns whether its lock was free. Where the file system has no locks, it is
/// never considered stale.
pub(super) fn lock(file: &File) -> bool {
    // Elsewhere the names of unfinished files do not tell machines apart.
    cfg!(target_os = "linux") && file.try_lock().is_ok()
}

/// Removes a file whose lock is free, so its writer has ended; returns whether it did.
fn remove_stale(name: &Path) -> bool {
    // Some file systems require write access for a lock.
    let Ok(file) = File::options().write(true).open(name) else { return false };
    lock(&file) && is_at(&file, name) && fs::remove_file(name).is_ok()
}

/// Whether `path` still refers to this file.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let node = |found: fs::Metadata| (found.dev(), found.ino());
    let (here, there) = (file.metadata().map(node), path.symlink_metadata().map(node));
    matches!((here, there), (Ok(here), Ok(there)) if here == there)
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// The system's error without the name of the unfinished file, which means nothing to the user.
fn bare(error: io::Error) -> io::Error {
    let system = error.get_ref().and_then(|named| named.source()?.downcast_ref::<io::Error>()?.raw_os_error());
    system.map_or(error, io::Error::from_raw_os_error)
}

/// The folder of a file.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
