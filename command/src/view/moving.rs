//! Pictures while the camera moves: soon, and without what follows later.

use halfline::error::{Error, Result};
use halfline::frame::Aov;
use halfline::frame::report::Report;
use halfline::render::Renderer;
use halfline::scene::{Lighting, Scene};
use halfline::settings::Settings;
use halfline_viewer::Pixels;

/// The picture of a scene by one ray for each pixel, lit from the eye.
///
/// # Errors
/// Those of a frame.
pub(super) fn render(renderer: &mut Renderer, scene: &Scene, settings: &Settings) -> Result<(Pixels, Report)> {
    let lighting = Lighting { bounces: Some(0), ..Lighting::default() };
    let scene = Scene { lighting, spheres: scene.spheres.clone(), ..*scene };
    let settings =
        Settings { aovs: vec![Aov::Color], samples: 1, aperture: None, silhouette: false, ..settings.clone() };
    let frame = renderer.render(&scene, &settings)?;
    let image = frame.image().ok_or_else(|| Error::settings("no picture is requested", "remove --aov"))?;
    let levels = image.pixels().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let (pixels, report) = (Pixels::Rgb { size: [image.width(), image.height()], levels }, frame.report.clone());
    renderer.recycle(frame);
    Ok((pixels, report))
}
