//! The quadratic for d of unit length: t = -d.p +- sqrt((d.p)^2 - p.p + r^2). The result t/|d| belongs to the given
//! ray.

use super::Intersect;
use super::roots::closest;
use crate::number::{Arithmetic, Mask, TruthValue};
use crate::view::Sphere;
use crate::view::ray::{Ray, center, dot3, negated, radius};

pub(crate) struct Unit;

impl Intersect for Unit {
    #[inline(always)]
    fn intersect<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>) -> R {
        let p = negated(center(s));
        let length = dot3(ray.d, ray.d).sqrt();
        let d = ray.d.map(|x| x / length);
        let b = dot3(d, p);
        let discriminant = b * b - dot3(p, p) + radius(s) * radius(s);
        let misses = discriminant.less(R::ZERO);
        if !(!misses).any() {
            return R::MISS;
        }
        let root = discriminant.sqrt();
        misses.pick(R::MISS, closest((-b - root) / length, (-b + root) / length))
    }
}
