//! Occlusion culling: the depth pyramid of a frame, as in hierarchical z-buffering (Greene, Kass, Miller 1993), with proven
//! bounds. docs/certificate.md, section 11, derives that a frame without the culled spheres has the same bits.

use super::cover::{Coverage, Outline};
use super::project::floor;
use super::{ProjectionBounds, not_below};
use crate::certify::tiles::{Bin, Placed, number, ordered};
use crate::tile::TILE;
use crate::view::ViewRecord;
use crate::window::Window;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicU32, Ordering};

/// How much a footprint is widened, relative to the radius: the rounding of the record to f32, 2^-24, many times over.
const WIDEN: f64 = 1.0 / (1u64 << 20) as f64;

/// The largest footprint, in pixels, whose pixels are compared one by one.
const COMPARED: f64 = (1 << 12) as f64;

/// Depths behind which a sphere cannot change a pixel, per pixel and per square of tiles.
pub(in crate::certify) struct DepthPyramid {
    coverage: Coverage,
    window: Window,
    /// Per sample of every pixel of the window, row by row: spheres that lie behind cannot change it. Bits of f32 as ordered
    /// integers. Without places of samples one per pixel, for all rays through it.
    limits: Vec<AtomicU32>,
    samples: Option<SamplePlaces>,
    /// The largest limits in squares of 2^k tiles, as of the last refresh.
    levels: Vec<Level>,
}

/// A level of the pyramid: squares of tiles of the full image, as far as they overlap the window.
struct Level {
    /// The first column and row.
    first: [u32; 2],
    columns: u32,
    farthest: Vec<f32>,
}

/// Where the rays through a pixel are, in the view's frame.
struct SamplePlaces {
    coverage: Coverage,
    /// Pixels of the view's frame along a side of a pixel.
    fine: u32,
    /// Samples of a pixel.
    count: usize,
    /// Column and row within its pixel of every sample.
    places: Vec<[u16; 2]>,
}

/// The most samples that have limits of their own: 8 bytes each.
const MOST_SAMPLES: u64 = 1 << 25;

impl Level {
    fn at(&self, column: u32, row: u32) -> f32 {
        self.farthest[((row - self.first[1]) * self.columns + column - self.first[0]) as usize]
    }
}

impl DepthPyramid {
    /// The bytes of a pyramid of so many pixels for the rays of `record`, without its levels, which are a 48th of those.
    pub(in crate::certify) fn bytes(pixels: u64, record: &ViewRecord) -> u64 {
        let samples = pixels.saturating_mul(u64::from(record.strata) * u64::from(record.strata));
        let own = if samples <= MOST_SAMPLES && !record.is_plain() { 8 * samples } else { 0 };
        pixels.saturating_mul(4).saturating_add(own)
    }

    /// The pyramid for a window of an image of `size` pixels, without a sphere. Depths are relative to `reference`.
    pub(in crate::certify) fn new(
        projection: &ProjectionBounds,
        (size, window): ([u32; 2], Window),
        reference: f64,
        tolerance: f64,
    ) -> Self {
        let coverage = Coverage::new(projection, size, reference, tolerance);
        let pixels = window.width() as usize * window.height() as usize;
        let limits = (0..pixels).map(|_| AtomicU32::new(ordered(f32::INFINITY))).collect();
        let mut pyramid = Self { coverage, window, limits, samples: None, levels: Vec::new() };
        pyramid.refresh();
        pyramid
    }

    /// The same for the rays of `record` one by one, so that spheres smaller than a pixel hide others, unless there are too
    /// many.
    pub(in crate::certify) fn of_samples(mut self, projection: &ProjectionBounds, record: &ViewRecord) -> Self {
        let (fine, count) = (record.fine(), record.strata as usize * record.strata as usize);
        let all = self.limits.len() as u64 * count as u64;
        if record.is_plain() || fine > 1 << 16 || all > MOST_SAMPLES {
            return self;
        }
        let Window { x0, y0, x1, y1 } = self.window;
        let shift = [record.shift_column, record.shift_row];
        let pixel = |row: u32, column: u32| {
            (0..count as u32).map(move |sample| {
                let [i, j] = ViewRecord { sample, ..*record }.sample_position(row, column);
                [j - shift[0] - column * fine, i - shift[1] - row * fine].map(|place| place as u16)
            })
        };
        let row = |row: u32| (x0..x1).flat_map(move |column| pixel(row, column));
        let places = (y0..y1).into_par_iter().flat_map_iter(row).collect();
        self.samples = Some(SamplePlaces { coverage: self.coverage.finer(projection), fine, count, places });
        self.limits = (0..all).map(|_| AtomicU32::new(ordered(f32::INFINITY))).collect();
        self
    }

    /// Limits of a pixel.
    fn per_pixel(&self) -> usize {
        self.samples.as_ref().map_or(1, |samples| samples.count)
    }

