//! The certified frame on the CPU path. Eight pixels of a row are computed together, in loops that the compiler can
//! vectorize for the widest vectors of the processor. Vector and scalar operations round alike, so the bits equal the
//! device's.

use crate::answers::raw::{Piece, Raw};
use crate::certify::binned::BinnedScene;
use crate::certify::constants::BEYOND;
use crate::certify::general::{general_answer, general_low};
use crate::certify::projected::{Projected, ProjectedDetailRecord, ProjectedRecord, projected_answer, projected_low};
use crate::certify::tiles::{NO_DETAIL, NOTHING};
use crate::certify::{Answer, Certify, GENERAL, Slopes};
use crate::kernel::Kernel;
use crate::shade::{Shade, Surface};
use crate::tile::{CHUNK, TILE};
use crate::view::View;
use crate::view::ray::{NONE, Ray, UNSURE};
use pulp::NullaryFnOnce;
use rayon::prelude::*;
use std::ops::Range;

/// Pixels that are computed together: one row of a tile.
const LANES: usize = TILE as usize;

/// Fills `raw` with certified answers; pixels without a proof get [`UNSURE`] as id. `go_on` is called before every row.
pub(crate) fn certified(
    kernel: &Kernel,
    view: &View,
    binned: &BinnedScene,
    colors: Option<&[[f32; 3]]>,
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    match view.record.is_plain() {
        true => certified_by::<false>(kernel, view, binned, colors, raw, go_on),
        false => certified_by::<true>(kernel, view, binned, colors, raw, go_on),
    }
}

/// The same for pixel centres or for samples. With samples, the rays of a strip lie in several rows and columns.
fn certified_by<const SAMPLED: bool>(
    kernel: &Kernel,
    view: &View,
    binned: &BinnedScene,
    colors: Option<&[[f32; 3]]>,
    raw: &mut Raw,
    go_on: &(dyn Fn() -> bool + Sync),
) {
    let certify = Certify::new(&view.record, binned);
    let surface = Surface { view: &view.record, spheres: &[], colors };
    let record = &view.record;
    let width = record.columns as usize;
    let rows: Vec<_> = raw.cut(width, width).collect();
    let arch = pulp::Arch::new();
    let rows = rows.into_par_iter().enumerate().filter(|_| go_on());
    let answer = |(i, mut row): (usize, Piece<'_>)| {
        let i = record.first_row + i as u32;
        // A strip is a row of a tile of the full frame, whichever part of it the window shows.
        let [[left, right], _] = record.tiles();
        for tile in left..=right {
            let place = [i, tile * TILE];
            let answered = arch.dispatch(Strip::<SAMPLED> { certify: &certify, place });
            write(&mut row, place, kernel.shade, &certify, &surface, &answered);
        }
    };
    rows.for_each(answer);
}

/// Eight pixels of a row, starting at `place` (row and column). Those beyond the window are computed but not written.
struct Strip<'a, const SAMPLED: bool> {
    certify: &'a Certify<'a, f32>,
    place: [u32; 2],
}

impl<const SAMPLED: bool> NullaryFnOnce for Strip<'_, SAMPLED> {
    type Output = (NearestTwos, [Answer<f32>; LANES]);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let [i, first] = self.place;
        let lanes = Lanes::<SAMPLED>::new(self.certify, i, first);
        let nears = self.certify.nears.of(i, first);
        let [first, end] = self.certify.lists.range(i, first).map(|n| n as usize);
        let two = lanes.nearest_two(self.certify, nears, first..end);
        let answers = lanes.certify_winners(self.certify, &two);
        (two, answers)
    }
}

/// The rays of a strip, one array per component.
struct Lanes<const SAMPLED: bool> {
    /// The components that all rays share; for pixel centres, those of the row.
    first: Slopes<f32>,
    x: [f32; LANES],
    a: [f32; LANES],
    inverse: [f32; LANES],
    /// The components that differ between samples.
    y: [f32; LANES],
    row: [i32; LANES],
    column: [i32; LANES],
}

