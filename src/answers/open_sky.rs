//! The rays toward the sky from the hits of a view, as the samples of a picture take them. A sample also takes the rays of the
//! pixels around it that show its sphere (a discontinuity buffer: Keller and Heidrich, *Interleaved Sampling*, 2001).

use crate::number::vector::{LANES, vectorized};
use crate::scene::SkyLight;
use crate::view::ViewRecord;
use crate::view::ray::{NONE, dot3};
use crate::window::Window;
use glam::{DVec3, Vec3};
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel;
use std::ops::Range;

#[cfg(test)]
mod tests;

/// Sums over rays toward the sky. Each ray counts as its direction, of length 1 and on the side of the normal. The product
/// with a normal is the sum of the rays' cosines; so the rays of a point also tell the open share for normals near its own.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct SkySums {
    /// Over all rays, and over those that nothing hides.
    pub(crate) all: DVec3,
    pub(crate) open: DVec3,
    /// The same of each ray times the zenith's share of the colour there; of a sky with colours.
    pub(crate) zenith: [DVec3; 2],
    /// The number of rays.
    pub(crate) rays: u32,
}

impl SkySums {
    /// Counts a ray.
    #[inline(always)]
    pub(crate) fn add(&mut self, direction: DVec3, colors: Option<&SkyLight>) {
        self.all += direction;
        self.rays += 1;
        if let Some(colors) = colors {
            self.zenith[0] += direction * colors.gradient.zenith(direction);
        }
    }

    /// Counts a ray as open.
    #[inline(always)]
    pub(crate) fn add_open(&mut self, direction: DVec3, colors: Option<&SkyLight>) {
        self.open += direction;
        if let Some(colors) = colors {
            self.zenith[1] += direction * colors.gradient.zenith(direction);
        }
    }

    /// The light of the sky on a surface with this normal: [`light`].
    #[inline(always)]
    pub(crate) fn light(&self, normal: DVec3, colors: Option<&SkyLight>) -> DVec3 {
        let sums = self.vectors().map(|sum| sum.as_vec3().to_array());
        Vec3::from_array(light(sums, normal.as_vec3().to_array(), colors)).as_dvec3()
    }

    /// The sums in the order of their components.
    #[inline(always)]
    fn vectors(&self) -> [DVec3; 4] {
        [self.all, self.open, self.zenith[0], self.zenith[1]]
    }

    /// Writes the vectors into a lane.
    #[inline(always)]
    fn write_lane(&self, lanes: &mut SkyLanes, l: usize) {
        for (lanes, sum) in lanes.iter_mut().zip(self.vectors()) {
            (lanes[0][l], lanes[1][l], lanes[2][l]) = (sum.x as f32, sum.y as f32, sum.z as f32);
        }
    }

    fn plus(&self, other: &Self) -> Self {
        let zenith = [self.zenith[0] + other.zenith[0], self.zenith[1] + other.zenith[1]];
        Self { all: self.all + other.all, open: self.open + other.open, zenith, rays: self.rays + other.rays }
    }

    /// Components of the sums under a sky with colours or without.
    pub(crate) fn count(has_colors: bool) -> usize {
        if has_colors { 12 } else { 6 }
    }

    /// The vectors over the number of rays, so that their length is at most 1.
    fn means(&self) -> [DVec3; 4] {
        let each = 1.0 / f64::from(self.rays.max(1));
        self.vectors().map(|sum| sum * each)
    }
}

/// Light of the sky on a surface with this normal, linear RGB: the light of the whole sky, in the share that the rays find open, channel
/// by channel. Without colours the share alone. Of the vectors of [`SkySums`] in their order, in f32: off by some 2^-22, where the noise of
/// rays is some 2^-4.
#[inline(always)]
fn light(sums: [[f32; 3]; 4], normal: [f32; 3], colors: Option<&SkyLight>) -> [f32; 3] {
    let [all, open, zenith, open_zenith] = sums.map(|sum| dot3(normal, sum));
    match colors {
        None => [open_share(all, open); 3],
        Some(colors) => {
            let (all, open, whole) = (colors.sum(all, zenith), colors.sum(open, open_zenith), colors.open(normal));
            [0, 1, 2].map(|k| whole[k] * open_share(all[k], open[k]))
        }
    }
}