    /// Those of pixels of a row that follow each other.
    fn limits(&self, row: u32, columns: RangeInclusive<u32>) -> &[AtomicU32] {
        let count = self.per_pixel();
        &self.limits[self.place(*columns.start(), row) * count..(self.place(*columns.end(), row) + 1) * count]
    }

    /// Takes over what the spheres since the last refresh cover.
    pub(in crate::certify) fn refresh(&mut self) {
        let this = &*self;
        let Window { x0, y0, x1, y1 } = self.window;
        let (first, last) = ([x0 / TILE, y0 / TILE], [(x1 - 1) / TILE, (y1 - 1) / TILE]);
        let columns = last[0] - first[0] + 1;
        let row = |row: u32| {
            let rows = (row * TILE).max(y0)..((row + 1) * TILE).min(y1);
            (first[0]..=last[0]).map(move |column| {
                let columns = (column * TILE).max(x0)..((column + 1) * TILE).min(x1);
                let limits = rows.clone().flat_map(|y| this.limits(y, columns.start..=columns.end - 1));
                limits.fold(0, |most, limit| most.max(limit.load(Ordering::Relaxed)))
            })
        };
        let rows: Vec<u32> = (first[1]..=last[1]).collect();
        let farthest = rows.into_par_iter().flat_map_iter(row).map(number).collect();
        let mut levels = vec![Level { first, columns, farthest }];
        while let Some(fine) = levels.last().filter(|level| level.farthest.len() > 1) {
            let rows = fine.farthest.len() as u32 / fine.columns;
            let first = fine.first.map(|n| n / 2);
            let [columns, lines] =
                [(0, fine.columns), (1, rows)].map(|(k, n)| (fine.first[k] + n - 1) / 2 - first[k] + 1);
            let mut farthest = vec![f32::NEG_INFINITY; (columns * lines) as usize];
            for (n, limit) in fine.farthest.iter().enumerate() {
                let (column, row) = (fine.first[0] + n as u32 % fine.columns, fine.first[1] + n as u32 / fine.columns);
                let place = ((row / 2 - first[1]) * columns + column / 2 - first[0]) as usize;
                farthest[place] = farthest[place].max(*limit);
            }
            levels.push(Level { first, columns, farthest });
        }
        self.levels = levels;
    }

    /// Whether no ray of the window can hit a projected sphere first, by what was covered at the last refresh.
    pub(in crate::certify) fn hides(&self, bin: &Bin) -> bool {
        let Window { x0, y0, x1, y1 } = self.window;
        let window = [[x0 / TILE, (x1 - 1) / TILE], [y0 / TILE, (y1 - 1) / TILE]];
        let tiles = [0, 1].map(|k| [bin.tiles[k][0].max(window[k][0]), bin.tiles[k][1].min(window[k][1])]);
        if tiles.iter().any(|[first, last]| first > last) {
            return true;
        }
        // A level at which at most two squares side by side contain the tiles.
        let [across, down] = tiles.map(|[first, last]| last - first);
        let level = (across.max(down).max(1) - 1).checked_ilog2().map_or(0, |n| n as usize + 1);
        let level = level.min(self.levels.len() - 1);
        let [[left, right], [top, bottom]] = tiles.map(|range| range.map(|tile| tile >> level));
        let level = &self.levels[level];
        (top..=bottom).all(|row| (left..=right).all(|column| level.at(column, row) < bin.chunk_min_depth))
    }

    /// The same by the pixels of its footprint, and by what is covered by now. A large sphere is not compared.
    pub(in crate::certify) fn hides_in_pixels(&self, lens: &ProjectionBounds, bin: &Bin, placed: &Placed) -> bool {
        let Some([[left, right], [top, bottom]]) = self.footprint(lens, placed) else { return true };
        let fine = self.samples.as_ref().map_or(1, |samples| samples.fine);
        let [columns, rows] = [[left, right], [top, bottom]].map(|ends| ends.map(|place| place / fine));
        let count = f64::from(columns[1] - columns[0] + 1) * f64::from(rows[1] - rows[0] + 1);
        if count * self.per_pixel() as f64 > COMPARED {
            return false;
        }
        let least = ordered(bin.chunk_min_depth);
        (rows[0]..=rows[1]).all(|y| {
            let limits = self.limits(y, columns[0]..=columns[1]);
            let Some(samples) = &self.samples else {
                return limits.iter().all(|limit| limit.load(Ordering::Relaxed) < least);
            };
            let pixels = limits.chunks_exact(samples.count).zip(samples.of(self.place(columns[0], y)));
            pixels.zip(columns[0]..).all(|((limits, places), x)| {
                // Most limits are nearer, so places are compared last.
                limits.iter().zip(places).all(|(limit, [column, row])| {
                    limit.load(Ordering::Relaxed) < least || {
                        let [column, row] = [x * fine + u32::from(*column), y * fine + u32::from(*row)];
                        column < left || right < column || row < top || bottom < row
                    }
                })
            })
        })
    }

