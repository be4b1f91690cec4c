//! Points where viewing rays hit spheres, and the rays from there to lights: docs/certificate.md, section 10.
//!
//! A point is its sphere's centre, an exact point of the world, and an offset of known error. So a scene far from the
//! origin of the world loses nothing, and the sphere of the hit is decided by the side of its surface: no epsilon.

use super::given::{AnyHit, Bounds, CertifiedRay, EPS, SHORT, SLACK};
use crate::double_double as dd;
use crate::exact::{Root, Toward, Truth};
use crate::scene::{Ball, NumberedBall};
use crate::view::View;
use crate::view::placement::Placement;
use crate::view::ray::dot3;
use glam::DVec3;

/// Bound of the error of a viewing ray's direction in f64, relative to its length: two roundings of u and v, and in
/// each sum over three axes one of the axis, one of the product, two of sums; the three components add up to sqrt 3 of
/// that. Section 10.
const DIRECTION: f64 = 12.0 * EPS;
/// Bound of the error of a parallel ray's start in f64, relative to its distance from the eye. Section 10.
const START: f64 = 14.0 * EPS;
/// Error of a point that the judge gives, relative to the radius: three components of the normal, and a product.
/// Section 10.
const JUDGED: f64 = 4.0 * EPS;
/// Largest error of a sharp point, relative to the radius. With a larger one too many of its rays would be unsure.
/// Section 10.
const BLURRED: f64 = 1.0 / (1u64 << 30) as f64;
/// Largest error of a direction that is known well enough: 2^-12, whose square [`SLACK`] has room for. Section 10.
const TILTED: f64 = 1.0 / (1u64 << 12) as f64;

/// In the tree's unit, the longest way whose square is within f64 beside others. Section 10.
const LONG: f64 = 1.0 / SHORT;
/// A limit, in the tree's unit, beyond which a ray ends outside of every sphere that it starts from.
const BEYOND: f64 = LONG * LONG;

/// A point on a sphere of the scene, seen by the camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePoint {
    pub(crate) id: u32,
    pub(crate) ball: Ball,
    /// The point minus the centre, in the tree's unit.
    pub(crate) offset: [f64; 3],
    /// The length of `offset`.
    pub(crate) size: f64,
    /// Bound of the error of `offset`, as a length in the tree's unit.
    pub(crate) blur: f64,
    /// The camera sees the sphere from outside.
    pub(crate) outside: bool,
    /// The unit normal against the viewing ray.
    pub(crate) normal: [f64; 3],
    /// A plane cuts the sphere here: the point is inside of it, and the normal is the plane's.
    pub(crate) is_face: bool,
}

/// The vector from a sphere's centre to a point on it, its length, and the bound of its error, in one unit.
struct Offset {
    offset: [f64; 3],
    size: f64,
    blur: f64,
}

/// The vector from a point to another.
struct Away {
    /// In a unit of 2^-k of the tree's.
    vector: [f64; 3],
    k: i32,
    /// Bound of the error of `vector`, as a length in the same unit.
    error: f64,
}

impl Away {
    /// The vector from the point at `offset` to the one at `from_center + target_offset`, both measured from the centre of the
    /// point's sphere.
    #[inline(always)]
    fn new(k: i32, from_center: [f64; 3], target_offset: [f64; 3], Offset { offset, size, blur }: Offset) -> Self {
        let vector: [f64; 3] = std::array::from_fn(|n| (from_center[n] + target_offset[n]) - offset[n]);
        let length = dot3(vector, vector).sqrt();
        // One rounding each of the difference from the centre, of the sum with `target_offset`, which is no longer than the vector
        // and the offset, and of the vector.
        let first = if target_offset == [0.0; 3] { 0.0 } else { dot3(from_center, from_center).sqrt() };
        Self { vector, k, error: EPS * first + 2.0 * EPS * (length + size) + blur + SHORT }
    }
}

/// A sphere that shines, as a point sees it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shining {
    /// The vector to its centre.
    pub(crate) away: DVec3,
    /// In the same unit.
    pub(crate) radius: f64,
    /// Whether the point is in the sphere or on it; `None` where f64 cannot tell.
    pub(crate) inside: Option<bool>,
}

