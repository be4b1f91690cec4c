//! The perpendicular form. With p from the ray's origin to the centre, g = p x d and Lagrange's identity (p.d)^2 =
//! |p|^2 |d|^2 - |g|^2, the discriminant is a r^2 - g.g, which avoids the difference of two large squares. The power of
//! the origin, c = |p|^2 - r^2, comes from the host. One root is computed from the sum q that does not
//! cancel, as q/a; the other is c/q.
//!
//! Sources: Hearn and Baker's discriminant as in Haines, Guenther, Akenine-Moeller, *Precision improvements for
//! ray/sphere intersection*, Ray Tracing Gems (2019); the matched root as in any text on quadratics since Forsythe.

use super::Intersect;
use crate::number::{Arithmetic, Mask, Number, TruthValue};
use crate::view::Sphere;
use crate::view::ray::{Ray, center, cross3, dot3, minus, negated, positive, radius, times, unit3};

pub(crate) struct Stable;

#[inline(always)]
fn discriminant<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>, g: [R; 3]) -> R {
    dot3(ray.d, ray.d) * (radius(s) * radius(s)) - dot3(g, g)
}

impl Intersect for Stable {
    #[inline(always)]
    fn intersect<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>) -> R {
        let p = center(s);
        let g = cross3(p, ray.d);
        let disc = discriminant(ray, s, g);
        let misses = disc.less(R::ZERO);
        if !(!misses).any() {
            return R::MISS;
        }
        let b = dot3(p, ray.d);
        let root = disc.sqrt();
        // The sum that does not cancel, for a centre ahead and one behind; then c/q and q/a are the roots.
        let ahead = R::ZERO.less(b);
        let q = ahead.pick(b + root, b - root);
        let (outside, inside) = (R::ZERO.less(s.power), s.power.less(R::ZERO));
        let by_power = s.power / q;
        let t = ahead.pick(outside.pick(by_power, q / dot3(ray.d, ray.d)), inside.pick(by_power, R::MISS));
        misses.pick(R::MISS, t)
    }

    /// From the perpendicular and half the chord: |d|^2 (t d - p) = -(d x g) -+ sqrt(D) d, with the upper sign outside.
    /// There is no cancellation at any distance; t is not used.
    fn normal_at<R: Number>(ray: &Ray<R>, s: &Sphere<R>, _t: R) -> [R; 3] {
        let g = cross3(center(s), ray.d);
        let root = positive(discriminant(ray, s, g)).sqrt();
        let across = cross3(ray.d, g);
        let side = if s.power > R::ZERO { negated(across) } else { across };
        unit3(minus(side, times(root, ray.d)))
    }
}
