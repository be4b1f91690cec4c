//! The CPU reference path: the kernels' stages over rows, in the variant's arithmetic, operation for operation. Hits are
//! found for eight pixels at once.

mod certified;
mod foremost;
pub(crate) mod given_certified;
pub(crate) mod given_cuts;
mod given_rays;
pub(crate) mod hidden;
pub(crate) mod light;

use crate::answers::raw::Raw;
use crate::frame::report::CPU_DRIVER;
use crate::intersect::{Intersect, Visit};
use crate::kernel::{Kernel, RaySource, Task};
use crate::number::Number;
use crate::number::vector::{LANES, Laned};
use crate::search::eight::{EightHits, spheres_together, together};
use crate::shade::{Shade, color_of, to_world};
use crate::view::ray::{Hit, NONE, Ray, RayRecord, viewing_ray};
use crate::view::{Sphere, View, ViewRecord};
use given_rays::{direction, moved};
use halfline_ground::parallel::{self, Rows};
use pulp::NullaryFnOnce;
use std::marker::PhantomData;

pub(crate) use certified::certified;

/// Name of the CPU path where an adapter's name is expected.
pub(crate) const NAME: &str = "cpu";

/// The driver's name and version of an adapter: here the reference path and its threads.
pub(crate) fn driver() -> String {
    format!("{CPU_DRIVER}, {} threads", parallel::threads())
}

/// Fills `raw` by `kernel`'s method, all spheres for every ray: the rays of the window, unless some are given. `go_on` is called
/// before every row; after `false` the remaining rows are left unchanged.
pub(crate) fn render(
    kernel: &Kernel,
    view: &View,
    rays: Option<&[RayRecord]>,
    colors: Option<&[[f32; 3]]>,
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    kernel.arithmetic().dispatch(Frame { kernel, view, rays, colors, raw, go_on });
}

/// Three numbers per pixel, from the hit of a sphere.
type Value<'a, R> = &'a (dyn Fn(&Ray<R>, &Sphere<R>, Hit<R>) -> [f32; 3] + Sync);

struct Frame<'a> {
    kernel: &'a Kernel,
    view: &'a View,
    rays: Option<&'a [RayRecord]>,
    colors: Option<&'a [[f32; 3]]>,
    raw: &'a mut Raw,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Visit for Frame<'_> {
    type Output = ();

    fn visit<V: Intersect, N: Laned>(self) {
        let Self { kernel, view, rays, colors, raw, go_on } = self;
        let record = &view.record;
        let spread = matches!(kernel.task, Task::Method { rays: RaySource::Spread, .. });
        let width = rays.map_or(record.columns as usize, |_| LANES);
        let spheres = view.spheres_in(kernel.is_wide());
        let scene = MethodScene::<N> { view, spheres, rays, spread, width };
        // Normals of the lecture's forms are computed from t, even if t is not requested.
        raw.t.resize(raw.id.len(), f32::MAX);
        raw.t_low.resize(raw.id.len(), 0.0);
        let ts = (Rows { values: &mut raw.t, each: width }, Rows { values: &mut raw.t_low, each: width });
        let arch = pulp::Arch::new();
        parallel::fill((Rows { values: &mut raw.id, each: width }, ts), 1, &|row, (ids, (ts, lows))| {
            if go_on() {
                let (ids, ts, lows) = (ids.values, ts.values, lows.values);
                arch.dispatch(Row::<V, N> { scene: &scene, i: row.start, ids, ts, lows, form: PhantomData });
            }
        });
        let (id, t, low) = (&raw.id, &raw.t, &raw.t_low);
        let each = |out: &mut [f32], miss: [f32; 3], value: Value<'_, N>| {
            parallel::chunks(out, 3 * width, &|i, row| {
                for (j, out) in row.chunks_exact_mut(3).enumerate() {
                    let pixel = i * width + j;
                    let hit = Hit { t: N::from_hi_lo(t[pixel], low[pixel]), id: id[pixel] };
                    let value = match hit.id {
                        NONE => miss,
                        id => value(&scene.ray(i, j), &scene.sphere(i, j, id as usize), hit),
                    };
                    out.copy_from_slice(&value);
                }
            });
        };
        // In the canonical camera, against the ray; f32 from here on.
        let normal = |ray: &Ray<N>, s: &Sphere<N>, t: N| V::normal_at(ray, s, t / s.scale).map(|x| x.to_hi_lo().0);
        if kernel.normal {
            each(&mut raw.normal, [0.0; 3], &|ray, s, hit| to_world(record, normal(ray, s, hit.t)));
        }
        if let Some(shade) = kernel.shade {
            let [r, g, b, _] = record.background;
            each(&mut raw.color, [r, g, b], &|ray, s, hit| match (shade, color_of(colors, hit.id)) {
                (Shade::Flat, own) => own,
                (_, own) => shade.of(record, ray.d.map(|x| x.to_hi_lo().0), normal(ray, s, hit.t), own),
            });
        }
        if !kernel.is_wide() {
            raw.t_low.clear();
        }
    }
}

