//! The folder in which tests find the project's own files.

use std::path::PathBuf;

/// The folder of scenes/ and shaders/: HALFLINE_HOME where the tests were carried to another machine (`tests/hardware`), else the
/// package.
pub(crate) fn home() -> PathBuf {
    std::env::var_os("HALFLINE_HOME").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into()).into()
}
