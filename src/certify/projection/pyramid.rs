//! Occlusion culling: the depth pyramid of a frame, as in hierarchical z-buffering (Greene, Kass, Miller 1993), with proven
//! bounds. docs/certificate.md, section 11, derives that a frame without the culled spheres has the same bits.

use super::cover::{Coverage, Outline};
use super::project::{Landed, Pixels, floor, whole};
use super::{ProjectionBounds, host_cull_margin, not_below};
use crate::certify::entry::{Placed, number, ordered};
use crate::number::vector::LANES;
use crate::number::{larger, smaller};
use crate::tile::TILE;
use crate::view::ViewRecord;
use crate::window::Window;
use halfline_ground::parallel;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Most tiles along a side of a rectangle that is compared tile by tile. A larger one is compared by squares of tiles
/// alone.
const COMPARED: u32 = 8;

/// Depths behind which a sphere cannot change a pixel, per pixel and per square of tiles, in the frame's unit.
pub(in crate::certify) struct DepthPyramid {
    coverage: Coverage,
    window: Window,
    /// The image's corner in the view's frame.
    corner: [f64; 2],
    /// A depth for every sample of every pixel of the window, row by row: a sphere behind it cannot change the sample.
    /// Bits of f32 as ordered integers. Without `samples`, one depth for all rays through a pixel.
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

/// The places of the rays through each pixel, in the view's frame.
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
const MAX_SAMPLES: u64 = 1 << 25;

impl Level {
    #[inline(always)]
    fn at(&self, column: u32, row: u32) -> f32 {
        self.farthest[((row - self.first[1]) * self.columns + column - self.first[0]) as usize]
    }
}

impl DepthPyramid {
    /// The bytes of a pyramid of so many pixels for the rays of `record`, without its levels, which are a 48th of those.
    pub(in crate::certify) fn bytes(pixels: u64, record: &ViewRecord) -> u64 {
        let samples = pixels.saturating_mul(u64::from(record.strata) * u64::from(record.strata));
        let own = if samples <= MAX_SAMPLES && !record.is_plain() { 8 * samples } else { 0 };
        pixels.saturating_mul(4).saturating_add(own)
    }

    /// The pyramid for a window of an image of `size` pixels, without a sphere.
    pub(in crate::certify) fn new(
        projection: &ProjectionBounds,
        size: [u32; 2],
        window: Window,
        tolerance: f64,
    ) -> Self {
        let coverage = Coverage::new(projection, size, 0.0, host_cull_margin(tolerance), projection.per_pixel);
        let pixels = window.width() as usize * window.height() as usize;
        let limits = (0..pixels).map(|_| AtomicU32::new(ordered(f32::INFINITY))).collect();
        let corner = projection.corner;
        let mut pyramid = Self { coverage, window, corner, limits, samples: None, levels: Vec::new() };
        pyramid.refresh();
        pyramid
    }

