//! The CPU reference path: the kernels' stages over rows, in the variant's arithmetic, operation for operation.

mod certified;
mod foremost;
pub(crate) mod given_certified;
mod given_rays;
pub(crate) mod hidden;
pub(crate) mod light;
mod tiles;

use crate::answers::raw::Raw;
use crate::frame::report::CPU_DRIVER;
use crate::intersect::{Intersect, Visit};
use crate::kernel::Kernel;
use crate::number::Number;
use crate::search::nearest::nearest;
use crate::shade::Surface;
use crate::view::ray::{Hit, NONE, Ray, viewing_ray};
use crate::view::{Sphere, View};
use rayon::prelude::*;

pub(crate) use certified::certified;
pub(crate) use given_rays::given_rays;
pub(crate) use tiles::by_tiles;

/// What the reference path is called where an adapter's name is expected.
pub(crate) const NAME: &str = "cpu";

/// The driver's name and version of an adapter: here the reference path and its threads.
pub(crate) fn driver() -> String {
    format!("{CPU_DRIVER}, {} threads", rayon::current_num_threads())
}

/// Fills `raw` by `kernel`'s method. `go_on` is called before every row; after `false` the
/// remaining rows are left unchanged.
pub(crate) fn render(
    kernel: &Kernel,
    view: &View,
    colors: Option<&[[f32; 3]]>,
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    kernel.method.dispatch(Frame { kernel, view, colors, raw, go_on });
}

/// What becomes of a hit: three numbers per pixel.
type Value<'a, R> = &'a (dyn Fn(&Ray<R>, Hit<R>) -> [f32; 3] + Sync);

struct Frame<'a> {
    kernel: &'a Kernel,
    view: &'a View,
    colors: Option<&'a [[f32; 3]]>,
    raw: &'a mut Raw,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Visit for Frame<'_> {
    type Output = ();

    fn visit<V: Intersect>(self) {
        let Self { kernel, view, colors, raw, go_on } = self;
        let spheres: Vec<Sphere<V::Number>> = view.spheres_in(kernel.method.is_wide());
        let surface = Surface { view: &view.record, spheres: &spheres, colors };
        let (record, width) = (&view.record, view.record.columns as usize);
        // Normals of the lecture's forms are computed from t, even if t is not requested.
        raw.t.resize(raw.id.len(), f32::MAX);
        raw.t_low.resize(raw.id.len(), 0.0);
        // Of a row and a column of the window.
        let ray = |i: usize, j: usize| {
            let [i, j] = record.sample_position(record.first_row + i as u32, record.first_column + j as u32);
            viewing_ray::<V::Number>(record, i, j)
        };
        let ts = raw.t.par_chunks_mut(width).zip(raw.t_low.par_chunks_mut(width));
        let rows = raw.id.par_chunks_mut(width).zip(ts).enumerate();
        rows.filter(|_| go_on()).for_each(|(i, (ids, (ts, lows)))| {
            for (j, (id, t)) in ids.iter_mut().zip(ts.iter_mut().zip(lows)).enumerate() {
                let hit = nearest::<V, V::Number>(&ray(i, j), &spheres);
                (*id, (*t.0, *t.1)) = (hit.id, hit.t.to_hi_lo());
            }
        });
        let (id, t, low) = (&raw.id, &raw.t, &raw.t_low);
        let each = |out: &mut [f32], value: Value<'_, V::Number>| {
            out.par_chunks_mut(3 * width).enumerate().for_each(|(i, row)| {
                for (j, out) in row.chunks_exact_mut(3).enumerate() {
                    let pixel = i * width + j;
                    let hit = Hit { t: V::Number::from_hi_lo(t[pixel], low[pixel]), id: id[pixel] };
                    out.copy_from_slice(&value(&ray(i, j), hit));
                }
            });
        };
        if kernel.normal {
            each(&mut raw.normal, &|ray, hit| match hit.id {
                NONE => [0.0; 3],
                _ => surface.world_normal::<V>(ray, hit),
            });
        }
        if let Some(shade) = kernel.shade {
            let [r, g, b, _] = view.record.background;
            each(&mut raw.color, &|ray, hit| match hit.id {
                NONE => [r, g, b],
                _ => surface.shade::<V>(shade, ray, hit),
            });
        }
        if !kernel.method.is_wide() {
            raw.t_low.clear();
        }
    }
}
