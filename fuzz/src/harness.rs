//! The fuzz targets and their invariants for any input: no panic, bounded memory and time, errors that a terminal can
//! show, and scenes that can be rendered. `tests/corpus.rs` runs the stored inputs through the same code.

#[path = "check.rs"]
pub(crate) mod check;
#[cfg(fuzzing)]
#[path = "config.rs"]
mod config;
#[path = "pictures.rs"]
mod pictures;
#[path = "rays.rs"]
mod rays;
#[path = "requests.rs"]
mod requests;
#[path = "scenes.rs"]
mod scenes;
#[path = "select.rs"]
mod select;

use check::Allowed;
use halfline_files::read::Format;

/// A fuzz target.
pub(crate) struct Target {
    pub(crate) name: &'static str,
    kind: Kind,
}

/// The kind of input.
enum Kind {
    /// A scene in this format, or in one detected from its content.
    Scene(Option<Format>),
    Other(fn(&[u8]) -> Allowed),
}

impl Target {
    /// All of them. A target has the name of its corpus.
    pub(crate) fn all() -> Vec<Self> {
        let scene = |format: &Format| Self { name: format.name(), kind: Kind::Scene(Some(*format)) };
        let other = |name, run| Self { name, kind: Kind::Other(run) };
        let others = [
            Self { name: "any", kind: Kind::Scene(None) },
            Self { name: "packed", kind: Kind::Scene(Some(Format::CSV)) },
            other("compare", pictures::compare),
            other("merge", pictures::merge),
            other("resume", pictures::resume),
            other("rays", rays::read),
            other("select", select::select),
            other("cameras", select::cameras),
            other("requests", requests::requests),
            #[cfg(fuzzing)]
            other("config", config::config),
        ];
        Format::ALL.iter().map(scene).chain(others).collect()
    }

    /// Runs the input, and panics where an invariant fails; returns the limits of the run.
    pub(crate) fn run(&self, data: &[u8]) -> Allowed {
        match self.kind {
            Kind::Scene(format) => scenes::scene(format, data),
            Kind::Other(run) => run(data),
        }
    }
}
