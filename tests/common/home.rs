//! The folder in which tests find the project's own files.

use std::path::{Path, PathBuf};

/// The folder of scenes/ and shaders/: HALFLINE_HOME where the tests were carried to another machine (`tests/hardware`), else the
/// checkout, which contains the packages that tests are in.
pub(crate) fn home() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let checkout = package.ancestors().find(|folder| folder.join("Cargo.lock").is_file()).unwrap_or(package);
    std::env::var_os("HALFLINE_HOME").map_or(checkout.to_owned(), PathBuf::from)
}
