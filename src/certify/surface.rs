//! Points where viewing rays hit spheres, and the rays from there to lights: docs/certificate.md, section 10.
//!
//! A point is its sphere's centre, an exact point of the world, and an offset of known error. So a scene far from the
//! origin of the world loses nothing, and the sphere of the hit is decided by the side of its surface: no epsilon.

use super::given::{Bounds, CertifiedRay, EPS, SHORT, dot};
use crate::exact::{Root, Toward, Truth};
use crate::view::View;
use crate::view::placement::Placement;
use glam::DVec3;

/// Bound of the error of a viewing ray's direction in f64, of its length: two roundings of u and v, and in each sum over
/// three axes one of the axis, one of the product, two of sums; the three components add up to sqrt 3 of that.
const DIRECTION: f64 = 12.0 * EPS;
/// The same of a parallel ray's start.
const START: f64 = 14.0 * EPS;
/// The error of a point that the judge gives, of the radius: three components of the normal, and a product.
const JUDGED: f64 = 4.0 * EPS;
/// A point whose error is larger, of the radius, is not good enough: too many of its rays would be unsure.
const BLURRED: f64 = 1.0 / (1u64 << 30) as f64;

/// A point on a sphere of the scene, seen by the camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePoint {
    pub(crate) id: u32,
    /// The sphere as the scene states it.
    pub(crate) center: [f64; 3],
    pub(crate) radius: f64,
    /// From the centre, in the tree's unit.
    pub(crate) offset: [f64; 3],
    /// Its length.
    pub(crate) size: f64,
    /// What the offset is off by.
    pub(crate) blur: f64,
    /// The camera sees the sphere from outside.
    pub(crate) outside: bool,
    /// The unit normal against the viewing ray.
    pub(crate) normal: [f64; 3],
}

/// The part that the sphere of the point itself has in hiding a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Own {
    Hides,
    Open,
    Unsure,
}

impl SurfacePoint {
    /// Where the viewing ray of row `i` and column `j` hits this sphere, which it does hit. The point may be too blurred,
    /// see [`Self::is_sharp`].
    pub(crate) fn seen(
        view: &View,
        placement: &Placement,
        [i, j]: [u32; 2],
        (id, center, radius): (u32, [f64; 3], f64),
    ) -> Self {
        let direction = view.to_world(view.direction(i, j)).to_array();
        let start = view.to_world(view.origin(i, j)).to_array().map(|x| placement.radius(x));
        let blur = START * dot(start, start).sqrt();
        let ray = CertifiedRay::new(placement, view.basis.e.to_array(), direction, f64::INFINITY)
            .beside(start, blur, DIRECTION);
        match ray.meet(center, radius) {
            Some(bounds) => Self::met(&ray, &bounds, (id, center, radius)),
            None => {
                let p = ray.to(center);
                let nearest = dot(p, ray.direction) / ray.a;
                let offset = std::array::from_fn(|n| nearest * ray.direction[n] - p[n]);
                Self::new((id, center, radius), offset, f64::NAN, true)
            }
        }
    }

    /// Where a ray hits this sphere, within these bounds.
    #[inline(always)]
    pub(crate) fn met(ray: &CertifiedRay, bounds: &Bounds, (id, center, radius): (u32, [f64; 3], f64)) -> Self {
        let p = ray.to(center);
        let (size, length) = (dot(p, p).sqrt(), ray.a.sqrt());
        let offset: [f64; 3] = std::array::from_fn(|n| bounds.t * ray.direction[n] - p[n]);
        let along = bounds.t * length;
        // p, t d and their difference take four roundings beside what the start and the direction are off by.
        let blur = (bounds.high - bounds.low) * length
            + (ray.tilt() + 3.0 * EPS) * along
            + 4.0 * EPS * (size + dot(offset, offset).sqrt())
            + ray.blur();
        Self::new((id, center, radius), offset, blur * (1.0 + BLURRED), bounds.outside)
    }

    /// What the direction of a viewing ray of length 1 is off by.
    pub(crate) const VIEWING_TILT: f64 = DIRECTION + 4.0 * EPS;

    /// What the mirrored direction of a ray of length 1 is off by, if that of the ray is off by `tilt`: a mirror turns a
    /// direction twice as far as its normal is turned, once in each factor, and takes ten roundings.
    pub(crate) fn mirrored_tilt(&self, placement: &Placement, tilt: f64) -> f64 {
        let normal = self.blur / placement.radius(self.radius) + 4.0 * EPS;
        tilt + 4.0 * normal + 10.0 * EPS
    }

    /// The ray from here in a direction of length 1 that is off by `tilt`.
    #[inline(always)]
    pub(crate) fn onward(&self, placement: &Placement, along: [f64; 3], tilt: f64) -> CertifiedRay {
        CertifiedRay::in_unit(placement, self.center, along, f64::INFINITY, 0).beside(self.offset, self.blur, tilt)
    }

