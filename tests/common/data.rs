//! Finds real files: in the folder HALFLINE_DATA, otherwise in ../shared/data, and among those that `tests/real_files`
//! took from packages.

use crate::skip::skip;
use std::path::{Path, PathBuf};

/// A path in the checkout, which contains the packages that tests are in. Nothing is there where a test program was carried to
/// another machine.
pub(crate) fn in_checkout(path: &str) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().find(|folder| folder.join("Cargo.lock").is_file()).unwrap_or(package).join(path)
}

/// The path of a real file, or `None`.
pub(crate) fn real(name: &str) -> Option<PathBuf> {
    everywhere(name).next()
}

/// The path of a real file in each folder that has it.
pub(crate) fn everywhere(name: &str) -> impl Iterator<Item = PathBuf> {
    let shared = std::env::var_os("HALFLINE_DATA").map_or(in_checkout("../shared/data"), PathBuf::from);
    // Cargo gives tests the folder `tmp` of its target folder.
    let package = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("real-files");
    [shared, package].map(|folder| folder.join(name)).into_iter().filter(|path| path.is_file())
}

/// The files of this list that exist. If there are none, the test is skipped.
pub(crate) fn real_or_skip(names: &[&'static str]) -> Vec<(&'static str, PathBuf)> {
    let found: Vec<_> = names.iter().filter_map(|name| Some((*name, real(name)?))).collect();
    if found.is_empty() {
        skip(format!(
            "none of {} is here: python3 tests/real_files gets most, HALFLINE_DATA names a folder",
            names.join(", ")
        ));
    }
    found.iter().for_each(|(_, path)| println!("reads {}", path.display()));
    found
}
