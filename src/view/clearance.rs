//! The distance between a ray and a sphere's centre, in double-double: at 1e12 radii f64 cannot decide hit or miss.

use super::FromEye;
use crate::double_double::{self as dd, Dd, Dd3, dot};
use crate::error::Result;
use crate::scene::Scene;
use crate::scene::camera::Viewport;

/// A camera with its basis in double-double.
#[derive(Debug)]
pub struct Clearance {
    axes: [Dd3; 3],
    viewport: Viewport,
}

impl Clearance {
    /// The viewing rays of a scene, whose lens has one eye and its principal point in the middle of the image.
    ///
    /// # Errors
    /// [`Error::Scene`](crate::Error::Scene) for a camera that has no basis or no viewport.
    pub fn of(scene: &Scene) -> Result<Self> {
        let viewport = scene.camera.viewport(scene.image.width, scene.image.height)?;
        Ok(Self { axes: scene.camera.axes()?, viewport })
    }

    /// The direction of row `i`, column `j` in the canonical camera, 2 W H times the lecture's (u, v, -d) and scaled by
    /// a power of two: ((2j + 1 - W) vw H, -(2i + 1 - H) vh W, -2 W H d).
    fn direction(&self, [width, height]: [u32; 2], i: u32, j: u32) -> Dd3 {
        let Viewport { vw, vh, d } = self.viewport;
        let k = dd::exponent(vw.max(vh).max(d));
        let [vw, vh, d] = [vw, vh, d].map(|x| Dd::from(dd::ldexp(x, -k)));
        let [w, h] = [width, height].map(f64::from);
        let along = |n: u32, side: f64| Dd::from(2.0 * f64::from(n) + 1.0 - side);
        [along(j, w) * vw * h.into(), -(along(i, h) * vh * w.into()), -(d * Dd::product(2.0 * w, h))]
    }

    /// l/r - 1 of a sphere, where l is the distance of its centre from the half-line: negative for a hit, with an error
    /// of about 2^-94 of the centre's distance in radii. Infinity for a sphere that the scene does not have.
    #[must_use]
    pub fn excess(&self, scene: &Scene, i: u32, j: u32, id: u32) -> f64 {
        let Some((center, radius)) = scene.spheres.centers.get(id as usize).zip(scene.spheres.radii.get(id as usize))
        else {
            return f64::INFINITY;
        };
        let FromEye { offset, radius, .. } = FromEye::new(scene.camera.eye, *center, *radius);
        let radius = Dd::from(radius);
        let p = self.axes.map(|axis| dot(offset, axis));
        let d = self.direction([scene.image.width, scene.image.height], i, j);
        let l = if dot(p, d).hi > 0.0 {
            let aside = dd::cross(p, d);
            dot(aside, aside).sqrt() / dot(d, d).sqrt()
        } else {
            dot(p, p).sqrt()
        };
        ((l - radius) / radius).value()
    }
}
