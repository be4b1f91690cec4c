//! The closest hit among all spheres or among those of a tree: the twin of search/.

use super::tree::lanes::Lanes;
use super::tree::walk::{Test, may_meet, walk};
use super::tree::{BoxRay, MethodRays, Tree};
use crate::intersect::Intersect;
use crate::number::Number;
use crate::view::Sphere;
use crate::view::ray::{Hit, Ray};
use std::marker::PhantomData;

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

/// Keeps the closer hit, and for equal t the lower id: lists and trees are visited in any order.
pub(crate) fn closer_hit_any_order<V: Intersect, R: Number>(
    hit: Hit<R>,
    ray: &Ray<R>,
    s: &Sphere<R>,
    id: u32,
) -> Hit<R> {
    let t = V::intersect(ray, s);
    if t < R::MISS {
        let met = Hit { t: t.scaled(s.scale), id };
        if met.is_before(&hit) {
            return met;
        }
    }
    hit
}

/// The search for the closest hit among the spheres of a tree, in any order.
struct TreeSearch<'a, V, R, L, F> {
    lanes: L,
    tree: &'a Tree,
    rays: &'a MethodRays,
    ray: &'a Ray<R>,
    boxes: BoxRay,
    sphere: F,
    limit: f32,
    hit: Hit<R>,
    place: usize,
    method: PhantomData<V>,
}

impl<V: Intersect, R: Number, L: Lanes, F: Fn(usize) -> Sphere<R>> Test for TreeSearch<'_, V, R, L, F> {
    #[inline(always)]
    fn test(&mut self, block: u32) -> f32 {
        for place in may_meet(self.lanes, self.tree, block, &self.boxes, self.limit) {
            let hit = closer_hit_any_order::<V, R>(self.hit, self.ray, &(self.sphere)(place), self.tree.ids[place]);
            if hit.id != self.hit.id {
                (self.hit, self.place) = (hit, place);
                let (high, low) = hit.t.to_hi_lo();
                self.limit = self.rays.limit(&self.boxes, f64::from(high) + f64::from(low));
            }
        }
        self.limit
    }
}

/// The closest hit among the spheres of `tree`, which `sphere` gives by their places in it, and the place of the sphere
/// that is hit. `boxes` is the ray in the tree. The same answer as that of search/tree.wgsl.
#[inline(always)]
pub(crate) fn nearest_in<V: Intersect, R: Number, L: Lanes>(
    lanes: L,
    (tree, rays): (&Tree, &MethodRays),
    ray: &Ray<R>,
    boxes: BoxRay,
    sphere: impl Fn(usize) -> Sphere<R>,
) -> (Hit<R>, usize) {
    let (hit, limit) = (Hit::NONE, f32::MAX);
    let mut search =
        TreeSearch { lanes, tree, rays, ray, boxes, sphere, limit, hit, place: 0, method: PhantomData::<V> };
    walk(lanes, tree, &boxes, limit, &mut search);
    (search.hit, search.place)
}
