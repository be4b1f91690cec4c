//! Framing: the camera from which all spheres are seen whole, as near as that allows.

use super::{Scene, Spheres};
use crate::camera::{Lens, Look};
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;

/// How a scene is framed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Framing {
    /// Share of the image's height and width that is left free around the spheres, in all.
    pub margin: f64,
    /// Whether to frame the ball around all spheres, which looks the same from every side, rather than the spheres.
    pub ball: bool,
}

impl Default for Framing {
    /// 4 % free, the spheres themselves.
    fn default() -> Self {
        Self { margin: 0.04, ball: false }
    }
}

/// Full height of the view of a framed scene that names no lens, degrees: a portrait lens, little perspective.
const VFOV: f64 = 30.0;

/// What the camera of a file without one looks along, and up.
const VIEW: DVec3 = DVec3::NEG_Z;

impl Scene {
    /// Gives the scene the customary camera: it looks along -z, y is up, and all spheres are seen whole.
    pub(super) fn frame_all(&mut self, framing: &Framing) -> Result<()> {
        self.camera.look = Look::View(VIEW);
        self.camera.up = DVec3::Y;
        self.camera.lens = Lens::Vfov { degrees: VFOV, distance: 1.0 };
        self.fit(framing)
    }

    /// Moves the eye so that all spheres are seen whole: no silhouette reaches beyond the viewport less its margin. The
    /// direction, up and the angles of the lens stay as they are.
    ///
    /// A sphere is within the pyramid of a viewport exactly where its centre is at least a radius inside of each of the four
    /// planes through the eye. The planes' directions are known, so each plane touches the sphere that is foremost against
    /// it, and the nearest such eye is where the tighter of the two pairs of planes meets; the other pair is centred.
    ///
    /// # Errors
    /// Those of [`crate::Camera::basis`] and [`crate::Camera::viewport`].
    pub fn fit(&mut self, framing: &Framing) -> Result<()> {
        if self.spheres.is_empty() {
            return Ok(());
        }
        if let Look::At(at) = self.camera.look {
            self.camera.look = Look::View(at - self.camera.eye);
        }
        let basis = self.camera.basis()?;
        let viewport = self.camera.viewport(self.image.width, self.image.height)?;
        let framed = if framing.ball { ball(&self.spheres) } else { self.spheres.clone() };
        // Everything is counted from the middle, so that far places lose nothing.
        let middle = middle(&framed);
        let reach = |normal: DVec3| {
            let each = framed.centers.par_iter().zip(&framed.radii);
            each.map(|(c, r)| normal.dot(DVec3::from_array(*c) - middle) - r).reduce(|| f64::INFINITY, f64::min)
        };
        // What rounding takes here is far below this share of the image.
        let free = 1.0 - framing.margin.clamp(1e-9, 0.9);
        let pair = |axis: DVec3, side: f64| {
            let slope = free * side / (2.0 * viewport.d);
            let length = slope.hypot(1.0);
            let (sine, cosine) = (slope / length, 1.0 / length);
            let (low, high) = (reach(cosine * axis - sine * basis.w), reach(-cosine * axis - sine * basis.w));
            // The eye's place along the axis, and its least distance back.
            ((low - high) / (2.0 * cosine), -(low + high) / (2.0 * sine))
        };
        let ((x, z_across), (y, z_down)) = (pair(basis.u, viewport.vw), pair(basis.v, viewport.vh));
        self.camera.eye = middle + x * basis.u + y * basis.v + z_across.max(z_down) * basis.w;
        // Spheres near the ends of f64 leave no place for an eye.
        self.camera.basis().map(drop)
    }
}

/// The middle of the box around all spheres.
pub(super) fn middle(spheres: &Spheres) -> DVec3 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (center, radius) in spheres.centers.iter().zip(&spheres.radii) {
        let center = DVec3::from_array(*center);
        (low, high) = (low.min(center - *radius), high.max(center + *radius));
    }
    low + (high - low) / 2.0
}

/// One sphere around all of them, about the middle of their box.
fn ball(spheres: &Spheres) -> Spheres {
    let middle = middle(spheres);
    let each = spheres.centers.par_iter().zip(&spheres.radii);
    let radius = each.map(|(c, r)| (DVec3::from_array(*c) - middle).length() + r).reduce(|| 0.0, f64::max);
    let mut ball = Spheres::default();
    ball.push(middle.to_array(), radius, None);
    ball
}
