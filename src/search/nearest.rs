//! The closest hit of one ray among all spheres. Tests compare eight rays at once with it.

use crate::intersect::Intersect;
use crate::number::Number;
use crate::view::Sphere;
use crate::view::ray::{Hit, Ray};

/// Keeps the closer hit. Spheres are visited in id order and the comparison is strict, so the lower id wins a tie.
fn closer_hit<V: Intersect, R: Number>(hit: Hit<R>, ray: &Ray<R>, s: &Sphere<R>, id: u32) -> Hit<R> {
    let t = V::intersect(ray, s);
    if t < R::MISS {
        let scaled = t.scaled(s.scale);
        if scaled < hit.t {
            return Hit { t: scaled, id };
        }
    }
    hit
}

/// The closest hit of `ray` among `count` spheres, which `sphere` gives by their ids.
pub(crate) fn nearest_of<V: Intersect, R: Number>(
    ray: &Ray<R>,
    count: usize,
    sphere: impl Fn(usize) -> Sphere<R>,
) -> Hit<R> {
    (0..count).fold(Hit::NONE, |hit, id| closer_hit::<V, R>(hit, ray, &sphere(id), id as u32))
}