impl CertifiedRay {
    /// The viewing ray of row `i` and column `j`.
    pub(crate) fn of_pixel(view: &View, placement: &Placement, [i, j]: [u32; 2]) -> Self {
        let direction = view.to_world(view.direction(i, j)).to_array();
        let start = view.to_world(view.origin(i, j)).to_array().map(|x| placement.radius(x));
        let blur = START * dot3(start, start).sqrt();
        // The direction of a curved lens in f64 is its ray.
        let tilt = if view.curved.is_some() { 0.0 } else { DIRECTION };
        Self::new(placement, view.basis.e.to_array(), direction, f64::INFINITY).offset_by(start, blur, tilt)
    }
}

impl SurfacePoint {
    /// The hit of the viewing ray of row `i` and column `j` on this sphere, which it does hit. The point may be too blurred,
    /// see [`Self::is_sharp`].
    pub(crate) fn of_pixel(view: &View, placement: &Placement, [i, j]: [u32; 2], sphere: NumberedBall) -> Self {
        let ray = CertifiedRay::of_pixel(view, placement, [i, j]);
        match ray.intersect(sphere.ball) {
            Some(bounds) => Self::met(&ray, &bounds, sphere),
            None => {
                let p = ray.to(sphere.ball.center);
                let nearest = dot3(p, ray.direction) / ray.a;
                let offset = std::array::from_fn(|n| nearest * ray.direction[n] - p[n]);
                Self::new(sphere, offset, f64::NAN, true)
            }
        }
    }

    /// The hit of a ray on this sphere, within these bounds.
    #[inline(always)]
    pub(crate) fn met(ray: &CertifiedRay, bounds: &Bounds, sphere: NumberedBall) -> Self {
        let p = ray.to(sphere.ball.center);
        let (size, length) = (dot3(p, p).sqrt(), ray.a.sqrt());
        let offset: [f64; 3] = std::array::from_fn(|n| bounds.t * ray.direction[n] - p[n]);
        let along = bounds.t * length;
        // p, t d and their difference take four roundings beside what the start and the direction are off by.
        let blur = (bounds.high - bounds.low) * length
            + (ray.tilt + 3.0 * EPS) * along
            + 4.0 * EPS * (size + dot3(offset, offset).sqrt())
            + ray.blur;
        Self::new(sphere, offset, blur * (1.0 + BLURRED), bounds.outside)
    }

    /// Bound of the error of a viewing ray's direction that is scaled to length 1. Section 10.
    pub(crate) const VIEWING_TILT: f64 = DIRECTION + 4.0 * EPS;

    /// Bound of the error of a mirrored direction of length 1, if the ray's direction has an error of `tilt`. The
    /// reflection d - 2 (d.n) n doubles the normal's error in each of its two factors, and takes ten roundings.
    pub(crate) fn mirrored_tilt(&self, placement: &Placement, tilt: f64) -> f64 {
        let normal = self.blur / placement.radius(self.ball.radius) + 5.0 * EPS;
        (tilt + 4.0 * normal + 10.0 * EPS) * (1.0 + BLURRED)
    }

    /// The ray from here in a direction of length 1 that has an error of up to `tilt`.
    #[inline(always)]
    pub(crate) fn onward(&self, placement: &Placement, along: [f64; 3], tilt: f64) -> CertifiedRay {
        CertifiedRay::in_unit(placement, self.ball.center, along, f64::INFINITY, 0).offset_by(
            self.offset,
            self.blur,
            tilt,
        )
    }

    /// Bounds of the t > 0 at which a ray from here, which goes through the sphere of the point, leaves that sphere.
    /// The power of its start is taken as exactly 0.
    #[inline(always)]
    pub(crate) fn chord(&self, ray: &CertifiedRay) -> Bounds {
        let (along, doubt) = (-2.0 * self.along(ray), 2.0 * self.doubt(ray));
        let relative = 4.0 * EPS + 3.0 * ray.tilt;
        let low = ((along - doubt) / ray.a * (1.0 - relative)).max(0.0);
        let high = ((along + doubt) / ray.a * (1.0 + relative)).max(low);
        Bounds { low, high, t: (along / ray.a).max(low).min(high), sure: along > doubt, outside: false }
    }

    /// The point that the judge gives for the hit of this sphere.
    pub(crate) fn judged(placement: &Placement, truth: &Truth, sphere: NumberedBall) -> Self {
        if truth.root == Root::Face {
            let offset: [f64; 3] =
                std::array::from_fn(|n| placement.difference(truth.position[n], sphere.ball.center[n]));
            let size = placement.radius(truth.position.iter().fold(0.0, |most, x| x.abs().max(most)));
            return Self::new(sphere, offset, 4.0 * EPS * size, true).on_face(truth.normal);
        }
        let outside = truth.root == Root::Near;
        let r = placement.radius(sphere.ball.radius);
        let r = if outside { r } else { -r };
        Self::new(sphere, truth.normal.map(|x| x * r), JUDGED * r.abs(), outside)
    }