    /// The first and last column and row of the pixels of the window whose rays may hit a projected sphere; `None` without any.
    /// With places of samples they are pixels of the view's frame.
    fn footprint(&self, lens: &ProjectionBounds, placed: &Placed) -> Option<[[u32; 2]; 2]> {
        let coverage = self.samples.as_ref().map_or(&self.coverage, |samples| &samples.coverage);
        let (record, Coverage { per_fixed, per_fine, .. }) = (&placed.record, *coverage);
        let fine = self.samples.as_ref().map_or(1, |samples| samples.fine);
        let window =
            [[self.window.x0, self.window.x1], [self.window.y0, self.window.y1]].map(|ends| ends.map(|n| n * fine));
        let mut found = [[0; 2]; 2];
        for (k, fixed) in [record.x, record.y].into_iter().enumerate() {
            let place = f64::from(fixed) * per_fixed;
            // As for tiles, with the largest slope of the image; the record adds one unit of the fixed point and the rounding of rho.
            let rho = f64::from(record.rho) * (1.0 + WIDEN);
            let half = lens.extent(rho, lens.edge[k], k) + per_fixed;
            let (first, last) = (-floor(half - place), floor(place + half));
            if first > last {
                return None;
            }
            // Half a pixel more keeps the product far from integers, so its rounding does not matter.
            let pixel = |fine: f64| floor((fine - lens.corner[k] + 0.5) * per_fine);
            let [low, end] = window[k].map(f64::from);
            let (first, last) = (pixel(first).max(low), pixel(last).min(end - 1.0));
            if first > last {
                return None;
            }
            found[k] = [first as u32, last as u32];
        }
        Some(found)
    }

    /// Lowers the limits of the pixels that a projected sphere certainly covers.
    pub(in crate::certify) fn cover(&self, placed: &Placed) {
        if let Some(samples) = &self.samples {
            if let Some(outline) = samples.coverage.outline(placed) {
                self.cover_samples(samples, &outline);
            }
            return;
        }
        let Some(outline) = self.coverage.outline(placed) else { return };
        let limit = ordered(not_below(outline.limit));
        let Window { x0, y0, x1, y1 } = self.window;
        let (top, bottom) = outline.rows();
        let (mut row, bottom) = (top.max(f64::from(y0)), bottom.min(f64::from(y1) - 1.0));
        while row <= bottom {
            let (left, right) = outline.columns(row);
            let (left, right) = (left.max(f64::from(x0)), right.min(f64::from(x1) - 1.0));
            if left <= right {
                lower(self.limits(row as u32, left as u32..=right as u32), limit);
            }
            row += 1.0;
        }
    }

    /// Lowers the limits of the samples that an outline in the view's frame contains.
    fn cover_samples(&self, samples: &SamplePlaces, outline: &Outline) {
        let (limit, fine) = (ordered(not_below(outline.limit)), f64::from(samples.fine));
        let Window { x0, y0, x1, y1 } = self.window;
        let ends = |(first, last): (f64, f64), from: u32, end: u32| {
            let first = floor(first / fine).max(f64::from(from));
            let last = floor(last / fine).min(f64::from(end) - 1.0);
            (first <= last).then_some(first as u32..=last as u32)
        };
        let (top, bottom) = outline.rows();
        let (Some(rows), Some(columns)) = (ends((top, bottom), y0, y1), ends(outline.widest(), x0, x1)) else { return };
        for y in rows {
            let ends = [0.0, fine - 1.0].map(|place| f64::from(y) * fine + place);
            let [first, last] = ends.map(|row| outline.columns(row));
            let (inner_left, inner_right) = (first.0.max(last.0), first.1.min(last.1));
            let is_inner = top <= ends[0] && ends[1] <= bottom;
            let limits = self.limits(y, columns.clone()).chunks_exact(samples.count);
            let places = samples.of(self.place(*columns.start(), y));
            for ((limits, places), x) in limits.zip(places).zip(columns.clone()) {
                let start = f64::from(x) * fine;
                // The outline is convex: it contains a pixel of which it contains the corners.
                if is_inner && inner_left <= start && start + fine - 1.0 <= inner_right {
                    lower(limits, limit);
                    continue;
                }
                for (known, [column, row]) in limits.iter().zip(places) {
                    let row = f64::from(y) * fine + f64::from(*row);
                    if outline.contains(start + f64::from(*column), row) {
                        lower(std::slice::from_ref(known), limit);
                    }
                }
            }
        }
    }

    fn place(&self, x: u32, y: u32) -> usize {
        (y - self.window.y0) as usize * self.window.width() as usize + (x - self.window.x0) as usize
    }
}

impl SamplePlaces {
    /// The places of every pixel from this one on.
    fn of(&self, pixel: usize) -> impl Iterator<Item = &[[u16; 2]]> {
        self.places[pixel * self.count..].chunks_exact(self.count)
    }
}

fn lower(limits: &[AtomicU32], limit: u32) {
    for known in limits {
        // A read is cheaper than the locked minimum, and most pixels are covered already.
        if known.load(Ordering::Relaxed) > limit {
            known.fetch_min(limit, Ordering::Relaxed);
        }
    }
}
