//! The scene of the project that most tests use.

use halfline::scene::Scene;
use halfline_files::read::{self, ReadOptions};
use std::path::Path;

/// `scenes/weekend.toml` without its light and its sky, which take rays of their own.
pub(crate) fn weekend() -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.toml");
    let scene = read::scene(&path, &ReadOptions::default()).expect("weekend").scene;
    Scene { lighting: Default::default(), ..scene }
}