/// The open share from a sum over all rays and one over those that nothing hides.
#[inline(always)]
fn open_share(all: f32, open: f32) -> f32 {
    let share = open / all;
    let share = if share < 1.0 { share } else { 1.0 };
    let share = if share > 0.0 { share } else { 0.0 };
    if all > 0.0 { share } else { 1.0 }
}

/// [`light`] for eight pixels with these normals.
#[expect(clippy::needless_range_loop, reason = "loops over the lanes of several arrays")]
#[inline(always)]
pub(crate) fn light_of_lanes(
    sums: &SkyLanes,
    normal: &[[f64; LANES]; 3],
    colors: Option<&SkyLight>,
) -> [[f32; LANES]; 3] {
    let mut lights = [[0.0; LANES]; 3];
    let at = |l: usize| {
        let vector = |k: usize| [sums[k][0][l], sums[k][1][l], sums[k][2][l]];
        let normal = [normal[0][l] as f32, normal[1][l] as f32, normal[2][l] as f32];
        ([vector(0), vector(1), vector(2), vector(3)], normal)
    };
    // Without a choice in the loop compilers make vectors of it.
    match colors {
        None => {
            for l in 0..LANES {
                let (sums, normal) = at(l);
                lights[0][l] = light(sums, normal, None)[0];
            }
            lights = [lights[0]; 3];
        }
        Some(colors) => {
            for l in 0..LANES {
                let (sums, normal) = at(l);
                [lights[0][l], lights[1][l], lights[2][l]] = light(sums, normal, Some(colors));
            }
        }
    }
    lights
}

/// The vectors of [`SkySums`] of eight pixels in f32, one array per component.
pub(crate) type SkyLanes = [[[f32; LANES]; 3]; 4];

/// The rays toward the sky from the hit of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct SkyAtHit {
    pub(crate) normal: DVec3,
    pub(crate) sums: SkySums,
}

impl SkyAtHit {
    /// Writes the normal, and of the sums over the number of rays as many components as there is room for, all in units of
    /// 1/[`UNIT`].
    pub(crate) fn write(&self, normal: &mut [i16], sums: &mut [i16]) {
        let put = |out: &mut [i16], numbers: &mut dyn Iterator<Item = f64>| {
            out.iter_mut().zip(numbers).for_each(|(out, number)| *out = counted(number));
        };
        put(normal, &mut self.normal.to_array().into_iter());
        put(sums, &mut self.sums.means().into_iter().flat_map(|vector| vector.to_array()));
    }
}

/// The numbers that [`SkyAtHit::write`] writes, of eight pixels.
pub(crate) struct SkyCounts {
    pub(crate) normal: [[i16; LANES]; 3],
    pub(crate) sums: [[i16; LANES]; 12],
}

impl SkyCounts {
    /// Of the components of normals, and of the vectors of [`SkySums`] over so many rays.
    #[inline(always)]
    pub(crate) fn of(normal: &[[f64; LANES]; 3], sums: &[[[f64; LANES]; 3]; 4], rays: u32) -> Self {
        let each = 1.0 / f64::from(rays.max(1));
        let mut counts = Self { normal: [[0; LANES]; 3], sums: [[0; LANES]; 12] };
        for (counts, numbers) in counts.normal.iter_mut().zip(normal) {
            for l in 0..LANES {
                counts[l] = counted(numbers[l]);
            }
        }
        for (counts, numbers) in counts.sums.iter_mut().zip(sums.as_flattened()) {
            for l in 0..LANES {
                counts[l] = counted(numbers[l] * each);
            }
        }
        counts
    }
}

/// A number from -1 to 1 in units of 1/[`UNIT`].
#[inline(always)]
fn counted(number: f64) -> i16 {
    nearest((number * f64::from(UNIT)) as f32)
}

/// Components of a normal.
const NORMAL: usize = 3;

/// Steps of a number from 0 to 1. Two bytes hold it, a ten thousandth of what the noise of its rays is.
const UNIT: f32 = 32767.0;

/// The nearest whole number. Equal numbers stay equal, so that what is open stays the whole of all.
#[inline(always)]
fn nearest(x: f32) -> i16 {
    (x + 0.5).floor() as i16
}

/// Rays of a pixel from which on it needs none of its neighbours.
const ENOUGH: u32 = 64;

/// The passes in which the rays of neighbours are put together. Each takes the rays of a pixel and of its eight neighbours
/// at a distance, with the weights 4, 2 and 1. The distances 1, 2, .. have nothing left of a pattern that repeats after twice the last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Smoothing(pub(crate) &'static [u32]);

