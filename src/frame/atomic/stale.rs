//! Unfinished files with names, on file systems that have no nameless ones (NFS, some of macOS and Windows): what a process
//! that was killed has left is removed by the next one that writes there, if it is certain that nobody writes it any longer.

use super::{SUFFIX, builder};
use std::io;
use std::path::Path;
use tempfile::NamedTempFile;

/// A new one in `folder`.
#[cfg(target_os = "linux")]
pub(super) fn named(folder: &Path) -> io::Result<NamedTempFile> {
    use rustix::fs::{FlockOperation, flock};
    let prefix = prefix();
    remove_once(folder, &prefix);
    loop {
        let file = builder(&prefix).tempfile_in(folder)?;
        // Held as long as the process lives. Where the file system has no locks, nobody takes this for stale.
        let _ = flock(file.as_file(), FlockOperation::NonBlockingLockExclusive);
        // Between its making and its lock another process may have removed it.
        if is_at(file.as_file(), file.path()) {
            return Ok(file);
        }
    }
}

#[cfg(not(target_os = "linux"))]
pub(super) fn named(folder: &Path) -> io::Result<NamedTempFile> {
    builder(super::PREFIX).tempfile_in(folder)
}

/// What begins the names of this machine since it was started: locks tell nothing of writers elsewhere.
#[cfg(target_os = "linux")]
fn prefix() -> String {
    let boot = std::fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let tag = &blake3::hash(boot.as_bytes()).to_hex()[..8];
    format!("{}{tag}-", super::PREFIX)
}

/// Removes what is stale in `folder`, which may hold very many files: once in a process.
#[cfg(target_os = "linux")]
fn remove_once(folder: &Path, prefix: &str) {
    use std::collections::BTreeSet;
    use std::path::PathBuf;
    use std::sync::{Mutex, PoisonError};
    static SEEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    if !seen.contains(&folder) {
        remove(&folder, prefix);
        seen.insert(folder);
    }
}

/// Removes the files whose writers are gone: their locks are free.
#[cfg(target_os = "linux")]
pub(super) fn remove(folder: &Path, prefix: &str) {
    use rustix::fs::{FlockOperation, flock};
    let Ok(entries) = folder.read_dir() else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        if !name.to_str().is_some_and(|name| name.starts_with(prefix) && name.ends_with(SUFFIX)) {
            continue;
        }
        let path = entry.path();
        // A file system that locks for writers only wants it opened so.
        let Ok(file) = std::fs::File::options().write(true).open(&path) else { continue };
        if flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() && is_at(&file, &path) {
            let _ = std::fs::remove_file(&path);
        }
    }
}

/// Whether this very file is still at `path`.
#[cfg(target_os = "linux")]
fn is_at(file: &std::fs::File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let node = |found: std::fs::Metadata| (found.dev(), found.ino());
    let (here, there) = (file.metadata().map(node), path.symlink_metadata().map(node));
    matches!((here, there), (Ok(here), Ok(there)) if here == there)
}