    pub(super) fn new(NumberedBall { id, ball }: NumberedBall, offset: [f64; 3], blur: f64, outside: bool) -> Self {
        let size = dot3(offset, offset).sqrt();
        let sign = if outside { 1.0 / size } else { -1.0 / size };
        Self { id, ball, offset, size, blur, outside, normal: offset.map(|x| x * sign), is_face: false }
    }

    /// The same point on a plane that cuts the sphere, with this normal.
    pub(super) fn on_face(self, normal: [f64; 3]) -> Self {
        Self { normal, outside: true, is_face: true, ..self }
    }

    /// Drops the error bound, for answers that are not certified. If rounding let the ray pass the sphere, the point is the one that
    /// is nearest to the ray.
    pub(crate) fn trusted(self, placement: &Placement) -> Self {
        if self.is_face {
            return Self { blur: 0.0, ..self };
        }
        let r = placement.radius(self.ball.radius);
        let sign = if self.outside { r } else { -r };
        Self { offset: self.normal.map(|x| x * sign), size: r, blur: 0.0, ..self }
    }

    /// Whether the error of the point is so small beside the radius that few of its rays are unsure.
    pub(crate) fn is_sharp(&self, placement: &Placement) -> bool {
        let r = placement.radius(self.ball.radius);
        r > SHORT && self.blur <= BLURRED * r
    }

    /// The ray from here, which ends at the light; `None` where its direction is not known well enough for answers.
    #[inline(always)]
    pub(crate) fn ray(&self, placement: &Placement, toward: &Toward) -> Option<CertifiedRay> {
        self.aim(placement, toward).filter(Self::is_known)
    }

    /// Whether the direction of a ray from here is known well enough for answers.
    #[inline(always)]
    pub(crate) fn is_known(ray: &CertifiedRay) -> bool {
        ray.tilt <= TILTED * SLACK
    }

    /// The ray from here, however well its direction is known; `None` for a light at the very point.
    #[inline(always)]
    pub(crate) fn aim(&self, placement: &Placement, toward: &Toward) -> Option<CertifiedRay> {
        let ray = match *toward {
            Toward::Direction(direction) => CertifiedRay::new(placement, self.ball.center, direction, f64::INFINITY),
            Toward::Within { direction, reach } => CertifiedRay::new(placement, self.ball.center, direction, reach),
            Toward::Point(point) => return self.segment(placement, point, [0.0; 3]),
            Toward::OffsetPoint { center, offset } => return self.segment(placement, center, offset),
        };
        Some(ray.offset_by(self.offset, self.blur, 0.0))
    }

    /// The ray from here to the exact sum of two vectors of the world; `None` if f64 cannot tell that point from this
    /// one.
    #[inline(always)]
    fn segment(&self, placement: &Placement, to: [f64; 3], target_offset: [f64; 3]) -> Option<CertifiedRay> {
        let Away { vector, k, error } = self.away(placement, to, target_offset, 0.0);
        let length = dot3(vector, vector).sqrt();
        if length.is_nan() || length <= 0.0 {
            return None;
        }
        let ray = CertifiedRay::in_unit(placement, self.ball.center, vector, 1.0, k);
        Some(ray.offset_by(self.offset, self.blur, error / length))
    }

    /// From here to the exact sum of two vectors of the world, in a unit in which this and `extent` have squares within f64.
    #[inline(always)]
    fn away(&self, placement: &Placement, to: [f64; 3], target_offset: [f64; 3], extent: f64) -> Away {
        let from_center: [f64; 3] = std::array::from_fn(|n| placement.difference(to[n], self.ball.center[n]));
        let scaled_offset = target_offset.map(|x| placement.radius(x));
        let all = from_center.iter().chain(&scaled_offset);
        if all.map(|x| x.abs()).all(|x| x <= LONG) && placement.radius(extent) <= LONG {
            return Away::new(
                0,
                from_center,
                scaled_offset,
                Offset { offset: self.offset, size: self.size, blur: self.blur },
            );
        }
        self.far_away(placement, to, target_offset, extent)
    }

