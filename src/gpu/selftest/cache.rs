//! The cache of the self-test: one small file per adapter in the user's cache folder. A file that is
//! unreadable, malformed or for another driver, program or shader is ignored.

use super::verdict::Verdict;
use crate::gpu::device::AdapterSummary;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::PathBuf;

/// The contents of a file.
#[derive(Serialize, Deserialize)]
struct Entry {
    /// Everything that the result depends on, as text.
    key: String,
    verdict: Verdict,
}

/// This program's folder in the user's cache folder.
pub(super) fn folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = match cfg!(windows) {
        true => set("LOCALAPPDATA"),
        false => set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache"))),
    };
    Some(cache?.join("halfline"))
}

/// The file is named after the adapter, so a new driver's result replaces the old one.
fn name(adapter: &AdapterSummary) -> String {
    let hash = blake3::hash(format!("{}, {}", adapter.name, adapter.backend).as_bytes()).to_hex();
    format!("selftest-{}.json", &hash.as_str()[..16])
}

/// The stored verdict, if it has this key.
pub(super) fn read(folder: Option<PathBuf>, adapter: &AdapterSummary, key: &str) -> Option<Verdict> {
    let text = std::fs::read(folder?.join(name(adapter))).ok()?;
    let entry: Entry = serde_json::from_slice(&text).ok()?;
    (entry.key == key).then_some(entry.verdict)
}

/// Stores a verdict; a failure is not an error.
pub(super) fn write(folder: Option<PathBuf>, adapter: &AdapterSummary, key: &str, verdict: &Verdict) {
    let entry = Entry { key: key.to_owned(), verdict: verdict.clone() };
    let kept = folder.ok_or("no cache folder".to_owned()).and_then(|folder| {
        let text = serde_json::to_vec(&entry).map_err(|e| e.to_string())?;
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        // Replaces the file atomically, so readers never see a partial file.
        let mut file = tempfile::NamedTempFile::new_in(&folder).map_err(|e| e.to_string())?;
        file.write_all(&text).map_err(|e| e.to_string())?;
        file.persist(folder.join(name(adapter))).map(drop).map_err(|e| e.to_string())
    });
    if let Err(reason) = kept {
        tracing::debug!("cannot cache the verdict: {reason}");
    }
}