/// The two smallest lower bounds of depth per lane, and the entry with the smallest.
#[derive(Clone, Copy)]
struct NearestTwos {
    low: [f32; LANES],
    second: [f32; LANES],
    slot: [u32; LANES],
}

impl<const SAMPLED: bool> Lanes<SAMPLED> {
    #[inline(always)]
    fn new(certify: &Certify<'_, f32>, i: u32, first: u32) -> Self {
        let each: [Slopes<f32>; LANES] = std::array::from_fn(|l| {
            let column = first + l as u32;
            let [i, j] = if SAMPLED { certify.view.sample_position(i, column) } else { [i, column] };
            certify.slopes(i, j)
        });
        Self {
            first: each[0],
            x: each.map(|s| s.x),
            a: each.map(|s| s.a),
            inverse: each.map(|s| s.inverse),
            y: each.map(|s| s.y),
            row: each.map(|s| s.row),
            column: each.map(|s| s.column),
        }
    }

    #[inline(always)]
    fn slopes(&self, shift: u32, l: usize) -> Slopes<f32> {
        let (x, a, inverse) = (self.x[l], self.a[l], self.inverse[l]);
        if SAMPLED {
            let (y, row, column) = (self.y[l], self.row[l], self.column[l]);
            return Slopes { x, y, a, inverse, row, column, fixed_row: row << shift, fixed_column: column << shift };
        }
        let column = self.first.column + l as i32;
        Slopes { x, a, inverse, column, fixed_column: column << shift, ..self.first }
    }

    /// The twin of the search in certify/nearest_two.wgsl.
    #[inline(always)]
    fn nearest_two(&self, certify: &Certify<'_, f32>, nears: &[u32], entries: Range<usize>) -> NearestTwos {
        let mut k = NearestTwos { low: [BEYOND; LANES], second: [BEYOND; LANES], slot: [NONE; LANES] };
        let (projection, lists) = (certify.projection, certify.lists);
        for &slot in nears {
            let general = &certify.generals[slot as usize];
            let mut lows = [0.0; LANES];
            for (l, low) in lows.iter_mut().enumerate() {
                *low = general_low(&self.slopes(projection.shift, l), general, certify.terms);
            }
            for (l, low) in lows.into_iter().enumerate() {
                k.keep(l, low, GENERAL | slot);
            }
        }
        let Range { start: first, end } = entries;
        let chunks =
            lists.projected[first..end].chunks_exact(CHUNK).zip(&lists.chunk_min_depths[first / CHUNK..end / CHUNK]);
        for (n, (chunk, &chunk_min_depth)) in chunks.enumerate() {
            let mut behind = true;
            for l in 0..LANES {
                let own = chunk_min_depth - k.low[l] > projection.cull_margin * (projection.depth + k.low[l]);
                k.second[l] = pick(mask(own & (chunk_min_depth < k.second[l])), chunk_min_depth, k.second[l]);
                behind &= own;
            }
            if behind {
                break;
            }
            // A local copy, which the compiler can keep in registers.
            let mut now = k;
            for (slot, projected) in (first + CHUNK * n..).zip(chunk) {
                if *projected == NOTHING {
                    break;
                }
                let sphere = Projected::<f32>::new(projected, &NO_DETAIL);
                for l in 0..LANES {
                    now.keep(l, projected_low(&self.slopes(projection.shift, l), projection, &sphere), slot as u32);
                }
            }
            k = now;
        }
        k
    }

    /// The certified answers of the winners.
    #[inline(always)]
    fn certify_winners(&self, certify: &Certify<'_, f32>, k: &NearestTwos) -> [Answer<f32>; LANES] {
        let mut answers = [Answer::MISS; LANES];
        if k.slot.iter().any(|slot| slot & GENERAL == 0) {
            self.certify_projected(certify, k, &mut answers);
        }
        let mut left = k.slot;
        while let Some(slot) = left.into_iter().find(|slot| slot & GENERAL != 0 && *slot != NONE) {
            self.certify_general(certify, k, slot, &mut answers);
            left = left.map(|other| if other == slot { NONE } else { other });
        }
        answers
    }

