//! Intersection forms with candidate lists on the CPU path: the twin of search/tile.wgsl. A sphere of a tile is
//! translated into the camera's frame when the first ray of the tile needs it, once for all 64 rays.

use crate::answers::raw::Raw;
use crate::intersect::{Intersect, Visit};
use crate::kernel::Kernel;
use crate::number::Number;
use crate::search::nearest::closer_hit_any_order;
use crate::search::tile_candidates::TileCandidates;
use crate::shade::Surface;
use crate::tile::{CHUNK, TILE};
use crate::view::Sphere;
use crate::view::ray::{Hit, NONE, Ray, viewing_ray};
use rayon::prelude::*;
use std::ops::Range;

/// Fills `raw` by `kernel`'s method. `go_on` is called before every row of tiles; after `false` the remaining rows are
/// left unchanged.
pub(crate) fn by_tiles(
    kernel: &Kernel,
    tile_candidates: &TileCandidates<'_>,
    colors: Option<&[[f32; 3]]>,
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    kernel.method.dispatch(Frame { kernel, tile_candidates, colors, raw, go_on });
}

struct Frame<'a> {
    kernel: &'a Kernel,
    tile_candidates: &'a TileCandidates<'a>,
    colors: Option<&'a [[f32; 3]]>,
    raw: &'a mut Raw,
    go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Visit for Frame<'_> {
    type Output = ();

    fn visit<V: Intersect>(self) {
        let Self { kernel, tile_candidates, colors, raw, go_on } = self;
        let view = &tile_candidates.view.record;
        let width = view.columns as usize;
        let surface = Surface::<V::Number> { view, spheres: &[], colors };
        let generals: Vec<_> =
            tile_candidates.binned.generals.iter().map(|near| candidate(tile_candidates, near.id)).collect();
        let [[left, right], [top, _]] = view.tiles();
        let columns = view.first_column..view.first_column + view.columns;
        let foremost = (top + 1) * TILE - view.first_row;
        let bands: Vec<_> = raw.cut(foremost as usize * width, TILE as usize * width).collect();
        let empty = || Tile::<V::Number> { tile_candidates, generals: &generals, entries: 0..0, made: Vec::new() };
        let bands = bands.into_par_iter().enumerate().filter(|_| go_on());
        bands.for_each_init(empty, |tile, (band, mut rows)| {
            let first = view.first_row.max((top + band as u32) * TILE);
            let count = rows.id.len() / width;
            for left in (left..=right).map(|tile| tile * TILE) {
                tile.enter(first, left);
                for i in 0..count {
                    for j in columns.start.max(left)..columns.end.min(left + TILE) {
                        let [row, column] = view.sample_position(first + i as u32, j);
                        let ray = viewing_ray(view, row, column);
                        let (hit, s) = tile.nearest::<V>(&ray);
                        let pixel = i * width + (j - columns.start) as usize;
                        rows.id[pixel] = hit.id;
                        let parts = hit.t.to_hi_lo();
                        rows.t.get_mut(pixel).into_iter().for_each(|t| *t = parts.0);
                        rows.t_low.get_mut(pixel).into_iter().for_each(|low| *low = parts.1);
                        let normal = |s: Sphere<V::Number>| match kernel.has_normals() {
                            true => V::normal_at(&ray, &s, hit.t / s.scale).map(|x| x.to_hi_lo().0),
                            false => [0.0; 3],
                        };
                        rows.shade(pixel, kernel.shade, &surface, || ray, s.map(|s| (normal(s), hit.id)));
                    }
                }
            }
        });
    }
}

/// A sphere and its id.
type Candidate<R> = (Sphere<R>, u32);

fn candidate<R: Number>(tile_candidates: &TileCandidates<'_>, id: u32) -> Candidate<R> {
    (tile_candidates.sphere(id), id)
}

/// The candidates of one tile.
struct Tile<'a, R> {
    tile_candidates: &'a TileCandidates<'a>,
    generals: &'a [Candidate<R>],
    entries: Range<usize>,
    /// The translated spheres, a prefix of the tile's list.
    made: Vec<Candidate<R>>,
}