    /// [`Self::away`] where squares of lengths in the tree's unit would overflow.
    #[cold]
    fn far_away(&self, placement: &Placement, to: [f64; 3], target_offset: [f64; 3], extent: f64) -> Away {
        // The difference of halves is within f64. One of the numbers is above 2^500 of the tree's unit, so that what halving
        // takes from subnormal numbers is below 2^-500 of it.
        let from_center: [f64; 3] = std::array::from_fn(|n| 0.5 * to[n] - 0.5 * self.ball.center[n]);
        let half_offset = target_offset.map(|x| 0.5 * x);
        let all = from_center.iter().chain(&half_offset).map(|x| x.abs());
        let e = dd::exponent(all.fold(0.5 * extent, f64::max));
        let scaled = |x: [f64; 3]| x.map(|x| dd::ldexp(x, -e));
        // 2^(e + 1) in the world, where the tree's unit is 2^k.
        let k = placement.k - e - 1;
        let own = |x: f64| dd::ldexp(x, k);
        let point = Offset { offset: self.offset.map(own), size: own(self.size), blur: own(self.blur) };
        Away::new(k, scaled(from_center), scaled(half_offset), point)
    }

    /// The sphere `ball`, which shines, as it is seen from here.
    pub(crate) fn shining(&self, placement: &Placement, ball: Ball) -> Shining {
        let Ball { center, radius } = ball;
        let Away { vector, k, error } = self.away(placement, center, [0.0; 3], radius);
        let r = if k == 0 { placement.radius(radius) } else { dd::ldexp(radius, k - placement.k) };
        let (a2, r2) = (dot3(vector, vector), r * r);
        // The squares, their sum and the difference take four roundings.
        let doubt = 8.0 * EPS * (a2 + r2) + 2.0 * error * (a2.sqrt() + error) * (1.0 + BLURRED) + SHORT * SHORT;
        let inside = match sign(a2 - r2, doubt) {
            _ if ball == self.ball => Some(true),
            AnyHit::Blocked => Some(false),
            AnyHit::Free => Some(true),
            AnyHit::Unsure => None,
        };
        Shining { away: vector.into(), radius: r, inside }
    }

    /// The cosine between the normal and a ray from here, and its sign: `Free` if it is certainly positive, `Blocked`
    /// if it is certainly negative.
    #[inline(always)]
    pub(crate) fn cosine(&self, ray: &CertifiedRay) -> (f64, AnyHit) {
        let along = self.along(ray);
        let side = if self.outside { along } else { -along };
        let size = if self.is_face { 1.0 } else { self.size };
        (side / (size * ray.a.sqrt()), sign(-side, self.doubt(ray)))
    }

    /// Whether the point's own sphere blocks the ray.
    #[inline(always)]
    pub(crate) fn own(&self, ray: &CertifiedRay) -> AnyHit {
        let (along, doubt) = (self.along(ray), self.doubt(ray));
        if self.outside {
            return sign(-along, doubt);
        }
        if ray.limit[0] == f64::INFINITY {
            return AnyHit::Blocked;
        }
        let [low, high] = ray.limit.map(|limit| limit.min(BEYOND));
        if low <= 0.0 {
            return AnyHit::Unsure;
        }
        // The power of the light: positive where the ray ends outside.
        let power = |limit: f64| limit * ray.a + 2.0 * along;
        let doubt = 2.0 * doubt + high * ray.a * (8.0 * EPS + 3.0 * ray.tilt);
        match (sign(power(low), doubt), sign(power(high), doubt)) {
            (a, b) if a == b => a,
            _ => AnyHit::Unsure,
        }
    }

    /// The product of offset, at a face normal, and direction.
    #[inline(always)]
    fn along(&self, ray: &CertifiedRay) -> f64 {
        dot3(if self.is_face { self.normal } else { self.offset }, ray.direction)
    }

    /// Bound of the error of [`Self::along`]: the blur, the tilt, and five roundings; three more of a face's normal.
    #[inline(always)]
    fn doubt(&self, ray: &CertifiedRay) -> f64 {
        if self.is_face {
            return (ray.tilt + 8.0 * EPS) * ray.a.sqrt() * (1.0 + BLURRED);
        }
        ((ray.tilt + 5.0 * EPS) * self.size + self.blur + SHORT) * ray.a.sqrt() * (1.0 + BLURRED)
    }
}

/// The sign of x, which has an error of up to `doubt`: `Blocked` if certainly positive, `Free` if certainly negative.
#[inline(always)]
fn sign(x: f64, doubt: f64) -> AnyHit {
    match x {
        x if x > doubt => AnyHit::Blocked,
        x if x < -doubt => AnyHit::Free,
        _ => AnyHit::Unsure,
    }
}
