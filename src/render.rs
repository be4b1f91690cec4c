//! Renders frames and traces given rays: plans, checks memory, sets up, runs kernels, and makes the answers.

mod budget;
mod engine;
pub mod explain;
mod fallback;
mod frame;
mod lens;
mod log;
mod missed;
mod opaque;
mod order;
mod passes;
mod place;
pub mod plan;
mod remaining;
mod renderer;
mod rendering;
mod report;
mod setup;
pub mod stream;
pub mod trace;

use crate::frame::Frame;
use crate::frame::provenance::Origin;
use crate::frame::report::Report;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::window::Window;
use halfline_ground::error::Result;

pub use renderer::Renderer;

/// Renders `scene` once. For many frames keep a [`Renderer`].
///
/// # Errors
/// Every kind of [`Error`](crate::Error); no partial frame is returned.
pub fn render(scene: &Scene, settings: &Settings) -> Result<Frame> {
    Renderer::new(settings)?.render(scene, settings)
}

/// Provenance of the files of `window` of `scene`: the settings, and the machine and method that computed them.
/// [`Renderer::dry_run`] gives the report before rendering.
#[must_use]
pub fn origin<'a>(scene: &Scene, settings: &Settings, report: &'a Report, window: Window) -> Origin<'a> {
    Origin {
        fingerprint: scene.fingerprint(),
        tolerance: settings.promise().relative(),
        seed: settings.seed,
        report,
        window,
        full: [scene.image.width, scene.image.height],
    }
}