    /// Answers of the lanes whose winner is this general sphere. All lanes are computed, since usually all share the
    /// winner.
    #[inline(always)]
    fn certify_general(
        &self,
        certify: &Certify<'_, f32>,
        k: &NearestTwos,
        slot: u32,
        answers: &mut [Answer<f32>; LANES],
    ) {
        let general = &certify.generals[(slot & !GENERAL) as usize];
        let mut found = Answers::default();
        for l in 0..LANES {
            found.set(l, &general_answer(&self.slopes(certify.projection.shift, l), general, certify.terms));
        }
        for (l, answer) in answers.iter_mut().enumerate() {
            if k.slot[l] == slot {
                *answer = found.get(l, general.id);
            }
        }
    }

    #[inline(always)]
    fn certify_projected(&self, certify: &Certify<'_, f32>, k: &NearestTwos, answers: &mut [Answer<f32>; LANES]) {
        let lists = certify.lists;
        let winner = |l: usize| match k.slot[l] & GENERAL {
            0 => (lists.projected[k.slot[l] as usize], lists.details[k.slot[l] as usize]),
            _ => (NOTHING, NO_DETAIL),
        };
        let winners: [_; LANES] = std::array::from_fn(winner);
        let (x, y, rho) = (winners.map(|w| w.0.x), winners.map(|w| w.0.y), winners.map(|w| w.0.rho));
        let (offset_x, offset_y) = (winners.map(|w| w.1.subpixel_offset[0]), winners.map(|w| w.1.subpixel_offset[1]));
        let center = winners.map(|w| w.1.center);
        let mut found = Answers::default();
        for l in 0..LANES {
            let sphere = ProjectedRecord { x: x[l], y: y[l], rho: rho[l], low: 0.0 };
            let detail =
                ProjectedDetailRecord { subpixel_offset: [offset_x[l], offset_y[l]], center: center[l], id: 0 };
            let sphere = Projected::<f32>::new(&sphere, &detail);
            found.set(
                l,
                &projected_answer(
                    &self.slopes(certify.projection.shift, l),
                    certify.projection,
                    &sphere,
                    certify.terms,
                ),
            );
        }
        for (l, answer) in answers.iter_mut().enumerate() {
            if k.slot[l] & GENERAL == 0 {
                *answer = found.get(l, winners[l].1.id);
            }
        }
    }
}

/// Answers as one array per component, a layout that compilers vectorize.
#[derive(Default)]
struct Answers {
    flags: [[u32; LANES]; 2],
    numbers: [[f32; LANES]; 7],
}

impl Answers {
    #[inline(always)]
    fn set(&mut self, l: usize, a: &Answer<f32>) {
        self.flags[0][l] = u32::from(a.sure);
        self.flags[1][l] = u32::from(a.hits);
        self.numbers[0][l] = a.offset;
        self.numbers[1][l] = a.low;
        self.numbers[2][l] = a.high;
        self.numbers[3][l] = a.depth_interval;
        self.numbers[4][l] = a.normal[0];
        self.numbers[5][l] = a.normal[1];
        self.numbers[6][l] = a.normal[2];
    }

    #[inline(always)]
    fn get(&self, l: usize, id: u32) -> Answer<f32> {
        let [offset, low, high, depth_interval, x, y, z] = self.numbers.map(|number| number[l]);
        let [sure, hits] = self.flags.map(|flag| flag[l] != 0);
        Answer { sure, hits, id, offset, low, high, depth_interval, normal: [x, y, z] }
    }
}

impl NearestTwos {
    #[inline(always)]
    fn keep(&mut self, l: usize, low: f32, slot: u32) {
        // Selects by masks and writes unconditionally: compilers may turn a comparison into a masked store, which
        // delays the loads that follow it.
        let before = self.low[l];
        let nearer = mask(low < before);
        self.low[l] = pick(nearer, low, before);
        self.slot[l] ^= (self.slot[l] ^ slot) & nearer;
        let farther = pick(nearer, before, low);
        self.second[l] = pick(mask(farther < self.second[l]), farther, self.second[l]);
    }
}

