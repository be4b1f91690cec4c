//! Cameras of the page and of scenes.

use glam::DVec3;
use halfline::camera::{Camera, Lens as CameraLens, Look};
use halfline::error::Result;
use halfline::scene::Scene;
use halfline_viewer::{Lens, Pose};

/// The camera of a scene in the form of the page: eye, point to look at, up direction, and an angle or a height. If the
/// scene gives a direction and no point, the point is where the view comes nearest to `pivot`, or else to the middle of
/// the spheres.
///
/// # Errors
/// Errors of [`Camera::viewport`] and of [`CameraLens::check_flat`].
pub fn pose(scene: &Scene, pivot: Option<DVec3>) -> Result<Pose> {
    let Scene { camera, image, spheres, .. } = scene;
    camera
        .lens
        .check_flat("the camera of a page", "give another camera, by --camera-from or --eye, or render pictures")?;
    let at = match camera.look {
        Look::At(at) => at,
        Look::View(view) => {
            let view = view.normalize();
            let depth = (pivot.unwrap_or_else(|| spheres.middle()) - camera.eye).dot(view);
            let ahead = if depth > 0.0 && depth.is_finite() { depth } else { 1.0 };
            camera.eye + ahead * view
        }
    };
    let viewport = camera.viewport(image.width, image.height)?;
    let lens = match camera.lens {
        CameraLens::Vfov { degrees, .. } => Lens::Vfov(degrees),
        lens if lens.is_orthographic() => Lens::Height(viewport.vh),
        _ => Lens::Vfov(angle(viewport.vh / viewport.d)),
    };
    Ok(Pose { eye: camera.eye.to_array(), at: at.to_array(), up: camera.up.to_array(), lens })
}

/// The angle of a viewport of this height at the distance 1, degrees: the shortest number that gives it again.
fn angle(height: f64) -> f64 {
    let exact = 2.0 * (height / 2.0).atan().to_degrees();
    let gives = |degrees: &f64| 2.0 * (degrees.to_radians() / 2.0).tan() == height;
    let rounded = [1e3, 1e6, 1e9, 1e12].map(|scale: f64| (exact * scale).round() / scale);
    rounded.into_iter().find(gives).unwrap_or(exact)
}

/// The length that a pixel shows at the distance of the point looked at, in scene units.
///
/// # Errors
/// Errors of [`Camera::viewport`].
pub(super) fn unit(camera: &Camera, [width, height]: [u32; 2]) -> Result<f64> {
    let viewport = camera.viewport(width, height)?;
    let distance = match camera.look {
        Look::At(at) => at.distance(camera.eye),
        Look::View(view) => DVec3::length(view),
    };
    let scale = if camera.lens.is_orthographic() { 1.0 } else { distance / viewport.d };
    Ok(viewport.vh / f64::from(height) * scale)
}