impl Smoothing {
    /// The smoothing for pixels with so many rays: none where they alone have little noise, so that more rays come ever closer to
    /// the light of each point.
    pub(crate) const fn of(rays: u32) -> Self {
        Self(if rays < ENOUGH { &[1, 2, 4] } else { &[] })
    }

    /// Whether a pixel has only its own rays.
    pub(crate) fn is_none(self) -> bool {
        self.0.is_empty()
    }

    /// Pixels on each side of a window whose rays count in the window.
    pub(crate) fn margin(self) -> u32 {
        self.0.iter().sum()
    }
}

/// The sums over rays toward the sky at the pixels of a window, with the sums of their neighbours, as [`SkyAtHit::write`] counts them.
#[derive(Debug)]
pub(crate) struct OpenSky {
    window: Window,
    /// The sphere of each pixel.
    ids: Vec<u32>,
    /// Row by row, of each row first the first component of all pixels.
    sums: Vec<i16>,
    /// Components of a pixel.
    count: usize,
}

impl OpenSky {
    /// Puts the rays of a window's neighbours together: `ids` are the spheres that its pixels show, and [`SkyAtHit::write`] wrote
    /// the normals and the sums.
    ///
    /// # Errors
    /// [`crate::Error::Limits`] when the memory cannot be allocated.
    pub(crate) fn new(
        window: Window,
        ids: Vec<u32>,
        [mut normals, mut sums]: [Vec<i16>; 2],
        smoothing: Smoothing,
        pool: &Pool,
    ) -> Result<Self> {
        let (width, count) = (window.width() as usize, sums.len() / ids.len());
        by_component(&mut normals, width, NORMAL);
        by_component(&mut sums, width, count);
        for &step in smoothing.0 {
            let mut next: Vec<i16> = pool.values(count * ids.len())?;
            let pass = &Pass { width, ids: &ids, normals: &normals, sums: &sums, count, step: step as usize };
            let write = |y: usize, out: &mut [i16]| {
                let mut memory = BlockMemory::new(width, count);
                vectorized!(pass.write_row(y, &mut memory, out));
            };
            parallel::chunks(&mut next, count * width, &write);
            pool.put_back(std::mem::replace(&mut sums, next));
        }
        pool.put_back(normals);
        Ok(Self { window, ids, sums, count })
    }

    /// Returns its memory to the pool for the next frame.
    pub(crate) fn put_back(self, pool: &Pool) {
        pool.put_back(self.ids);
        pool.put_back(self.sums);
    }

    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> SkySums {
        let width = self.window.width() as usize;
        let first = row * width * self.count + column;
        let component = |k: usize| f64::from(self.sums[first + k * width]);
        let sum = |k: usize| match 3 * k < self.count {
            true => DVec3::new(component(3 * k), component(3 * k + 1), component(3 * k + 2)),
            false => DVec3::ZERO,
        };
        SkySums { all: sum(0), open: sum(1), zenith: [sum(2), sum(3)], rays: 1 }
    }

    /// The sums for a sample of this pixel of the frame that shows the sphere. They come from the pixel if it shows the sphere
    /// too, else from its neighbours that do, else from all that show any; zeros where none does.
    #[inline(always)]
    pub(crate) fn around(&self, row: u32, column: u32, id: u32) -> SkySums {
        let Window { x0, y0, x1, y1 } = self.window;
        if (y0..y1).contains(&row) && (x0..x1).contains(&column) {
            let (y, x) = ((row - y0) as usize, (column - x0) as usize);
            if self.ids[y * (x1 - x0) as usize + x] == id {
                return self.at(y, x);
            }
        }
        self.of_neighbors(row, column, id)
    }