/// The rays of a method and the spheres that they test.
struct MethodScene<'a, N> {
    view: &'a View,
    spheres: Vec<Sphere<N>>,
    /// Given rays; else the rays of the window.
    rays: Option<&'a [RayRecord]>,
    /// The spheres are moved to the origin of each ray.
    spread: bool,
    /// Rays of a row.
    width: usize,
}

impl<N: Laned> MethodScene<'_, N> {
    /// The given ray in a row and a column; beyond all of them the last.
    #[inline(always)]
    fn given(&self, i: usize, j: usize) -> Option<&RayRecord> {
        self.rays.map(|rays| &rays[(i * self.width + j).min(rays.len() - 1)])
    }

    #[inline(always)]
    fn ray(&self, i: usize, j: usize) -> Ray<N> {
        self.given(i, j).map_or_else(|| ray_of(&self.view.record, i, j), direction)
    }

    /// A sphere as that ray sees it.
    #[inline(always)]
    fn sphere(&self, i: usize, j: usize, id: usize) -> Sphere<N> {
        match self.given(i, j) {
            Some(ray) if self.spread => moved(&self.view.spheres[id], &self.view.residuals[id], ray),
            _ => self.spheres[id],
        }
    }
}

/// The ray of a row and a column of the window.
#[inline(always)]
fn ray_of<R: Number>(view: &ViewRecord, i: usize, j: usize) -> Ray<R> {
    let [i, j] = view.sample_position(view.first_row + i as u32, view.first_column + j as u32);
    viewing_ray(view, i, j)
}

/// A row of rays and the places of its hits.
struct Row<'a, V, N> {
    scene: &'a MethodScene<'a, N>,
    i: usize,
    ids: &'a mut [u32],
    ts: &'a mut [f32],
    lows: &'a mut [f32],
    form: PhantomData<V>,
}

impl<V: Intersect, N: Laned> NullaryFnOnce for Row<'_, V, N> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { scene, i, ids, ts, lows, .. } = self;
        let strips = ids.chunks_mut(LANES).zip(ts.chunks_mut(LANES).zip(lows.chunks_mut(LANES)));
        for (first, (ids, (ts, lows))) in (0..).step_by(LANES).zip(strips) {
            // Rays beyond the row are computed too; their hits are not written.
            let rays = together(&std::array::from_fn(|l| scene.ray(i, first + l)));
            let own = |id| spheres_together(&std::array::from_fn(|l| scene.sphere(i, first + l, id)));
            let hits = match scene.spread {
                true => EightHits::<N>::among_all::<V>(&rays, (0..scene.spheres.len()).map(own)),
                false => EightHits::among_all::<V>(&rays, scene.spheres.iter().map(|s| s.map(N::splat))),
            };
            for (l, (id, (t, low))) in ids.iter_mut().zip(ts.iter_mut().zip(lows)).enumerate() {
                (*id, (*t, *low)) = (hits.id.0[l], N::lane(&hits.t, l).to_hi_lo());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect::Method;
    use crate::search::nearest::nearest_of;
    use crate::window::Window;
    use halfline_ground::memory::Pool;

    /// A window of weekend whose width is no multiple of eight, against single rays.
    struct Compare<'a>(&'a View, Method);

    impl Visit for Compare<'_> {
        type Output = usize;

        fn visit<V: Intersect, N: Laned>(self) -> usize {
            let Self(view, method) = self;
            let kernel = Kernel { t: true, ..Kernel::of_method(method) };
            let mut raw = Raw::new(&kernel, view.record.pixels(), &Pool::default()).expect("room");
            render(&kernel, view, None, None, &mut raw, &|| true);
            let spheres: Vec<Sphere<N>> = view.spheres_in(method.is_wide());
            let width = view.record.columns as usize;
            for pixel in 0..raw.id.len() {
                let ray = ray_of(&view.record, pixel / width, pixel % width);
                let hit = nearest_of::<V, _>(&ray, spheres.len(), |id| spheres[id]);
                let (high, low) = hit.t.to_hi_lo();
                let found = (raw.id[pixel], raw.t[pixel].to_bits(), raw.t_low.get(pixel).map(|x| x.to_bits()));
                let low = method.is_wide().then(|| low.to_bits());
                assert_eq!(found, (hit.id, high.to_bits(), low), "{}, pixel {pixel}", method.name());
            }
            raw.id.iter().filter(|id| **id != NONE).count()
        }
    }

    #[test]
    fn rows_of_any_width_are_answered_as_single_rays() {
        let scene = crate::testing::weekend([64, 36]);
        for width in [3, 8, 21] {
            let window = Window { x0: 30, y0: 12, x1: 30 + width, y1: 21 };
            let raster = crate::view::raster::Raster::centres(window);
            let view = View::for_rays(&scene, raster, Kernel::of_method(Method::Native64).records()).expect("a view");
            for method in Method::ALL {
                let hits = method.dispatch(Compare(&view, *method));
                assert!(hits > width as usize, "{}: {hits} hits", method.name());
            }
        }
    }
}
