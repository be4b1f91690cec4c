//! The closest hit among all spheres, or among those of a tree: the twin of search/.

use crate::intersect::Intersect;
use crate::number::Number;
use crate::ray::{Hit, Ray};
use crate::tree::{NOWHERE, STACK, Slabs, Tree, leaf};
use crate::view::Sphere;

/// Keeps the closer hit. Spheres come in the order of their ids and the comparison is strict, so an equal t stays with
/// the lower id.
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

/// The same for spheres that are moved for each ray.
pub(crate) fn nearest_of<V: Intersect, R: Number>(
    ray: &Ray<R>,
    count: usize,
    sphere: impl Fn(usize) -> Sphere<R>,
) -> Hit<R> {
    (0..count).fold(Hit::NONE, |hit, id| closer_hit::<V, R>(hit, ray, &sphere(id), id as u32))
}

/// Keeps the closer hit, and of an equal t the lower id: the spheres of lists and trees come in any order.
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

/// The closest hit among the spheres of `tree`: the nearer box first, and none behind the hit that is already there. A
/// box as near as the hit is still opened, for the lower id may be in it. The twin of search/tree.wgsl.
pub(crate) fn nearest_in<V: Intersect, R: Number>(
    ray: &Ray<R>,
    slabs: &Slabs,
    tree: &Tree,
    sphere: impl Fn(usize) -> Sphere<R>,
) -> Hit<R> {
    // Rounded where R holds more; the boxes' padding is larger than that.
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
