//! A scene in memory that a notebook or a page without a server shows.

use super::content::Content;
use halfline::render::Renderer;
use halfline::settings::Backend;
use std::sync::{Arc, Mutex};

/// A content, and the renderer that a notebook or a page lends.
pub struct MemoryScene {
    /// The frames, and the options as options of the command.
    pub content: Content,
    /// The renderer, unless it failed.
    pub renderer: Arc<Mutex<Option<Renderer>>>,
    /// The backend that this renderer was made for.
    pub backend: Backend,
    /// The names of settings in messages.
    pub words: fn(&str) -> String,
}
