//! Explains a picture without a hit.

use crate::scene::camera::Look;
use crate::scene::{Scene, point};
use crate::window::Window;
use glam::DVec3;
use halfline_ground::parallel::{self, CHEAP};
use halfline_ground::quote::number;
use halfline_ground::quote::setting::{EYE, FIT, LEAST_SIZE, ORTHO, SIZE, VFOV};
use std::ops::Range;

/// Why no ray hits a sphere, and the remedy; `None` without spheres.
pub(super) fn missed(scene: &Scene, window: Option<Window>) -> Option<String> {
    let spheres = match scene.spheres.len() {
        0 => return None,
        1 => "the 1 sphere".to_owned(),
        n => format!("any of the {n} spheres"),
    };
    let ray = window.map_or("ray".to_owned(), |window| format!("ray of the crop {window}"));
    let looks = match scene.camera.look {
        Look::At(at) => format!("at {}", point(at)),
        Look::View(view) => format!("along {}", point(view)),
    };
    Some(format!(
        "no {ray} hits {spheres}, so the picture is background; the eye is at {} and looks {looks}, {}; {}",
        point(scene.camera.eye),
        scene.spheres.extent(),
        slips_through(scene).unwrap_or_else(|| format!("use {FIT} to frame them"))
    ))
}

/// The size of the spheres in view and the remedy, where they are missed because they are small: a disc of sqrt(2)
/// pixels diameter contains a pixel centre wherever it lies, a smaller one may lie between the centres.
fn slips_through(scene: &Scene) -> Option<String> {
    let (camera, image) = (&scene.camera, &scene.image);
    let (basis, v) = (camera.basis().ok()?, camera.viewport(image.width, image.height).ok()?);
    let pixel = (v.vw / f64::from(image.width)).max(v.vh / f64::from(image.height));
    let across = |id: usize| {
        let (c, radius) = (DVec3::from_array(scene.spheres.centers[id]) - basis.e, scene.spheres.radii[id]);
        let depth = -c.dot(basis.w);
        let scale = if v.is_parallel() { 1.0 } else { depth / v.d };
        let inside = 2.0 * c.dot(basis.u).abs() <= v.vw * scale && 2.0 * c.dot(basis.v).abs() <= v.vh * scale;
        (depth > 0.0 && inside).then(|| 2.0 * radius / (pixel * scale))
    };
    let largest = |ids: Range<usize>| ids.filter_map(across).fold(0.0, f64::max);
    let each = parallel::blocks(0..scene.spheres.len(), CHEAP, &|ids, _| largest(ids));
    let largest = each.into_iter().fold(0.0, f64::max);
    let mend = match v.is_parallel() {
        true => format!("a smaller {ORTHO},"),
        false => format!("a nearer {EYE}, a smaller {VFOV},"),
    };
    (largest > 0.0 && largest < std::f64::consts::SQRT_2).then(|| {
        format!(
            "the largest sphere in view is {} pixels across and lies between the rays: \
             {mend} a larger {SIZE} or {LEAST_SIZE} 3 shows it",
            number(largest, 2)
        )
    })
}
