//! Where viewing rays meet spheres, in f64 without bounds: good enough for the colours and lines of a picture.

use super::View;
use crate::double_double as dd;
use glam::DVec3;

/// Where a sphere is farther away than this many radii, f64 does not know its normals to seven digits.
const FARTHEST: f64 = (1u64 << 30) as f64;

/// The viewing rays of a view.
pub(crate) struct PictureRays<'a> {
    view: &'a View,
    /// From the scene's unit to the frame's, in which squares neither overflow nor vanish.
    scale: f64,
}

/// Where a viewing ray meets a sphere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PictureHit {
    /// Along the view axis, in the scene's unit.
    pub(crate) depth: f64,
    /// The direction of the ray, of length 1.
    pub(crate) along: DVec3,
    /// Normal of length 1, against the ray; of no use unless `near`.
    pub(crate) normal: DVec3,
    /// The ray comes from outside.
    pub(crate) outside: bool,
    /// The sphere is near enough for its normal to be known.
    pub(crate) near: bool,
}

impl<'a> PictureRays<'a> {
    pub(crate) fn new(view: &'a View) -> Self {
        Self { view, scale: dd::ldexp(1.0, -view.unit) }
    }

    /// Where the viewing ray of this pixel meets a sphere. A ray that f64 lets pass beside it meets the point that is
    /// nearest to the ray.
    pub(crate) fn hit(&self, pixel: u32, center: [f64; 3], radius: f64) -> PictureHit {
        let view = self.view;
        let [row, column] = view.record.place(pixel);
        let [i, j] = view.record.sample_position(row, column);
        let direction = view.direction(i, j);
        let d = view.to_world(direction);
        let mut p = (DVec3::from_array(center) - view.basis.e) * self.scale;
        if view.parallel {
            p -= view.to_world(view.origin(i, j)) * self.scale;
        }
        let r = radius * self.scale;
        let (a, b, p2) = (d.length_squared(), p.dot(d), p.length_squared());
        let root = (a * r * r - p.cross(d).length_squared()).max(0.0).sqrt();
        let outside = p2 > r * r;
        let t = if outside { b - root } else { b + root } / a;
        let outward = (d * t - p).normalize_or(-d);
        PictureHit {
            depth: dd::ldexp(-direction[2] * t, view.unit),
            along: d / a.sqrt(),
            normal: if outside { outward } else { -outward },
            outside,
            near: p2 <= FARTHEST * FARTHEST * r * r,
        }
    }
}
