//! The twin of the kernels for given rays.

use crate::answers::raw::Raw;
use crate::intersect::{Intersect, Visit};
use crate::kernel::{Kernel, RaySource};
use crate::number::Number;
use crate::search::nearest::{nearest_in, nearest_of};
use crate::search::tree::lanes::{Lanes, TASK, Work, dispatch};
use crate::search::tree::{MethodRays, Tree};
use crate::shade::Surface;
use crate::view::ray::{Hit, NONE, Ray, RayRecord, dot3};
use crate::view::{Sphere, SphereRecord, SphereResiduals, View};
use rayon::prelude::*;
use std::marker::PhantomData;

/// A sphere moved to the origin of a ray; the twin of search/moved_origin.wgsl.
fn moved<R: Number>(s: &SphereRecord, residuals: &SphereResiduals, ray: &RayRecord) -> Sphere<R> {
    let shrink = 1.0 / s.scale;
    let part = |k: usize| [s.center_radius[k], residuals.center_radius[k]];
    let p = [0, 1, 2].map(|k| R::difference(part(k), [ray.origin[k], ray.origin_low[k]], shrink));
    let radius = R::from_hi_lo(s.center_radius[3], residuals.center_radius[3]);
    Sphere {
        center_radius: [p[0], p[1], p[2], radius],
        power: dot3(p, p) - radius * radius,
        scale: R::from_f32(s.scale),
    }
}

/// A tree, and how the rays of a view lie in it.
pub(crate) type InTree<'a> = (&'a Tree, MethodRays);

/// Fills `raw` by the method of `kernel`, for rays given in `view`; with a tree the spheres of the view lie in its order.
pub(crate) fn given_rays(kernel: &Kernel, view: &View, rays: &[RayRecord], tree: Option<InTree<'_>>, raw: &mut Raw) {
    kernel.method.dispatch(Traced { kernel, view, rays, tree, raw });
}

struct Traced<'a> {
    kernel: &'a Kernel,
    view: &'a View,
    rays: &'a [RayRecord],
    tree: Option<InTree<'a>>,
    raw: &'a mut Raw,
}

impl Visit for Traced<'_> {
    type Output = ();

    fn visit<V: Intersect>(self) {
        let Self { kernel, view, rays, tree, raw } = self;
        let spheres: Vec<Sphere<V::Number>> = view.spheres_in(kernel.method.is_wide());
        let sphere_of = |ray: &RayRecord, place: usize| match kernel.rays {
            RaySource::Spread => moved(&view.spheres[place], &view.residuals[place], ray),
            _ => spheres[place],
        };
        raw.t_low.resize(raw.id.len(), 0.0);
        // Places in the view instead of ids, until the normals are made.
        let ts = raw.t.par_chunks_mut(TASK).zip(raw.t_low.par_chunks_mut(TASK));
        let tasks = raw.id.par_chunks_mut(TASK).zip(ts).zip(rays.par_chunks(TASK));
        tasks.for_each(|((places, (ts, lows)), rays)| {
            let out = places.iter_mut().zip(ts.iter_mut().zip(lows)).zip(rays);
            let Some((tree, in_tree)) = &tree else {
                for ((place, t), r) in out {
                    let hit = nearest_of::<V, _>(&direction(r), spheres.len(), |k| sphere_of(r, k));
                    (*place, (*t.0, *t.1)) = (hit.id, hit.t.to_hi_lo());
                }
                return;
            };
            dispatch(Task::<V, _, _> { tree, rays: in_tree, out, sphere_of: &sphere_of, method: PhantomData });
        });
        if kernel.normal {
            let hits = raw.id.par_iter().zip(raw.t.par_iter().zip(&raw.t_low)).zip(rays);
            raw.normal.par_chunks_exact_mut(3).zip(hits).for_each(|(out, ((&place, (&t, &low)), r))| {
                if place != NONE {
                    let own = [sphere_of(r, place as usize)];
                    let hit = Hit { t: V::Number::from_hi_lo(t, low), id: 0 };
                    let surface = Surface { view: &view.record, spheres: &own, colors: None };
                    out.copy_from_slice(&surface.world_normal::<V>(&direction(r), hit));
                }
            });
        }
        raw.id
            .par_iter_mut()
            .filter(|place| **place != NONE)
            .for_each(|place| *place = view.spheres[*place as usize].id);
        if !kernel.method.is_wide() {
            raw.t_low.clear();
        }
    }
}

/// The direction in the arithmetic of a twin.
fn direction<R: Number>(r: &RayRecord) -> Ray<R> {
    let low = [r.direction[3], r.origin[3], r.origin_low[3]];
    Ray { d: std::array::from_fn(|k| R::from_hi_lo(r.direction[k], low[k])) }
}

/// The places where the hits of some rays are written, and the rays.
struct Task<'a, V, O, F> {
    tree: &'a Tree,
    rays: &'a MethodRays,
    out: O,
    sphere_of: &'a F,
    method: PhantomData<V>,
}

/// Place and both parts of t, and the ray.
type Place<'a> = ((&'a mut u32, (&'a mut f32, &'a mut f32)), &'a RayRecord);

impl<'a, V, O, F> Work for Task<'_, V, O, F>
where
    V: Intersect,
    O: Iterator<Item = Place<'a>>,
    F: Fn(&RayRecord, usize) -> Sphere<V::Number>,
{
    #[inline(always)]
    fn work<L: Lanes>(self, lanes: L) {
        let Self { tree, rays, out, sphere_of, .. } = self;
        for ((place, t), r) in out {
            let Some(boxes) = rays.ray(r) else {
                (*place, (*t.0, *t.1)) = (NONE, Hit::<V::Number>::NONE.t.to_hi_lo());
                continue;
            };
            let ray = direction(r);
            let (hit, at) = nearest_in::<V, _, L>(lanes, (tree, rays), &ray, boxes, |k| sphere_of(r, k));
            (*place, (*t.0, *t.1)) = (if hit.id == NONE { NONE } else { at as u32 }, hit.t.to_hi_lo());
        }
    }
}
