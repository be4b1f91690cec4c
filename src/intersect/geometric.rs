//! The geometric form: t_m, the ray's closest approach to the centre; l_m, its distance there; delta t, half the chord.
//! Computed for d of unit length; the result t/|d| belongs to the given ray.

use super::Intersect;
use super::roots::closest;
use crate::number::{Arithmetic, Mask, TruthValue};
use crate::view::Sphere;
use crate::view::ray::{Ray, center, dot3, negated, radius};

pub(crate) struct Geometric;

impl Intersect for Geometric {
    #[inline(always)]
    fn intersect<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>) -> R {
        let p = negated(center(s));
        let length = dot3(ray.d, ray.d).sqrt();
        let d = ray.d.map(|x| x / length);
        let t_m = -dot3(p, d);
        let l_m2 = dot3(p, p) - t_m * t_m;
        let r2 = radius(s) * radius(s);
        let misses = r2.less(l_m2);
        if !(!misses).any() {
            return R::MISS;
        }
        let delta_t = (r2 - l_m2).sqrt();
        misses.pick(R::MISS, closest((t_m - delta_t) / length, (t_m + delta_t) / length))
    }
}