    /// [`OpenSky::around`] for the pixels of a view from this one on, which show the spheres `ids`, at most [`LANES`]. Lanes of pixels that
    /// show none have any numbers.
    #[inline(always)]
    pub(crate) fn of_run(&self, record: &ViewRecord, first: u32, ids: &[u32]) -> SkyLanes {
        let mut lanes = [[[0.0; LANES]; 3]; 4];
        let Window { x0, y0, x1, y1 } = self.window;
        let mut known = [NONE; LANES];
        if let Some([row, column]) = record.row_of(first)
            && (y0..y1).contains(&row)
            && column >= x0
            && column + LANES as u32 <= x1
        {
            let (y, x, width) = ((row - y0) as usize, (column - x0) as usize, self.window.width() as usize);
            known.copy_from_slice(&self.ids[y * width + x..][..LANES]);
            for (k, lanes) in lanes.as_flattened_mut().iter_mut().take(self.count).enumerate() {
                let sums = &self.sums[(y * self.count + k) * width + x..][..LANES];
                lanes.iter_mut().zip(sums).for_each(|(lane, sum)| *lane = f32::from(*sum));
            }
        }
        for (l, (&id, known)) in ids.iter().zip(known).enumerate() {
            if id != NONE && id != known {
                let [row, column] = record.place(first + l as u32);
                self.around(row, column, id).write_lane(&mut lanes, l);
            }
        }
        lanes
    }

    #[inline(never)]
    fn of_neighbors(&self, row: u32, column: u32, id: u32) -> SkySums {
        let Window { x0, y0, x1, y1 } = self.window;
        let near = |at: u32, first: u32, end: u32| at.saturating_sub(1).max(first)..(at + 2).min(end);
        let (mut same, mut any) = (SkySums::default(), SkySums::default());
        for y in near(row, y0, y1).map(|y| (y - y0) as usize) {
            for x in near(column, x0, x1).map(|x| (x - x0) as usize) {
                let shown = self.ids[y * (x1 - x0) as usize + x];
                if shown != NONE {
                    let sums = self.at(y, x);
                    any = any.plus(&sums);
                    if shown == id {
                        same = same.plus(&sums);
                    }
                }
            }
        }
        if same.all == DVec3::ZERO { any } else { same }
    }
}

/// Steps from which on pixels with other shares are left out.
pub(crate) const WIDE: u32 = 4;
/// The difference of open shares from which on a pixel is left out of a wide step: several times their noise after the steps
/// before it.
pub(crate) const ALIKE: f32 = 0.15;

/// Orders the numbers of each row by component: of pixels with `count` numbers each, first the first of all of them.
fn by_component(values: &mut [i16], width: usize, count: usize) {
    let order = |_: usize, row: &mut [i16]| {
        let pixels = row.to_vec();
        for (k, out) in row.chunks_exact_mut(width).enumerate() {
            out.iter_mut().zip(pixels[k..].iter().step_by(count)).for_each(|(out, number)| *out = *number);
        }
    };
    parallel::chunks(values, count * width, &order);
}

/// Columns that a pass computes together, so that what it reads and adds up stays in the nearest cache.
const BLOCK: usize = 128;

/// Memory for a block of a pass.
struct BlockMemory {
    weights: Vec<f32>,
    /// The shares of the sky that are open in the row, and in the row of its neighbours, by column.
    shares: [Vec<f32>; 2],
    /// Sums of weighted components, [`BLOCK`] of each, and of the weights.
    sums: Vec<f32>,
    all: Vec<f32>,
}

impl BlockMemory {
    fn new(width: usize, count: usize) -> Self {
        let row = |n: usize| vec![0.0; n];
        Self { weights: row(BLOCK), shares: [row(width), row(width)], sums: row(count * BLOCK), all: row(BLOCK) }
    }
}

/// One pass of a [`Smoothing`].
struct Pass<'a> {
    width: usize,
    ids: &'a [u32],
    normals: &'a [i16],
    sums: &'a [i16],
    count: usize,
    step: usize,
}

