//! The scene of the project that most tests use.

use crate::home::home;
use halfline::scene::Scene;
use halfline_files::read::{self, ReadOptions};

/// `scenes/weekend.toml` without its light and its sky, which take rays of their own.
pub(crate) fn weekend() -> Scene {
    let path = home().join("scenes/weekend.toml");
    let scene = read::scene(&path, &ReadOptions::default()).expect("weekend").scene;
    Scene { lighting: Default::default(), ..scene }
}
