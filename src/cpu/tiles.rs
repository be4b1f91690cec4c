//! Intersection forms with candidate lists on the CPU path: the twin of search/tile.wgsl. A sphere of a tile is
//! translated into the camera's frame when the first ray of the tile needs it, once for all 64 rays. Eight rays are
//! computed together.

use crate::answers::raw::{Piece, Raw};
use crate::intersect::{Intersect, Visit};
use crate::kernel::Kernel;
use crate::number::vector::{LANES, Laned, Vector};
use crate::number::{Number, TruthValue};
use crate::search::eight::{EightHits, together};
use crate::search::tile_candidates::TileCandidates;
use crate::shade::Surface;
use crate::tile::{CHUNK, TILE};
use crate::view::ray::{Hit, NONE, Ray, viewing_ray};
use crate::view::{Sphere, ViewRecord};
use pulp::NullaryFnOnce;
use rayon::prelude::*;
use std::ops::Range;

/// A vector holds the pixels of one row of a tile.
const _: () = assert!(LANES == TILE as usize);

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
        let arch = pulp::Arch::new();
        bands.for_each_init(empty, |tile, (band, mut rows)| {
            let first = view.first_row.max((top + band as u32) * TILE);
            let count = (rows.id.len() / width) as u32;
            for left in (left..=right).map(|tile| tile * TILE) {
                tile.enter(first, left);
                for row in 0..count {
                    let strip = arch.dispatch(Strip::<V> { view, tile: &mut *tile, place: [first + row, left] });
                    for (ray, (l, j)) in strip.rays.iter().zip((0..).zip(left..)) {
                        if columns.contains(&j) {
                            let pixel = row as usize * width + (j - columns.start) as usize;
                            write::<V>(&mut rows, pixel, kernel, &surface, ray, tile.hit(&strip.hits, l));
                        }
                    }
                }
            }
        });
    }
}

/// Writes the answer of one ray: its hit and the sphere that it hits.
fn write<V: Intersect>(
    rows: &mut Piece<'_>,
    pixel: usize,
    kernel: &Kernel,
    surface: &Surface<'_, V::Number>,
    ray: &Ray<V::Number>,
    (hit, s): (Hit<V::Number>, Option<&Sphere<V::Number>>),
) {
    rows.id[pixel] = hit.id;
    let (high, low) = hit.t.to_hi_lo();
    rows.t.get_mut(pixel).into_iter().for_each(|t| *t = high);
    rows.t_low.get_mut(pixel).into_iter().for_each(|t_low| *t_low = low);
    let normal = |s: &Sphere<V::Number>| match kernel.has_normals() {
        true => V::normal_at(ray, s, hit.t / s.scale).map(|x| x.to_hi_lo().0),
        false => [0.0; 3],
    };
    rows.shade(pixel, kernel.shade, surface, || *ray, s.map(|s| (normal(s), hit.id)));
}

/// The pixels of a row of a tile, whose first is at `place` (row and column).
struct Strip<'a, 'b, V: Intersect> {
    view: &'a ViewRecord,
    tile: &'a mut Tile<'b, V::Number>,
    place: [u32; 2],
}

/// Their rays and hits. Those beyond the window are computed too.
struct Answered<R: Laned> {
    rays: [Ray<R>; LANES],
    hits: EightHits<R>,
}

impl<V: Intersect> NullaryFnOnce for Strip<'_, '_, V> {
    type Output = Answered<V::Number>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let [row, first] = self.place;
        let rays = std::array::from_fn(|l| {
            let [row, column] = self.view.sample_position(row, first + l as u32);
            viewing_ray(self.view, row, column)
        });
        Answered { hits: self.tile.nearest::<V>(&together(&rays)), rays }
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

impl<R: Laned> Tile<'_, R> {
    /// Moves to the tile that contains the pixel at `row` and `column`.
    fn enter(&mut self, row: u32, column: u32) {
        let [first, end] = self.tile_candidates.binned.lists.range(row, column).map(|n| n as usize);
        if self.entries != (first..end) {
            self.entries = first..end;
            self.made.clear();
        }
    }

    /// The closest hits: the twin of search/tile.wgsl. Their places are those of the general spheres and then of the list.
    #[inline(always)]
    fn nearest<V: Intersect<Number = R>>(&mut self, ray: &Ray<R::Vector>) -> EightHits<R> {
        let mut hits = EightHits::NONE;
        let mut behind = Vector([0; LANES]);
        for ((s, id), place) in self.generals.iter().zip(0..) {
            hits.test::<V>(ray, !behind, s, [*id, place]);
        }
        let Range { start, end } = self.entries;
        for first in (start..end).step_by(CHUNK) {
            behind = behind | hits.before(self.tile_candidates.limit(first / CHUNK));
            if !(!behind).any() {
                break;
            }
            let from = first - start;
            if from == self.made.len() {
                self.make(first);
            }
            let to = self.made.len().min(from + CHUNK);
            for ((s, id), place) in self.made[from..to].iter().zip((self.generals.len() + from) as u32..) {
                hits.test::<V>(ray, !behind, s, [*id, place]);
            }
        }
        hits
    }

    /// Translates the chunk of the list that begins at the entry `first`.
    fn make(&mut self, first: usize) {
        let chunk = self.tile_candidates.ids(first..first + CHUNK);
        // Skips the padding at the end of the list.
        self.made.extend(chunk.filter(|id| *id != NONE).map(|id| candidate(self.tile_candidates, id)));
    }

    /// The hit of one of the rays, and its sphere.
    fn hit(&self, hits: &EightHits<R>, l: usize) -> (Hit<R>, Option<&Sphere<R>>) {
        let hit = Hit { t: R::lane(&hits.t, l), id: hits.id.0[l] };
        let place = hits.place.0[l] as usize;
        let found = self.generals.iter().chain(&self.made).nth(place).filter(|_| hit.id != NONE);
        (hit, found.map(|(s, _)| s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::binned::{BinnedScene, Binning};
    use crate::intersect::Method;
    use crate::memory::Pool;
    use crate::render::plan::Plan;
    use crate::settings::Settings;
    use crate::view::View;

    /// Checks that tests/answers/tiles.rs detects a list that lacks one sphere.
    #[test]
    fn a_sphere_missing_from_a_list_is_found() {
        let scene = crate::testing::weekend([131, 74]);
        let (view, pool) = (View::new(&scene).expect("a view"), Pool::default());
        let mut binned =
            BinnedScene::new(&Binning::of(&scene, &view, 1e-5, &pool)).expect("a stage").expect("a projection");
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
