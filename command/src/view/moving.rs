//! Pixels of the page: fast pictures for a camera that moves, with one ray for each pixel, lit from the eye, and windows of stills.

use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::frame::report::Report;
use halfline::render::Renderer;
use halfline::scene::{Lighting, Scene};
use halfline::settings::{Look, Settings};
use halfline_viewer::Pixels;

/// Renders a scene with one ray per pixel, lit from the eye, with a pinhole and without silhouettes. Returns the pixels
/// and a report without warnings.
///
/// # Errors
/// Errors of [`Renderer::render`].
pub(super) fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<(Pixels, Report)> {
    let scene = Scene { lighting: Lighting::from_the_eye(), spheres: scene.spheres.clone(), ..*scene };
    let aovs = vec![Aov::Color];
    let settings = Settings { aovs, samples: 1, aperture: None, silhouette: false, ..settings.clone() };
    let (pixels, report) = part(renderer, &scene, &settings)?;
    Ok((pixels, Report { look: Some(Look::Plain.name()), warnings: Vec::new(), ..report }))
}

/// The pixels of the window of these settings, and the report.
///
/// # Errors
/// Errors of [`Renderer::render`].
pub(super) fn part(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<(Pixels, Report)> {
    let frame = renderer.render(scene, settings)?;
    let levels = frame.levels().ok_or_else(|| Error::settings("no picture is requested", "remove --aov"))?;
    let pixels = Pixels::Rgb { size: [frame.width, frame.height], levels };
    let report = frame.report.clone();
    renderer.recycle(frame);
    Ok((pixels, report))
}
