//! The certified frame on the CPU path. Eight pixels of a row are computed together, in loops that the compiler can
//! vectorize for the widest vectors of the processor. Vector and scalar operations round alike, so the bits equal the
//! device's.

#![expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]

use crate::answers::raw::{Piece, Raw};
use crate::certify::binned::BinnedScene;
use crate::certify::constants::BEYOND;
use crate::certify::general::{general_answer, general_low};
use crate::certify::projected::{Projected, ProjectedDetailRecord, ProjectedRecord, projected_answer, projected_low};
use crate::certify::tiles::{NO_DETAIL, NOTHING};
use crate::certify::{Answer, Certify, GENERAL, Slopes};
use crate::kernel::Kernel;
use crate::shade::{Shade, color_of, to_world};
use crate::tile::{CHUNK, TILE};
use crate::view::View;
use crate::view::ray::{NONE, UNSURE};
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
    each_row(&Frame::new(kernel, view, binned, colors, None), raw, go_on);
}

/// The same where a device has searched: `found` holds the winners and the two smallest bounds of depth.
pub(crate) fn finish(
    kernel: &Kernel,
    view: &View,
    binned: &BinnedScene,
    colors: Option<&[[f32; 3]]>,
    found: &Raw,
    raw: &mut Raw,
) {
    each_row(&Frame::new(kernel, view, binned, colors, Some(found)), raw, &|| true);
}

fn each_row(frame: &Frame<'_>, raw: &mut Raw, go_on: &(dyn Fn() -> bool + Sync)) {
    match frame.certify.view.is_plain() {
        true => each_row_by::<false>(frame, raw, go_on),
        false => each_row_by::<true>(frame, raw, go_on),
    }
}

/// The same for pixel centres or for samples. With samples, the rays of a strip lie in several rows and columns.
fn each_row_by<const SAMPLED: bool>(frame: &Frame<'_>, raw: &mut Raw, go_on: &(dyn Fn() -> bool + Sync)) {
    let record = frame.certify.view;
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
            let pixels = arch.dispatch(Strip::<SAMPLED> { frame, place });
            pixels.write(&mut row, record.first_column..record.first_column + record.columns, place[1]);
        }
    };
    rows.for_each(answer);
}

/// What the strips of a frame share.
struct Frame<'a> {
    certify: Certify<'a, f32>,
    shade: Option<Shade>,
    normal: bool,
    colors: Option<&'a [[f32; 3]]>,
    /// What a device has found; `None` where the search is to be done.
    found: Option<&'a Raw>,
}

impl<'a> Frame<'a> {
    fn new(
        kernel: &Kernel,
        view: &'a View,
        binned: &'a BinnedScene,
        colors: Option<&'a [[f32; 3]]>,
        found: Option<&'a Raw>,
    ) -> Self {
        let certify = Certify::new(&view.record, binned);
        Self { certify, shade: kernel.shade, normal: kernel.normal, colors, found }
    }
}

/// Eight pixels of a row, starting at `place` (row and column). Those beyond the window are computed but not written.
struct Strip<'a, const SAMPLED: bool> {
    frame: &'a Frame<'a>,
    place: [u32; 2],
}

