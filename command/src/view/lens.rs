//! Cameras of the page and of scenes.

use glam::DVec3;
use halfline::camera::{Camera, Curve, Intrinsics, Lens as CameraLens, Look};
use halfline::error::Result;
use halfline::scene::{ImagePlane, Scene};
use halfline_viewer::{Lens, LensName, NamedLens, Pose};

/// The camera of a scene in the form of the page: eye, point to look at, up direction, and an angle, a height or a lens of the options. If the
/// scene gives a direction and no point, the point is where the view comes nearest to `pivot`, or else to the middle of
/// the spheres.
///
/// # Errors
/// Errors of [`Camera::viewport`].
pub fn pose(scene: &Scene, pivot: Option<DVec3>) -> Result<Pose> {
    let Scene { camera, image, spheres, .. } = scene;
    let at = match camera.look {
        Look::At(at) => at,
        Look::View(view) => {
            let view = view.normalize();
            let depth = (pivot.unwrap_or_else(|| spheres.middle()) - camera.eye).dot(view);
            let ahead = if depth > 0.0 && depth.is_finite() { depth } else { 1.0 };
            camera.eye + ahead * view
        }
    };
    let viewport = camera.central_viewport(image.width, image.height)?;
    let half = viewport.vh / viewport.d / 2.0;
    let lens = match camera.lens {
        CameraLens::Vfov { degrees, .. } => Lens::Vfov(degrees),
        lens if lens.is_orthographic() => Lens::Height(viewport.vh),
        lens => named(lens, *image, half).map_or_else(|| Lens::Vfov(angle(half)), Lens::Named),
    };
    Ok(Pose { eye: camera.eye.to_array(), at: at.to_array(), up: camera.up.to_array(), lens })
}

/// The angle of a view that is `half` as high at the distance 1 on each side, degrees: the shortest number that gives it again.
fn angle(half: f64) -> f64 {
    shortest(2.0 * half.atan().to_degrees(), |degrees| 2.0 * (degrees.to_radians() / 2.0).tan() == 2.0 * half)
}

/// The shortest decimal near a number that `gives` the same again, else the number.
fn shortest(exact: f64, gives: impl Fn(f64) -> bool) -> f64 {
    let rounded = [1e3, 1e6, 1e9, 1e12].map(|scale: f64| (exact * scale).round() / scale);
    rounded.into_iter().find(|degrees| gives(*degrees)).unwrap_or(exact)
}

/// The lens in the words of the options, for this image; `None` for one with an angle.
fn named(lens: CameraLens, ImagePlane { width, height, .. }: ImagePlane, half: f64) -> Option<NamedLens> {
    let of = |name| NamedLens { name, vfov: None, intrinsics: None, coefficients: None, half };
    let in_pixels = |name, pixels, coefficients: Option<[f64; 8]>| {
        let coefficients = coefficients.filter(|all| *all != [0.0; 8]);
        Some(NamedLens { intrinsics: Some((pixels, [width, height])), coefficients, ..of(name) })
    };
    let is_centred =
        |[fx, fy, cx, cy]: [f64; 4]| fx == fy && [cx, cy] == [width, height].map(|side| f64::from(side) / 2.0);
    match lens {
        CameraLens::Curved { curve: Curve::Panorama, .. } => Some(of(LensName::Equirectangular)),
        CameraLens::Curved { curve: Curve::Fisheye { k }, fx, fy, cx, cy } => {
            let exact = (f64::from(height) / fy).to_degrees();
            let vfov = shortest(exact, |degrees| CameraLens::fisheye(degrees, k, width, height) == lens);
            let has_angle = k == [0.0; 4] && is_centred([fx, fy, cx, cy]) && vfov <= 360.0;
            if has_angle {
                return Some(NamedLens { vfov: Some(vfov), ..of(LensName::Fisheye) });
            }
            let [k1, k2, k3, k4] = k;
            in_pixels(LensName::Fisheye, [fx, fy, cx, cy], Some([k1, k2, k3, k4, 0.0, 0.0, 0.0, 0.0]))
        }
        CameraLens::Curved { curve: Curve::Distorted { k: [k1, k2, k3, k4, k5, k6], p: [p1, p2] }, fx, fy, cx, cy } => {
            in_pixels(LensName::Opencv, [fx, fy, cx, cy], Some([k1, k2, p1, p2, k3, k4, k5, k6]))
        }
        CameraLens::Intrinsics { fx, fy, cx, cy } if !is_centred([fx, fy, cx, cy]) => {
            in_pixels(LensName::Opencv, [fx, fy, cx, cy], None)
        }
        _ => None,
    }
}

/// The options of a lens, with their values, for a picture of this size; `None` for an option without one. `is_framed` says whether the height of
/// an orthographic view is fitted.
pub(super) fn options(lens: &Lens, size: [u32; 2], is_framed: bool) -> Vec<(&'static str, Option<String>)> {
    let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    let NamedLens { name, vfov, intrinsics, coefficients, .. } = match lens {
        Lens::Vfov(degrees) => return vec![("vfov", Some(degrees.to_string()))],
        Lens::Height(_) if is_framed => return vec![("ortho", None)],
        Lens::Height(height) => return vec![("ortho", Some(height.to_string()))],
        Lens::Named(lens) => lens,
    };
    let word = match name {
        LensName::Fisheye => "fisheye",
        LensName::Equirectangular => "equirectangular",
        LensName::Opencv => "opencv",
    };
    let count = if *name == LensName::Fisheye { 4 } else { 8 };
    let pixels = intrinsics.map(|([fx, fy, cx, cy], from)| {
        let Intrinsics { fx, fy, cx, cy } = Intrinsics { fx, fy, cx, cy }.resized(from, size);
        list(&[fx, fy, cx, cy])
    });
    let numbers = [
        ("vfov", vfov.map(|degrees| degrees.to_string())),
        ("intrinsics", pixels),
        ("lens_coefficients", coefficients.map(|all| list(&all[..count]))),
    ];
    let given = numbers.into_iter().filter(|(_, value)| value.is_some());
    [("lens", Some(word.to_owned()))].into_iter().chain(given).collect()
}

/// The length that a pixel shows at the distance of the point looked at, in scene units; through a curved lens in the middle of its picture.
///
/// # Errors
/// Errors of [`Camera::viewport`].
pub(super) fn unit(camera: &Camera, [width, height]: [u32; 2]) -> Result<f64> {
    let viewport = camera.central_viewport(width, height)?;
    let distance = match camera.look {
        Look::At(at) => at.distance(camera.eye),
        Look::View(view) => DVec3::length(view),
    };
    let scale = if camera.lens.is_orthographic() { 1.0 } else { distance / viewport.d };
    Ok(viewport.vh / f64::from(height) * scale)
}