    /// Where a ray from here leaves the sphere of the point, which it goes through: the power of its start is 0.
    #[inline(always)]
    pub(crate) fn chord(&self, ray: &CertifiedRay) -> Bounds {
        let (along, doubt) = (-2.0 * self.along(ray), 2.0 * self.doubt(ray));
        let relative = 4.0 * EPS + 3.0 * ray.tilt();
        let low = ((along - doubt) / ray.a * (1.0 - relative)).max(0.0);
        let high = ((along + doubt) / ray.a * (1.0 + relative)).max(low);
        Bounds { low, high, t: (along / ray.a).max(low).min(high), sure: along > doubt, outside: false }
    }

    /// The point that the judge gives for the hit of this sphere.
    pub(crate) fn judged(placement: &Placement, truth: &Truth, (id, center, radius): (u32, [f64; 3], f64)) -> Self {
        let outside = truth.root == Root::Near;
        let r = if outside { placement.radius(radius) } else { -placement.radius(radius) };
        Self::new((id, center, radius), truth.normal.map(|x| x * r), JUDGED * r.abs(), outside)
    }

    fn new((id, center, radius): (u32, [f64; 3], f64), offset: [f64; 3], blur: f64, outside: bool) -> Self {
        let size = dot(offset, offset).sqrt();
        let sign = if outside { 1.0 / size } else { -1.0 / size };
        Self { id, center, radius, offset, size, blur, outside, normal: offset.map(|x| x * sign) }
    }

    /// The point as if it were exact, for answers that are not certified. A ray that f64 lets pass a sphere beside its rim
    /// hits the point of the sphere that is nearest to the ray.
    pub(crate) fn trusted(self, placement: &Placement) -> Self {
        let r = placement.radius(self.radius);
        let sign = if self.outside { r } else { -r };
        Self { offset: self.normal.map(|x| x * sign), size: r, blur: 0.0, ..self }
    }

    /// In the world, rounded.
    pub(crate) fn world(&self) -> DVec3 {
        let outward = if self.outside { DVec3::from_array(self.normal) } else { -DVec3::from_array(self.normal) };
        DVec3::from_array(self.center) + outward * self.radius
    }

    /// Whether the error of the point is so small beside the radius that few of its rays are unsure.
    pub(crate) fn is_sharp(&self, placement: &Placement) -> bool {
        let r = placement.radius(self.radius);
        r > SHORT && self.blur <= BLURRED * r
    }

    /// The ray from here, which ends at the light; `None` where its direction is not known.
    #[inline(always)]
    pub(crate) fn ray(&self, placement: &Placement, toward: &Toward) -> Option<CertifiedRay> {
        let ray = match *toward {
            Toward::Direction(direction) => CertifiedRay::new(placement, self.center, direction, f64::INFINITY),
            Toward::Within { direction, reach } => CertifiedRay::new(placement, self.center, direction, reach),
            Toward::Point(point) => {
                let l: [f64; 3] =
                    std::array::from_fn(|n| placement.difference(point[n], self.center[n]) - self.offset[n]);
                let (length, size) = (dot(l, l).sqrt(), self.size);
                // Two roundings of l, and one of the offset in the difference that l is taken from.
                let tilt = (2.0 * EPS * (length + size) + self.blur + SHORT) / length;
                if !(tilt <= BLURRED && length <= 1.0 / SHORT) {
                    return None;
                }
                let ray = CertifiedRay::in_unit(placement, self.center, l, 1.0, 0);
                return Some(ray.beside(self.offset, self.blur, tilt));
            }
        };
        Some(ray.beside(self.offset, self.blur, 0.0))
    }

    /// The cosine between the normal and a ray from here, and whether it is positive for certain, or negative.
    #[inline(always)]
    pub(crate) fn cosine(&self, ray: &CertifiedRay) -> (f64, Own) {
        let along = self.along(ray);
        let side = if self.outside { along } else { -along };
        (side / (self.size * ray.a.sqrt()), sign(-side, self.doubt(ray)))
    }

    /// What the sphere of the point does to the ray.
    #[inline(always)]
    pub(crate) fn own(&self, ray: &CertifiedRay) -> Own {
        let (along, doubt) = (self.along(ray), self.doubt(ray));
        if self.outside {
            return sign(-along, doubt);
        }
        let [low, high] = ray.limit;
        if low == f64::INFINITY {
            return Own::Hides;
        }
        // The power of the light: positive where the ray ends outside.
        let power = |limit: f64| limit * ray.a + 2.0 * along;
        let doubt = 2.0 * doubt + high * ray.a * (8.0 * EPS + 3.0 * ray.tilt());
        match (sign(power(low), doubt), sign(power(high), doubt)) {
            (a, b) if a == b => a,
            _ => Own::Unsure,
        }
    }

    /// The product of offset and direction.
    #[inline(always)]
    fn along(&self, ray: &CertifiedRay) -> f64 {
        dot(self.offset, ray.direction)
    }

    /// What [`Self::along`] is off by: the blur, the tilt, and five roundings.
    #[inline(always)]
    fn doubt(&self, ray: &CertifiedRay) -> f64 {
        ((ray.tilt() + 5.0 * EPS) * self.size + self.blur + SHORT) * ray.a.sqrt() * (1.0 + BLURRED)
    }
}

/// Hidden where x > 0 for certain, open where x < 0.
#[inline(always)]
fn sign(x: f64, doubt: f64) -> Own {
    match x {
        x if x > doubt => Own::Hides,
        x if x < -doubt => Own::Open,
        _ => Own::Unsure,
    }
}
