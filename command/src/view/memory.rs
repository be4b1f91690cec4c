//! A scene in memory that a notebook shows.

use halfline::render::Renderer;
use halfline::scene::Cell;
use halfline::settings::Backend;
use halfline_files::read::SceneFrame;
use halfline_viewer::Pose;
use std::ffi::OsString;
use std::sync::{Arc, Mutex};

/// An option of the command: its identifier and its value; a flag has none.
pub type WrittenOption = (String, Option<OsString>);

/// A scene in memory, the renderer that a notebook lends, and the options as those of the command.
pub struct MemoryScene {
    /// The scene. Its camera and its aperture are not used.
    pub frame: SceneFrame,
    /// The cell whose edges the option `outline` draws.
    pub edges: Option<Cell>,
    /// The name of its file, or another one.
    pub name: OsString,
    /// The file that it was read from, if the copied lines can read it again.
    pub source: Option<OsString>,
    /// The options of every picture.
    pub rendering: Vec<WrittenOption>,
    /// The options in the copied lines: also those that read the file, and those that choose the renderer.
    pub copied: Vec<WrittenOption>,
    /// The camera with which it begins.
    pub camera: Pose,
    /// Width and height of the first picture.
    pub size: [u32; 2],
    /// The renderer, unless it failed.
    pub renderer: Arc<Mutex<Option<Renderer>>>,
    /// The backend that this renderer was made for.
    pub backend: Backend,
    /// The names of settings in messages.
    pub words: fn(&str) -> String,
}
