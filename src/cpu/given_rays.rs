//! The twin of the kernels for given rays.

use crate::answers::raw::Raw;
use crate::intersect::{Intersect, Visit};
use crate::kernel::{Kernel, RaySource, Task};
use crate::number::Number;
use crate::number::vector::Laned;
use crate::search::nearest::nearest_of;
use crate::shade::Surface;
use crate::view::ray::{Hit, NONE, Ray, RayRecord, dot3};
use crate::view::{Sphere, SphereRecord, SphereResiduals, View};
use rayon::prelude::*;

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

/// Fills `raw` by the method of `kernel`, for rays given in `view`.
pub(crate) fn given_rays(kernel: &Kernel, view: &View, rays: &[RayRecord], raw: &mut Raw) {
    kernel.arithmetic().dispatch(Traced { kernel, view, rays, raw });
}

struct Traced<'a> {
    kernel: &'a Kernel,
    view: &'a View,
    rays: &'a [RayRecord],
    raw: &'a mut Raw,
}

impl Visit for Traced<'_> {
    type Output = ();

    fn visit<V: Intersect, N: Laned>(self) {
        let Self { kernel, view, rays, raw } = self;
        let spheres: Vec<Sphere<N>> = view.spheres_in(kernel.is_wide());
        let sphere_of = |ray: &RayRecord, id: usize| match kernel.task {
            Task::Method { rays: RaySource::Spread, .. } => moved(&view.spheres[id], &view.residuals[id], ray),
            _ => spheres[id],
        };
        raw.t_low.resize(raw.id.len(), 0.0);
        let ts = raw.t.par_iter_mut().zip(&mut raw.t_low);
        raw.id.par_iter_mut().zip(ts).zip(rays).for_each(|((id, (t, low)), r)| {
            let hit = nearest_of::<V, _>(&direction(r), spheres.len(), |k| sphere_of(r, k));
            (*id, (*t, *low)) = (hit.id, hit.t.to_hi_lo());
        });
        if kernel.normal {
            let hits = raw.id.par_iter().zip(raw.t.par_iter().zip(&raw.t_low)).zip(rays);
            raw.normal.par_chunks_exact_mut(3).zip(hits).for_each(|(out, ((&id, (&t, &low)), r))| {
                if id != NONE {
                    let own = [sphere_of(r, id as usize)];
                    let hit = Hit { t: N::from_hi_lo(t, low), id: 0 };
                    let surface = Surface { view: &view.record, spheres: &own, colors: None };
                    out.copy_from_slice(&surface.world_normal::<V>(&direction(r), hit));
                }
            });
        }
        if !kernel.is_wide() {
            raw.t_low.clear();
        }
    }
}

/// The direction in the arithmetic of a twin.
fn direction<R: Number>(r: &RayRecord) -> Ray<R> {
    let low = [r.direction[3], r.origin[3], r.origin_low[3]];
    Ray { d: std::array::from_fn(|k| R::from_hi_lo(r.direction[k], low[k])) }
}
