//! The closest hit among all spheres or among those of a tree: the twin of search/.

use super::tree::{NOWHERE, STACK, Slabs, Tree, leaf};
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

/// The closest hit of `ray` among `spheres`.
pub(crate) fn nearest<V: Intersect, R: Number>(ray: &Ray<R>, spheres: &[Sphere<R>]) -> Hit<R> {
    (0..).zip(spheres).fold(Hit::NONE, |hit, (id, s)| closer_hit::<V, R>(hit, ray, s, id))
}

/// The same for spheres that are translated for each ray.
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

/// The closest hit among the spheres of `tree`. The nearer child is visited first, and boxes behind the current hit are
/// skipped. A box at the same distance as the hit is visited, since it may hold a lower id. The twin of
/// search/tree.wgsl.
pub(crate) fn nearest_in<V: Intersect, R: Number>(
    ray: &Ray<R>,
    slabs: &Slabs,
    tree: &Tree,
    sphere: impl Fn(usize) -> Sphere<R>,
) -> Hit<R> {
    // Rounded to f32 if R is wider; the padding of the boxes is larger than this error.
    let reach = |hit: &Hit<R>| hit.t.to_hi_lo().0;
    let mut waiting = [(0.0, 0); STACK as usize];
    let mut depth = 0;
    let mut hit = Hit::NONE;
    let mut link = 0;
    loop {
        if let Some(leaf) = leaf(link) {
            for &id in &tree.order[leaf] {
                hit = closer_hit_any_order::<V, R>(hit, ray, &sphere(id as usize), id);
            }
            link = NOWHERE;
        } else {
            let node = &tree.nodes[link as usize];
            let a = (slabs.entry(node.low_a, node.high_a), node.low_a[3]);
            let b = (slabs.entry(node.low_b, node.high_b), node.low_b[3]);
            let (near, far) = if b.0 < a.0 { (b, a) } else { (a, b) };
            let open = |entry: f32| entry < f32::MAX && entry <= reach(&hit);
            if open(far.0) {
                waiting[depth] = far;
                depth += 1;
            }
            link = if open(near.0) { near.1 } else { NOWHERE };
        }
        while link == NOWHERE {
            if depth == 0 {
                return hit;
            }
            depth -= 1;
            if waiting[depth].0 <= reach(&hit) {
                link = waiting[depth].1;
            }
        }
    }
}