impl Pass<'_> {
    /// Writes the mean sums of row `y` and its neighbours.
    #[inline(always)]
    fn write_row(&self, y: usize, memory: &mut BlockMemory, out: &mut [i16]) {
        for first in (0..self.width).step_by(BLOCK) {
            let columns = first..self.width.min(first + BLOCK);
            self.add(y, &columns, memory);
            let BlockMemory { sums, all, .. } = &*memory;
            for (out, sums) in out.chunks_exact_mut(self.width).zip(sums.chunks_exact(BLOCK)) {
                for (x, out) in out[columns.clone()].iter_mut().enumerate() {
                    *out = nearest(if all[x] > 0.0 { sums[x] / all[x] } else { 0.0 });
                }
            }
        }
    }

    /// Adds the sums of row `y` and its neighbours up for some columns. Sums of the same sphere count, less the more their normal n differs
    /// from the pixel's: times 1 - 2 |n - n'|^2, and not at all from 41 degrees on. On a sphere that also bounds how far apart they are.
    /// In a wide step they also count less the more their open share s differs, times 1 - (s - s')^2 / [`ALIKE`]^2: where a
    /// neighbour throws a shadow, the light changes within few pixels.
    #[inline(always)]
    fn add(&self, y: usize, columns: &Range<usize>, memory: &mut BlockMemory) {
        let Self { width, count, step, .. } = *self;
        let BlockMemory { weights, shares, sums, all } = memory;
        sums.fill(0.0);
        all.fill(0.0);
        let wide = columns.start.saturating_sub(step)..width.min(columns.end + step);
        self.write_shares(y, columns, &mut shares[0]);
        let height = self.ids.len() / width;
        let rows = [(y.checked_sub(step), 1.0), (Some(y), 2.0), (Some(y + step).filter(|y| *y < height), 1.0)];
        for (row, factor) in rows.into_iter().filter_map(|(row, factor)| Some((row?, factor))) {
            self.write_shares(row, &wide, &mut shares[1]);
            // Columns on the left, and on the right, that have no such neighbour.
            for (left, right, along) in [(step, 0, 1.0), (0, 0, 2.0), (0, step, 1.0)] {
                let here = columns.start.max(left)..columns.end.min(width.saturating_sub(right));
                let n = here.len();
                if n == 0 {
                    continue;
                }
                let (first, there, weights) =
                    (here.start - columns.start, here.start + right - left, &mut weights[..n]);
                self.weigh([y, here.start], [row, there], factor * along, shares, weights);
                for (k, sums) in sums.chunks_exact_mut(BLOCK).enumerate() {
                    let (sums, from) = (&mut sums[first..][..n], &self.sums[(row * count + k) * width + there..][..n]);
                    for x in 0..n {
                        sums[x] += weights[x] * f32::from(from[x]);
                    }
                }
                all[first..][..n].iter_mut().zip(&*weights).for_each(|(all, weight)| *all += *weight);
            }
        }
    }

    /// Writes the open share of the pixels of some columns of a row; 0 for a step that is not wide.
    #[inline(always)]
    fn write_shares(&self, y: usize, columns: &Range<usize>, shares: &mut [f32]) {
        if self.step < WIDE as usize {
            return;
        }
        let (width, n) = (self.width, columns.len());
        let normal = [0, 1, 2].map(|k| &self.normals[(y * NORMAL + k) * width + columns.start..][..n]);
        let sums = |k: usize| &self.sums[(y * self.count + k) * width + columns.start..][..n];
        let (all, open, shares) = ([0, 1, 2].map(sums), [3, 4, 5].map(sums), &mut shares[columns.clone()]);
        for x in 0..n {
            let mut along = [0.0f32; 2];
            for (along, sums) in along.iter_mut().zip([all, open]) {
                let [a, b, c] = [0, 1, 2].map(|k| f32::from(normal[k][x]) * f32::from(sums[k][x]));
                *along = a + b + c;
            }
            shares[x] = if along[0] > 0.0 { along[1] / along[0] } else { 1.0 };
        }
    }

    /// The weights of the pixels from one row and column on for those from another on.
    #[inline(always)]
    fn weigh(
        &self,
        [y, here]: [usize; 2],
        [row, there]: [usize; 2],
        factor: f32,
        shares: &[Vec<f32>; 2],
        weights: &mut [f32],
    ) {
        let (width, n) = (self.width, weights.len());
        let of = |y: usize, x: usize| &self.ids[y * width + x..][..n];
        let normal = |y: usize, x: usize| [0, 1, 2].map(|k| &self.normals[(y * NORMAL + k) * width + x..][..n]);
        let (ids, other_ids, a, b) = (of(y, here), of(row, there), normal(y, here), normal(row, there));
        let (shares, other_shares) = (&shares[0][here..][..n], &shares[1][there..][..n]);
        for x in 0..n {
            let product = |k: usize| f32::from(a[k][x]) * f32::from(b[k][x]);
            let cosine = (product(0) + product(1) + product(2)) * (1.0 / (UNIT * UNIT));
            let near = 4.0 * cosine - 3.0;
            let change = shares[x] - other_shares[x];
            let alike = 1.0 - change * change * (1.0 / (ALIKE * ALIKE));
            let is_same = (ids[x] == other_ids[x]) & (near > 0.0) & (alike > 0.0);
            weights[x] = if is_same { factor * near * alike } else { 0.0 };
        }
    }
}