    /// Gives every sample of `record` a limit of its own, so that spheres smaller than a pixel hide others. Leaves the
    /// pyramid unchanged for one ray through each pixel's centre, and for too many samples.
    pub(in crate::certify) fn of_samples(
        mut self,
        projection: &ProjectionBounds,
        record: &ViewRecord,
        tolerance: f64,
    ) -> Self {
        let (fine, count) = (record.fine(), record.strata as usize * record.strata as usize);
        let all = self.limits.len() as u64 * count as u64;
        if record.is_plain() || fine > 1 << 16 || all > MAX_SAMPLES {
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
        let places =
            parallel::collect((y1 - y0) as usize, 1, &|rows, places| places.extend(row(y0 + rows.start as u32)));
        let coverage = Coverage::new(projection, self.coverage.size, 0.0, host_cull_margin(tolerance), 1.0);
        self.samples = Some(SamplePlaces { coverage, fine, count, places });
        self.limits = (0..all).map(|_| AtomicU32::new(ordered(f32::INFINITY))).collect();
        self
    }

    /// Number of limits of a pixel.
    #[inline(always)]
    fn per_pixel(&self) -> usize {
        self.samples.as_ref().map_or(1, |samples| samples.count)
    }

    /// The limits of the pixels of some columns of a row.
    #[inline(always)]
    fn limits(&self, row: u32, columns: Range<u32>) -> &[AtomicU32] {
        let count = self.per_pixel();
        &self.limits[self.place(columns.start, row) * count..self.place(columns.end, row) * count]
    }

    /// Computes the levels anew from the limits of the pixels.
    pub(in crate::certify) fn refresh(&mut self) {
        let this = &*self;
        let Window { x0, y0, x1, y1 } = self.window;
        let (first, last) = ([x0 / TILE, y0 / TILE], [(x1 - 1) / TILE, (y1 - 1) / TILE]);
        let columns = last[0] - first[0] + 1;
        let (tile, count) = (TILE as usize, this.per_pixel());
        let lead = (tile - x0 as usize % tile).min((x1 - x0) as usize) * count;
        let row = |row: u32| {
            let mut most = vec![0; columns as usize];
            for y in (row * TILE).max(y0)..((row + 1) * TILE).min(y1) {
                let (lead, rest) = this.limits(y, x0..x1).split_at(lead);
                for (most, limits) in most.iter_mut().zip(std::iter::once(lead).chain(rest.chunks(tile * count))) {
                    *most = limits.iter().fold(*most, |most, limit| limit.load(Ordering::Relaxed).max(most));
                }
            }
            most
        };
        let rows = (last[1] - first[1] + 1) as usize;
        let farthest = parallel::collect(rows, 1, &|rows, farthest| {
            farthest.extend(row(first[1] + rows.start as u32).into_iter().map(number));
        });
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

    /// Whether everything at depth `least` or beyond is hidden in these pixels, as far as they are within the window, by the spheres
    /// covered so far. Large rectangles are compared with what was covered at the last refresh, by whole squares.
    #[inline(always)]
    pub(in crate::certify) fn hides(&self, pixels: &Pixels, least: f32) -> bool {
        self.hides_within(self.within(pixels), pixels, least)
    }

    /// [`Self::hides`] for the rectangle in lane `l`.
    #[inline(always)]
    pub(in crate::certify) fn hides_lane(&self, rectangles: &Rectangles, l: usize, least: f32) -> bool {
        let [left, right, top, bottom] = rectangles.within.map(|end| end[l]);
        let [x0, x1, y0, y1] = rectangles.pixels.map(|end| end[l]);
        self.hides_within([[left, right], [top, bottom]], &[[x0, x1], [y0, y1]], least)
    }

    #[inline(always)]
    fn hides_within(&self, [[left, right], [top, bottom]]: [[u32; 2]; 2], pixels: &Pixels, least: f32) -> bool {
        if left >= right || top >= bottom {
            return true;
        }
        let [columns, rows] = [[left, right], [top, bottom]].map(|[first, end]| [first / TILE, end.div_ceil(TILE)]);
        if (columns[1] - columns[0]).max(rows[1] - rows[0]) > COMPARED {
            return self.hides_squares([columns, rows].map(|[first, end]| [first, end - 1]), least);
        }
        let tiles = &self.levels[0];
        for row in rows[0]..rows[1] {
            for column in columns[0]..columns[1] {
                if tiles.at(column, row) >= least {
                    let across = [left.max(column * TILE), right.min(column * TILE + TILE)];
                    let down = [top.max(row * TILE), bottom.min(row * TILE + TILE)];
                    let is_hidden = match &self.samples {
                        None => self.hides_pixels(across, down, least),
                        Some(samples) => self.hides_samples(samples, across, down, pixels, least),
                    };
                    if !is_hidden {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// [`Self::hides`] for a rectangle of tiles (columns and rows, first and last), by a level with at most two squares
    /// along each of its sides.
    fn hides_squares(&self, tiles: [[u32; 2]; 2], least: f32) -> bool {
        let [across, down] = tiles.map(|[first, last]| last - first);
        let level = (across.max(down).max(1) - 1).checked_ilog2().map_or(0, |n| n as usize + 1);
        let level = level.min(self.levels.len() - 1);
        let [[left, right], [top, bottom]] = tiles.map(|range| range.map(|tile| tile >> level));
        let level = &self.levels[level];
        (top..=bottom).all(|row| (left..=right).all(|column| level.at(column, row) < least))
    }

    /// Whether all rays through these columns and rows hit something before `least`.
    #[inline(always)]
    fn hides_pixels(&self, [left, right]: [u32; 2], [top, bottom]: [u32; 2], least: f32) -> bool {
        let least = ordered(least);
        for y in top..bottom {
            for limit in self.limits(y, left..right) {
                if limit.load(Ordering::Relaxed) >= least {
                    return false;
                }
            }
        }
        true
    }

    /// [`Self::hides_pixels`] for the samples that lie within `pixels` of the view's frame.
    fn hides_samples(
        &self,
        samples: &SamplePlaces,
        [left, right]: [u32; 2],
        [top, bottom]: [u32; 2],
        pixels: &Pixels,
        least: f32,
    ) -> bool {
        let (least, fine) = (ordered(least), f64::from(samples.fine));
        // Counted from the image's corner.
        let [across, down] = [0, 1].map(|k| pixels[k].map(|pixel| pixel - self.corner[k]));
        (top..bottom).all(|y| {
            let limits = self.limits(y, left..right).chunks_exact(samples.count);
            let pixels = limits.zip(samples.of(self.place(left, y)));
            pixels.zip(left..).all(|((limits, places), x)| {
                // Most limits are nearer, so places are compared last.
                limits.iter().zip(places).all(|(limit, [column, row])| {
                    limit.load(Ordering::Relaxed) < least || {
                        let column = f64::from(x) * fine + f64::from(*column);
                        let row = f64::from(y) * fine + f64::from(*row);
                        column < across[0] || across[1] < column || row < down[0] || down[1] < row
                    }
                })
            })
        })
    }

    /// The columns and the rows of the window's pixels that contain these pixels of the view's frame: each the first
    /// and one past the last. If there are none, a first is not below its end.
    #[inline(always)]
    fn within(&self, pixels: &Pixels) -> [[u32; 2]; 2] {
        let window = [[self.window.x0, self.window.x1], [self.window.y0, self.window.y1]];
        let mut found = [[0; 2]; 2];
        for k in 0..2 {
            // Half a pixel more keeps the product far from integers, so its rounding does not matter.
            let pixel = |fine: f64| floor((fine - self.corner[k] + 0.5) * self.coverage.per_fine);
            let [low, end] = window[k].map(f64::from);
            let first = smaller(larger(pixel(pixels[k][0]), low), end);
            // One past the last, so that no number is negative.
            let after = smaller(larger(pixel(pixels[k][1]) + 1.0, 0.0), end);
            found[k] = [whole(first) as u32, whole(after) as u32];
        }
        found
    }

    /// Lowers the limits of the pixels that a projected sphere certainly covers.
    #[inline(always)]
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
                lower(self.limits(row as u32, left as u32..right as u32 + 1), limit);
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
            (first <= last).then_some(first as u32..last as u32 + 1)
        };
        let (top, bottom) = outline.rows();
        let (Some(rows), Some(columns)) = (ends((top, bottom), y0, y1), ends(outline.widest(), x0, x1)) else { return };
        for y in rows {
            let ends = [0.0, fine - 1.0].map(|place| f64::from(y) * fine + place);
            let [first, last] = ends.map(|row| outline.columns(row));
            let (inner_left, inner_right) = (first.0.max(last.0), first.1.min(last.1));
            let is_inner = top <= ends[0] && ends[1] <= bottom;
            let limits = self.limits(y, columns.clone()).chunks_exact(samples.count);
            let places = samples.of(self.place(columns.start, y));
            for ((limits, places), x) in limits.zip(places).zip(columns.clone()) {
                let start = f64::from(x) * fine;
                // The outline is convex: it contains a pixel if it contains the corners of the pixel.
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

    #[inline(always)]
    fn place(&self, x: u32, y: u32) -> usize {
        (y - self.window.y0) as usize * self.window.width() as usize + (x - self.window.x0) as usize
    }
}

/// The rectangles of eight spheres: ends of columns and of rows, in pixels of the view's frame and of the window.
pub(in crate::certify) struct Rectangles {
    pixels: [[f64; LANES]; 4],
    within: [[u32; LANES]; 4],
}

impl Rectangles {
    pub(in crate::certify) const NONE: Self = Self { pixels: [[0.0; LANES]; 4], within: [[0; LANES]; 4] };

    /// Sets lane `l` to the rectangle of a sphere.
    #[inline(always)]
    pub(in crate::certify) fn set(&mut self, l: usize, landed: &Landed, pyramid: &DepthPyramid) {
        let within = pyramid.within(&landed.pixels);
        for end in 0..4 {
            self.pixels[end][l] = landed.pixels[end / 2][end % 2];
            self.within[end][l] = within[end / 2][end % 2];
        }
    }
}

impl SamplePlaces {
    /// The places of the samples of each pixel, from this pixel on.
    fn of(&self, pixel: usize) -> impl Iterator<Item = &[[u16; 2]]> {
        self.places[pixel * self.count..].chunks_exact(self.count)
    }
}

#[inline(always)]
fn lower(limits: &[AtomicU32], limit: u32) {
    for known in limits {
        if known.load(Ordering::Relaxed) > limit {
            // Another job may lower it between the two. Without the minimum, what a stream keeps would depend on chance; without the
            // look before it, which is seldom followed by it, it would take several times as long.
            known.fetch_min(limit, Ordering::Relaxed);
        }
    }
}
