//! Verdicts remembered from one run to the next: one small file per adapter in the user's cache folder. What cannot be
//! read or written, is broken or belongs to another driver, program or shader is as if it were not there.

use super::Verdict;
use crate::gpu::device::AdapterSummary;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::PathBuf;

/// What the file holds.
#[derive(Serialize, Deserialize)]
struct Entry {
    /// All that the verdict depends on, in words.
    key: String,
    verdict: Verdict,
}

/// The user's cache folder of this program.
pub(super) fn folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = match cfg!(windows) {
        true => set("LOCALAPPDATA"),
        false => set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache"))),
    };
    Some(cache?.join("halfline"))
}

/// Named by the adapter, so that a new driver takes the old one's place.
fn name(adapter: &AdapterSummary) -> String {
    let hash = blake3::hash(format!("{}, {}", adapter.name, adapter.backend).as_bytes()).to_hex();
    format!("selftest-{}.json", &hash.as_str()[..16])
}

pub(super) fn read(folder: Option<PathBuf>, adapter: &AdapterSummary, key: &str) -> Option<Verdict> {
    let text = std::fs::read(folder?.join(name(adapter))).ok()?;
    let entry: Entry = serde_json::from_slice(&text).ok()?;
    (entry.key == key).then_some(entry.verdict)
}

pub(super) fn write(folder: Option<PathBuf>, adapter: &AdapterSummary, key: &str, verdict: &Verdict) {
    let entry = Entry { key: key.to_owned(), verdict: verdict.clone() };
    let kept = folder.ok_or("no cache folder".to_owned()).and_then(|folder| {
        let text = serde_json::to_vec(&entry).map_err(|e| e.to_string())?;
        std::fs::create_dir_all(&folder).map_err(|e| e.to_string())?;
        // A reader sees the old file or the new one, never half of one.
        let mut file = tempfile::NamedTempFile::new_in(&folder).map_err(|e| e.to_string())?;
        file.write_all(&text).map_err(|e| e.to_string())?;
        file.persist(folder.join(name(adapter))).map(drop).map_err(|e| e.to_string())
    });
    if let Err(reason) = kept {
        tracing::debug!("the self-test's verdict is not kept: {reason}");
    }
}
