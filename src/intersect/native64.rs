//! The perpendicular form in f64, native on both sides: the code of [`Stable`] with another number type.

use super::Intersect;
use super::stable::Stable;
use crate::number::{Arithmetic, Number};
use crate::view::Sphere;
use crate::view::ray::Ray;

pub(crate) struct Native64;

impl Intersect for Native64 {
    type Number = f64;

    #[inline(always)]
    fn intersect<R: Arithmetic>(ray: &Ray<R>, s: &Sphere<R>) -> R {
        Stable::intersect(ray, s)
    }

    fn normal_at<R: Number>(ray: &Ray<R>, s: &Sphere<R>, t: R) -> [R; 3] {
        Stable::normal_at(ray, s, t)
    }
}
