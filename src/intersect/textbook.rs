//! The general quadratic: |p + t d|^2 = r^2 with p from the centre to the ray's origin, d of any length.

use super::Intersect;
use super::roots::closest;
use crate::number::{Arithmetic, Mask, TruthValue};
use crate::view::Sphere;
use crate::view::ray::{Ray, center, dot3, negated, radius};

pub(crate) struct Textbook;

impl Intersect for Textbook {
    #[inline(always)]
    fn intersect<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>) -> R {
        let p = negated(center(s));
        let a = dot3(ray.d, ray.d);
        let b = dot3(ray.d, p);
        let c = dot3(p, p) - radius(s) * radius(s);
        let discriminant = b * b - a * c;
        let misses = discriminant.less(R::ZERO);
        if !(!misses).any() {
            return R::MISS;
        }
        let root = discriminant.sqrt();
        misses.pick(R::MISS, closest((-b - root) / a, (-b + root) / a))
    }
}
