//! A scene in memory that a notebook or a page without a server shows.

use super::content::Content;
use super::given::WrittenOption;
use halfline::render::Renderer;
use halfline::scene::Cell;
use halfline::settings::Backend;
use halfline_files::read::SceneFrame;
use halfline_viewer::Pose;
use std::ffi::OsString;
use std::sync::{Arc, Mutex};

/// A scene in memory, the renderer that a notebook lends, and the options as those of the command.
pub struct MemoryScene {
    /// The frames, at least one, in their order; the page begins with the first. Their cameras and apertures are not used.
    pub frames: Vec<SceneFrame>,
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
    /// Whether pictures keep this size whatever the page's is.
    pub is_sized: bool,
    /// The renderer, unless it failed.
    pub renderer: Arc<Mutex<Option<Renderer>>>,
    /// The backend that this renderer was made for.
    pub backend: Backend,
    /// The names of settings in messages.
    pub words: fn(&str) -> String,
}

impl MemoryScene {
    /// The scene of a page, with a renderer that was made for `backend`.
    #[must_use]
    pub fn of(
        content: Content,
        renderer: Arc<Mutex<Option<Renderer>>>,
        backend: Backend,
        words: fn(&str) -> String,
    ) -> Self {
        let Content { frames, edges, name, source, rendering, copied, camera, size, is_sized } = content;
        let name = name.into();
        Self { frames, edges, name, source, rendering, copied, camera, size, is_sized, renderer, backend, words }
    }
}
