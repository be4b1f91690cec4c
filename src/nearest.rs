//! The closest hit among all spheres: the twin of nearest/.

use crate::intersect::Intersect;
use crate::ray::{Hit, Ray};
use crate::real::Real;
use crate::view::Sphere;

/// Keeps the closer hit. Spheres come in the order of their ids and the comparison is strict, so an equal t stays with
/// the lower id.
fn consider<V: Intersect, R: Real>(hit: Hit<R>, ray: &Ray<R>, s: &Sphere<R>, id: u32) -> Hit<R> {
    let t = V::intersect(ray, s);
    if t < R::MISS {
        let scaled = t.scaled(s.scale);
        if scaled < hit.t {
            return Hit { t: scaled, id };
        }
    }
    hit
}

/// The closest hit of `ray` among `spheres`.
pub(crate) fn nearest<V: Intersect, R: Real>(ray: &Ray<R>, spheres: &[Sphere<R>]) -> Hit<R> {
    (0..).zip(spheres).fold(Hit::NONE, |hit, (id, s)| consider::<V, R>(hit, ray, s, id))
}

/// The same for spheres that are moved for each ray.
pub(crate) fn nearest_of<V: Intersect, R: Real>(
    ray: &Ray<R>,
    count: usize,
    sphere: impl Fn(usize) -> Sphere<R>,
) -> Hit<R> {
    (0..count).fold(Hit::NONE, |hit, id| consider::<V, R>(hit, ray, &sphere(id), id as u32))
}
