//! The length that a scale bar shows.

use super::ScaleBar;
use halfline::error::{Error, Result};
use halfline::quote::setting::{ORTHO, SCALE_BAR};
use halfline::scene::Scene;
use halfline::scene::camera::Viewport;

impl ScaleBar {
    /// The bar of a scene: with a perspective camera its length is that at the distance of the middle of all spheres.
    ///
    /// # Errors
    /// [`Error::Settings`] for a scene whose middle is not in front of the camera; errors of [`halfline::Lens::check_flat`].
    pub fn of(scene: &Scene, unit: &str) -> Result<Self> {
        Ok(Self { per_pixel: per_pixel(scene)?, unit: unit.to_owned() })
    }
}

/// Scene units in a pixel: everywhere with an orthographic camera, else at the distance of the middle of all spheres.
fn per_pixel(scene: &Scene) -> Result<f64> {
    scene.camera.lens.check_flat(SCALE_BAR, &format!("remove {SCALE_BAR}, or use such a camera"))?;
    let Viewport { vw, d, .. } = scene.camera.viewport(scene.image.width, scene.image.height)?;
    let pixel = vw / f64::from(scene.image.width);
    if scene.camera.lens.is_orthographic() {
        return Ok(pixel);
    }
    let basis = scene.camera.basis()?;
    let depth = (basis.e - scene.spheres.middle()).dot(basis.w);
    if depth > 0.0 {
        return Ok(pixel * depth / d);
    }
    let problem = format!("{SCALE_BAR} needs the middle of all spheres in front of the camera");
    Err(Error::settings(problem, format!("use {ORTHO} or another camera, or remove {SCALE_BAR}")))
}