impl<const SAMPLED: bool> NullaryFnOnce for Strip<'_, SAMPLED> {
    type Output = Pixels;

    #[inline(always)]
    fn call(self) -> Pixels {
        let Self { frame, place } = self;
        let lanes = Lanes::<SAMPLED>::new(&frame.certify, place);
        let two = match frame.found {
            Some(found) => NearestTwos::found(found, &frame.certify, place),
            None => lanes.nearest_two(&frame.certify, place),
        };
        lanes.pixels(frame, &two)
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
    fn new(certify: &Certify<'_, f32>, [i, first]: [u32; 2]) -> Self {
        let slopes = |column: u32| {
            let [i, j] = if SAMPLED { certify.view.sample_position(i, column) } else { [i, column] };
            certify.slopes(i, j)
        };
        let none = [0.0; LANES];
        let mut lanes = Self {
            first: slopes(first),
            x: none,
            a: none,
            inverse: none,
            y: none,
            row: [0; LANES],
            column: [0; LANES],
        };
        // Not array::from_fn, which compilers leave as a call.
        for l in 0..LANES {
            let s = slopes(first + l as u32);
            (lanes.x[l], lanes.a[l], lanes.inverse[l]) = (s.x, s.a, s.inverse);
            (lanes.y[l], lanes.row[l], lanes.column[l]) = (s.y, s.row, s.column);
        }
        lanes
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
    fn nearest_two(&self, certify: &Certify<'_, f32>, [i, first]: [u32; 2]) -> NearestTwos {
        let mut k = NearestTwos::NONE;
        let (projection, terms, lists) = (certify.projection, *certify.terms, certify.lists);
        for &slot in certify.nears.of(i, first) {
            // Copies: of what a reference leads to, compilers may expect that the loop changes it.
            let general = certify.generals[slot as usize];
            let mut lows = [0.0; LANES];
            for (l, low) in lows.iter_mut().enumerate() {
                *low = general_low(&self.slopes(projection.shift, l), &general, &terms);
            }
            for (l, low) in lows.into_iter().enumerate() {
                k.keep(l, low, GENERAL | slot);
            }
        }
        let [first, end] = lists.range(i, first).map(|n| n as usize);
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
    fn certify_winners(&self, certify: &Certify<'_, f32>, k: &NearestTwos) -> Answers {
        let mut answers = Answers::default();
        if k.slot.iter().any(|slot| slot & GENERAL == 0) {
            self.certify_projected(certify, k, &mut answers);
        }
        let mut left = k.slot;
        while let Some(slot) = left.into_iter().find(|slot| slot & GENERAL != 0 && *slot != NONE) {
            self.certify_general(certify, &left, slot, &mut answers);
            for other in &mut left {
                *other = if *other == slot { NONE } else { *other };
            }
        }
        answers
    }

    /// Answers of the lanes whose winner is this general sphere. All lanes are computed, since usually all share the
    /// winner.
    #[inline(always)]
    fn certify_general(&self, certify: &Certify<'_, f32>, winners: &[u32; LANES], slot: u32, answers: &mut Answers) {
        let (general, terms) = (certify.generals[(slot & !GENERAL) as usize], *certify.terms);
        let shift = certify.projection.shift;
        let mut found = Answers::default();
        for l in 0..LANES {
            found.set(l, &general_answer(&self.slopes(shift, l), &general, &terms));
        }
        answers.take(&found, |l| winners[l] == slot);
    }

    #[inline(always)]
    fn certify_projected(&self, certify: &Certify<'_, f32>, k: &NearestTwos, answers: &mut Answers) {
        let (lists, projection, terms) = (certify.lists, *certify.projection, *certify.terms);
        let mut winners = [(NOTHING, NO_DETAIL); LANES];
        for l in 0..LANES {
            if k.slot[l] & GENERAL == 0 {
                winners[l] = (lists.projected[k.slot[l] as usize], lists.details[k.slot[l] as usize]);
            }
        }
        let (mut x, mut y, mut rho) = ([0; LANES], [0; LANES], [0.0; LANES]);
        let (mut offset, mut center) = ([[0.0; LANES]; 2], [0.0; LANES]);
        for l in 0..LANES {
            let (record, detail) = &winners[l];
            (x[l], y[l], rho[l]) = (record.x, record.y, record.rho);
            (offset[0][l], offset[1][l], center[l]) =
                (detail.subpixel_offset[0], detail.subpixel_offset[1], detail.center);
        }
        for l in 0..LANES {
            let sphere = ProjectedRecord { x: x[l], y: y[l], rho: rho[l], low: 0.0 };
            let detail =
                ProjectedDetailRecord { subpixel_offset: [offset[0][l], offset[1][l]], center: center[l], id: 0 };
            let sphere = Projected::<f32>::new(&sphere, &detail);
            let slopes = self.slopes(projection.shift, l);
            answers.set(l, &projected_answer(&slopes, &projection, &sphere, &terms));
        }
        for l in 0..LANES {
            answers.id[l] = winners[l].1.id;
        }
    }

    /// What is written: the twin of main/certified.wgsl and of shade/.
    #[inline(always)]
    fn pixels(&self, frame: &Frame<'_>, two: &NearestTwos) -> Pixels {
        let Frame { certify, shade, normal, colors, .. } = frame;
        let view = *certify.view;
        let answers = self.certify_winners(certify, two);
        let [offset, _, _, interval, x, y, z] = &answers.numbers;
        let mut pixels = Pixels::NONE;
        for l in 0..LANES {
            let hit = two.slot[l] != NONE;
            let proved = !hit | certify.certain(&answers.get(l), [two.low[l], two.second[l]]);
            pixels.id[l] = if proved { answers.id[l] } else { UNSURE };
            pixels.t[l] = if hit { offset[l] } else { f32::MAX };
            pixels.depth_interval[l] = if hit { interval[l] } else { 0.0 };
        }
        if *normal {
            for l in 0..LANES {
                let [a, b, c] = to_world(&view, [x[l], y[l], z[l]]);
                let hit = two.slot[l] != NONE;
                pixels.normal[0][l] = if hit { a } else { 0.0 };
                pixels.normal[1][l] = if hit { b } else { 0.0 };
                pixels.normal[2][l] = if hit { c } else { 0.0 };
            }
        }
        if let Some(shade) = *shade {
            let mut own = [[0.0; LANES]; 3];
            for l in 0..LANES {
                if answers.id[l] != NONE {
                    [own[0][l], own[1][l], own[2][l]] = color_of(*colors, answers.id[l]);
                }
            }
            let behind = view.background;
            for l in 0..LANES {
                let s = self.slopes(0, l);
                let rgb = shade.of(&view, [s.x, s.y, -1.0], [x[l], y[l], z[l]], [own[0][l], own[1][l], own[2][l]]);
                let hit = two.slot[l] != NONE;
                pixels.color[0][l] = if hit { rgb[0] } else { behind[0] };
                pixels.color[1][l] = if hit { rgb[1] } else { behind[1] };
                pixels.color[2][l] = if hit { rgb[2] } else { behind[2] };
            }
        }
        pixels
    }
}

/// Answers as one array per component, a layout that compilers vectorize.
struct Answers {
    /// [`NONE`] where nothing is hit.
    id: [u32; LANES],
    flags: [[u32; LANES]; 2],
    numbers: [[f32; LANES]; 7],
}

impl Default for Answers {
    #[inline(always)]
    fn default() -> Self {
        Self { id: [NONE; LANES], flags: [[0; LANES]; 2], numbers: [[0.0; LANES]; 7] }
    }
}

impl Answers {
    #[inline(always)]
    fn set(&mut self, l: usize, a: &Answer<f32>) {
        self.id[l] = a.id;
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
    fn get(&self, l: usize) -> Answer<f32> {
        let n = &self.numbers;
        Answer {
            sure: self.flags[0][l] != 0,
            hits: self.flags[1][l] != 0,
            id: self.id[l],
            offset: n[0][l],
            low: n[1][l],
            high: n[2][l],
            depth_interval: n[3][l],
            normal: [n[4][l], n[5][l], n[6][l]],
        }
    }

    /// Takes over the answers of some lanes.
    #[inline(always)]
    fn take(&mut self, other: &Self, lane: impl Fn(usize) -> bool) {
        let mut lanes = [0; LANES];
        for l in 0..LANES {
            lanes[l] = mask(lane(l));
            self.id[l] ^= (self.id[l] ^ other.id[l]) & lanes[l];
        }
        for k in 0..2 {
            for l in 0..LANES {
                self.flags[k][l] ^= (self.flags[k][l] ^ other.flags[k][l]) & lanes[l];
            }
        }
        for k in 0..7 {
            for l in 0..LANES {
                self.numbers[k][l] = pick(lanes[l], other.numbers[k][l], self.numbers[k][l]);
            }
        }
    }
}

impl NearestTwos {
    const NONE: Self = Self { low: [BEYOND; LANES], second: [BEYOND; LANES], slot: [NONE; LANES] };

    /// What a device has found for the rays from `place` on; nothing beyond the window.
    #[inline(always)]
    fn found(found: &Raw, certify: &Certify<'_, f32>, [i, first]: [u32; 2]) -> Self {
        let view = certify.view;
        let mut k = Self::NONE;
        for (l, column) in (0..LANES).zip(first..) {
            if column.wrapping_sub(view.first_column) < view.columns {
                let place = ((i - view.first_row) * view.columns + column - view.first_column) as usize;
                (k.low[l], k.second[l], k.slot[l]) = (found.low[place], found.second[place], found.id[place]);
            }
        }
        k
    }

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

/// What is written of a strip, one array per component; anything where a buffer is not requested.
struct Pixels {
    id: [u32; LANES],
    t: [f32; LANES],
    depth_interval: [f32; LANES],
    normal: [[f32; LANES]; 3],
    color: [[f32; LANES]; 3],
}

impl Pixels {
    const NONE: Self = Self {
        id: [NONE; LANES],
        t: [f32::MAX; LANES],
        depth_interval: [0.0; LANES],
        normal: [[0.0; LANES]; 3],
        color: [[0.0; LANES]; 3],
    };

    /// Writes the pixels from column `first` of the full frame on to `row`, which contains these `columns`.
    #[inline(always)]
    fn write(&self, row: &mut Piece<'_>, columns: Range<u32>, first: u32) {
        let lanes = columns.start.saturating_sub(first) as usize..(columns.end - first).min(TILE) as usize;
        let place = first as usize + lanes.start - columns.start as usize;
        put(row.id, place, &lanes, self.id);
        put(row.t, place, &lanes, self.t);
        put(row.depth_interval, place, &lanes, self.depth_interval);
        if !row.normal.is_empty() {
            put(row.normal, place, &lanes, interleaved(&self.normal));
        }
        if !row.color.is_empty() {
            put(row.color, place, &lanes, interleaved(&self.color));
        }
    }
}

/// Three components per lane, lane after lane.
#[inline(always)]
fn interleaved(components: &[[f32; LANES]; 3]) -> [f32; 3 * LANES] {
    let mut all = [0.0; 3 * LANES];
    for l in 0..LANES {
        for k in 0..3 {
            all[3 * l + k] = components[k][l];
        }
    }
    all
}

/// Writes the values of these lanes, some for each, from the pixel `place` of a row on; nothing if the buffer is not
/// requested.
#[inline(always)]
fn put<T: Copy, const N: usize>(row: &mut [T], place: usize, lanes: &Range<usize>, values: [T; N]) {
    let channels = N / LANES;
    let Some(out) = row.get_mut(channels * place..).filter(|out| !out.is_empty()) else { return };
    match out.first_chunk_mut::<N>() {
        // Of constant size, so without a call.
        Some(out) if lanes.len() == LANES => *out = values,
        _ => {
            let values = &values[channels * lanes.start..channels * lanes.end];
            out[..values.len()].copy_from_slice(values);
        }
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
                let lanes = Lanes::<SAMPLED>::new(&certify, [i, first]);
                let two = lanes.nearest_two(&certify, [i, first]);
                let answers = lanes.certify_winners(&certify, &two);
                for l in 0..LANES {
                    let [row, column] = view.record.sample_position(i, first + l as u32);
                    let s = certify.slopes(row, column);
                    let k = certify.nearest_two(&s);
                    assert_eq!((k.low, k.second, k.slot), (two.low[l], two.second[l], two.slot[l]));
                    if k.slot != NONE {
                        let (answer, single) = (answers.get(l), certify.certify_winner(&s, &k));
                        assert_eq!(format!("{answer:?}"), format!("{single:?}"), "row {i}, column {first} + {l}");
                        hits += 1;
                    }
                }
            }
            assert!(hits > 1000, "the scene shows something");
        }
    }
}