impl<R: Number> Tile<'_, R> {
    /// Moves to the tile that contains the pixel at `row` and `column`.
    fn enter(&mut self, row: u32, column: u32) {
        let [first, end] = self.tile_candidates.binned.lists.range(row, column).map(|n| n as usize);
        if self.entries != (first..end) {
            self.entries = first..end;
            self.made.clear();
        }
    }

    /// The closest hit and its sphere: the twin of search/tile.wgsl.
    fn nearest<V: Intersect>(&mut self, ray: &Ray<R>) -> (Hit<R>, Option<Sphere<R>>) {
        let mut found = (Hit::NONE, None);
        closest_of::<V, R>(&mut found, ray, self.generals);
        let Range { start, end } = self.entries;
        for first in (start..end).step_by(CHUNK) {
            if found.0.t.to_hi_lo().0 < self.tile_candidates.limit(first / CHUNK) {
                break;
            }
            let from = first - start;
            if from == self.made.len() {
                let chunk = self.tile_candidates.ids(first..first + CHUNK);
                // Skips the padding at the end of the list.
                self.made.extend(chunk.filter(|id| *id != NONE).map(|id| candidate(self.tile_candidates, id)));
            }
            let to = self.made.len().min(from + CHUNK);
            closest_of::<V, R>(&mut found, ray, &self.made[from..to]);
        }
        found
    }
}

/// Keeps the closest hit, and the lower id for equal t, because lists are not in id order.
fn closest_of<V: Intersect, R: Number>(
    found: &mut (Hit<R>, Option<Sphere<R>>),
    ray: &Ray<R>,
    candidates: &[Candidate<R>],
) {
    for (s, id) in candidates {
        let met = closer_hit_any_order::<V, R>(found.0, ray, s, *id);
        if met != found.0 {
            *found = (met, Some(*s));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::TERMS;
    use crate::certify::binned::BinnedScene;
    use crate::intersect::Method;
    use crate::memory::Pool;
    use crate::read::ReadOptions;
    use crate::render::plan::Plan;
    use crate::scene::Scene;
    use crate::settings::Settings;
    use crate::view::View;

    /// Checks that tests/answers/tiles.rs detects a list that lacks one sphere.
    #[test]
    fn a_sphere_missing_from_a_list_is_found() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.toml");
        let mut scene = Scene::read(&path, &ReadOptions::default()).expect("weekend");
        (scene.image.width, scene.image.height) = (131, 74);
        let (view, pool) = (View::new(&scene).expect("a view"), Pool::default());
        let mut binned =
            BinnedScene::new(&scene, &view, 1e-5, &TERMS, 0, &pool).expect("a stage").expect("a projection");
        let settings = Settings { method: Some(Method::Stable), ..Settings::default() };
        let kernel = Kernel { tiles: true, ..Plan::for_method(&settings).expect("a plan").kernel };
        let ids = |binned: &BinnedScene| {
            let mut raw = Raw::new(&kernel, 131 * 74, &pool).expect("room");
            by_tiles(
                &kernel,
                &TileCandidates::new(&view, &scene.spheres, binned, false, &pool),
                None,
                &mut raw,
                &|| true,
            );
            raw.id
        };
        let mut all = Raw::new(&kernel, 131 * 74, &pool).expect("room");
        crate::cpu::render(&kernel, &view, None, &mut all, &|| true);
        let before = ids(&binned);
        assert_eq!(before, all.id);
        let is_general = |id: u32| binned.generals.iter().any(|general| general.id == id);
        let pixel = before.iter().position(|id| *id != NONE && !is_general(*id)).expect("a sphere in a list");
        let [first, end] = binned.lists.range(pixel as u32 / 131, pixel as u32 % 131).map(|n| n as usize);
        let entry = (first..end).find(|n| binned.lists.details[*n].id == before[pixel]).expect("it is in the list");
        // Replaces an entry of the list by a general sphere, which every ray tests anyway.
        binned.lists.details[entry].id = binned.generals[0].id;
        let after = ids(&binned);
        assert!(after != before && after[pixel] != before[pixel]);
    }
}