#[inline(always)]
fn mask(yes: bool) -> u32 {
    u32::from(yes).wrapping_neg()
}

/// `yes` where the mask is set, else `no`.
#[inline(always)]
fn pick(mask: u32, yes: f32, no: f32) -> f32 {
    f32::from_bits(no.to_bits() ^ ((no.to_bits() ^ yes.to_bits()) & mask))
}

/// Writes a strip to `row`, a row of the window: the twin of main/certified.wgsl.
fn write(
    row: &mut Piece<'_>,
    [i, first]: [u32; 2],
    shade: Option<Shade>,
    certify: &Certify<'_, f32>,
    surface: &Surface<'_, f32>,
    (two, answers): &(NearestTwos, [Answer<f32>; LANES]),
) {
    let window = certify.view.first_column..certify.view.first_column + certify.view.columns;
    for ((l, answer), column) in answers.iter().enumerate().zip(first..) {
        if !window.contains(&column) {
            continue;
        }
        let j = (column - window.start) as usize;
        let hit = two.slot[l] != NONE;
        let proved = !hit || certify.certain(answer, [two.low[l], two.second[l]]);
        row.id[j] = if proved { answer.id } else { UNSURE };
        if let Some(t) = row.t.get_mut(j) {
            *t = answer.offset;
        }
        if let Some(interval) = row.depth_interval.get_mut(j) {
            *interval = answer.depth_interval;
        }
        let ray = || {
            let [i, j] = certify.view.sample_position(i, column);
            let s = certify.slopes(i, j);
            Ray { d: [s.x, s.y, -1.0] }
        };
        row.shade(j, shade, surface, ray, hit.then_some((answer.normal, answer.id)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::TERMS;
    use crate::read::ReadOptions;
    use crate::scene::Scene;
    use crate::settings::Settings;
    use crate::view::raster::Raster;
    use crate::window::Window;

    /// The adversary checks single rays. This test extends its results to strips: both give the same bits.
    #[test]
    fn a_strip_answers_as_single_rays() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/weekend.toml");
        let mut scene = Scene::read(&path, &ReadOptions::default()).expect("weekend");
        (scene.image.width, scene.image.height) = (136, 77);
        let window = Window::full(136, 77);
        same_as_single::<false>(&scene, Raster::centres(window));
        let settings = Settings { samples: 9, seed: 3, ..Settings::default() };
        let samples =
            Raster::samples(window, settings.samples, settings.seed, &scene.image).expect("room").expect("samples");
        same_as_single::<true>(&scene, samples);
    }

    fn same_as_single<const SAMPLED: bool>(scene: &Scene, raster: Raster) {
        let kernel = Kernel { certify: true, ..Kernel::bare(crate::Method::Stable) };
        let mut view = View::for_rays(scene, raster, kernel.records()).expect("a view");
        view.record.sample = raster.count() / 2;
        for level in [0, crate::tile::WHOLE] {
            let binned = BinnedScene::new(scene, &view, 1e-5, &TERMS, level, &crate::memory::Pool::default())
                .expect("a stage")
                .expect("a projection");
            let certify = Certify::<f32>::new(&view.record, &binned);
            let mut hits = 0;
            for (i, first) in (0..77).flat_map(|i| (0..136).step_by(LANES).map(move |first| (i, first))) {
                let (two, answers) = Strip::<SAMPLED> { certify: &certify, place: [i, first] }.call();
                for (l, answer) in answers.iter().enumerate() {
                    let [row, column] = view.record.sample_position(i, first + l as u32);
                    let s = certify.slopes(row, column);
                    let k = certify.nearest_two(&s);
                    assert_eq!((k.low, k.second, k.slot), (two.low[l], two.second[l], two.slot[l]));
                    if k.slot != NONE {
                        let single = certify.certify_winner(&s, &k);
                        assert_eq!(format!("{answer:?}"), format!("{single:?}"), "row {i}, column {first} + {l}");
                        hits += 1;
                    }
                }
            }
            assert!(hits > 1000, "the scene shows something");
        }
    }
}
