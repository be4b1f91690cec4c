//! The records that the kernels read: the view, and the spheres moved into the canonical camera.

use crate::number::Number;
use crate::number::vector::LANES;
use crate::tile::TILE;
use crate::window::Window;
use bytemuck::{Pod, Zeroable};

/// The uniform of every kernel; declared in view.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub struct ViewRecord {
    /// Basis u in world space; the fourth number is unused.
    pub right: [f32; 4],
    /// Basis v.
    pub up: [f32; 4],
    /// Basis w.
    pub back: [f32; 4],
    /// Linear RGB of a miss; the fourth number is unused.
    pub background: [f32; 4],
    /// W of the frame whose middle is the principal point and whose pixels are the places of rays: the image; with several
    /// samples per pixel, or another principal point, a finer or larger frame.
    pub width: u32,
    /// H of the same frame.
    pub height: u32,
    /// First row, in the full frame, of the window or of the band that a dispatch renders.
    pub first_row: u32,
    /// Rows in the window or the band.
    pub rows: u32,
    /// vw/(2W), scaled.
    pub half_du: f32,
    /// vh/(2H), scaled.
    pub half_dv: f32,
    /// d, scaled.
    pub d: f32,
    /// The number of spheres that every ray tests.
    pub spheres: u32,
    /// 0, but unknown to the compiler (number/double_float.wgsl).
    pub zero: u32,
    /// Rounding error of half_du.
    pub half_du_low: f32,
    /// Rounding error of half_dv.
    pub half_dv_low: f32,
    /// Rounding error of d.
    pub d_low: f32,
    /// First column of the window in the full frame.
    pub first_column: u32,
    /// Columns in the window.
    pub columns: u32,
    /// Strata along a side of a pixel, one sample each; 1 for pixel centres.
    pub strata: u32,
    /// Pixels of the finer frame along a side of a stratum, a power of two.
    pub jitter: u32,
    /// The index of the sample.
    pub sample: u32,
    /// Seed of the sample positions.
    pub seed: u32,
    /// Pixels of the finer frame from a place of a ray to the next; 1 unless the principal point divides pixels finely.
    pub step: u32,
    /// Column in the finer frame of the first place of the image; 0 unless the principal point is not its middle.
    pub shift_column: u32,
    /// Row in the finer frame of the first place of the image.
    pub shift_row: u32,
    /// WGSL rounds the size up to the alignment of the vectors.
    pub unused: [u32; 3],
}

/// Places of pixels, row by row, then the last one again and again.
pub(crate) struct Places {
    place: [u32; 2],
    /// The first column, and the one after the last.
    columns: [u32; 2],
    /// The row after the last.
    rows: u32,
}

impl Iterator for Places {
    type Item = [u32; 2];

    #[inline(always)]
    fn next(&mut self) -> Option<[u32; 2]> {
        let now = self.place;
        self.place = match (now[1] + 1 < self.columns[1], now[0] + 1 < self.rows) {
            (true, _) => [now[0], now[1] + 1],
            (false, true) => [now[0] + 1, self.columns[0]],
            (false, false) => now,
        };
        Some(now)
    }
}

impl ViewRecord {
    /// Pixels of the window.
    pub(crate) fn pixels(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    /// Row and column in the full frame of a pixel of the window, by its index in the buffers.
    pub(crate) fn place(&self, pixel: u32) -> [u32; 2] {
        [self.first_row + pixel / self.columns, self.first_column + pixel % self.columns]
    }

    /// Rows and columns in the full frame of the pixels of the window from this index on, in their order: without the divisions of [`Self::place`].
    #[inline(always)]
    pub(crate) fn places(&self, first: u32) -> Places {
        let place = if self.columns == 0 { [0; 2] } else { self.place(first) };
        let columns = [self.first_column, self.first_column + self.columns];
        Places { place, columns, rows: self.first_row + self.rows }
    }

    /// Row and column in the full frame of a pixel of the window, by its index, if [`LANES`] pixels of its row begin there.
    #[inline(always)]
    pub(crate) fn row_of(&self, first: u32) -> Option<[u32; 2]> {
        const COUNT: u32 = LANES as u32;
        let is_within = |[_, column]: &[u32; 2]| column + COUNT <= self.first_column + self.columns;
        (self.columns >= COUNT).then(|| self.place(first)).filter(is_within)
    }

    /// Rows and columns in the finer frame of the rays of [`LANES`] pixels of the window from this index on; beyond
    /// its end, of its last pixel.
    #[inline(always)]
    pub(crate) fn positions(&self, first: u32) -> [[u32; LANES]; 2] {
        let [mut rows, mut columns] = [[0; LANES]; 2];
        if let Some([row, column]) = self.row_of(first) {
            rows = [row; LANES];
            (0..).zip(&mut columns).for_each(|(l, at)| *at = column + l);
        } else {
            for (l, [row, column]) in self.places(first).take(LANES).enumerate() {
                (rows[l], columns[l]) = (row, column);
            }
        }
        for (row, column) in rows.iter_mut().zip(&mut columns) {
            [*row, *column] = self.sample_position(*row, *column);
        }
        [rows, columns]
    }

    /// Row and column in the finer frame of the ray of a pixel of the window, by its index in the buffers.
    #[inline(always)]
    pub(crate) fn position(&self, pixel: u32) -> [u32; 2] {
        let [row, column] = self.place(pixel);
        self.sample_position(row, column)
    }

    /// The window in the image.
    pub(crate) fn window(&self) -> Window {
        let (x0, y0) = (self.first_column, self.first_row);
        Window { x0, y0, x1: x0 + self.columns, y1: y0 + self.rows }
    }

    /// First and last column and row of the tiles that the window touches.
    pub(crate) fn tiles(&self) -> [[u32; 2]; 2] {
        let of = |first: u32, count: u32| [first / TILE, (first + count - 1) / TILE];
        [of(self.first_column, self.columns), of(self.first_row, self.rows)]
    }

    /// K, the pixels of the finer frame along a side of a pixel; 1 for pixel centres.
    #[inline(always)]
    pub(crate) fn fine(&self) -> u32 {
        self.strata * self.jitter * self.step
    }

    /// Row and column of the image's pixel of a ray, from the row and column of the ray in the finer frame.
    #[inline(always)]
    pub(crate) fn pixel_of(&self, [row, column]: [u32; 2]) -> [u32; 2] {
        [(row - self.shift_row) / self.fine(), (column - self.shift_column) / self.fine()]
    }

    /// Whether the rays belong to a frame whose pixels are the image's.
    #[inline(always)]
    pub(crate) fn is_plain(&self) -> bool {
        self.fine() == 1 && [self.shift_column, self.shift_row] == [0; 2]
    }

    /// Row and column in the finer frame of a pixel's ray; the pixel's own for pixel centres. The twin of main/sample.wgsl.
    #[inline(always)]
    pub(crate) fn sample_position(&self, row: u32, column: u32) -> [u32; 2] {
        if self.is_plain() {
            return [row, column];
        }
        let [across, down, ..] = pcg4d([column, row, self.sample, self.seed]);
        let within = |pixel: u32, stratum: u32, hash: u32| {
            (pixel * self.strata + stratum) * self.jitter + (hash >> 16 & (self.jitter - 1))
        };
        let (i, j) = (self.sample / self.strata, self.sample % self.strata);
        [within(row, i, down) * self.step + self.shift_row, within(column, j, across) * self.step + self.shift_column]
    }
}

/// The hash pcg4d of Jarzynski and Olano, "Hash Functions for GPU Rendering", Journal of Computer Graphics Techniques
/// 9(3), 2020: it maps four numbers to four.
pub(crate) fn pcg4d(v: [u32; 4]) -> [u32; 4] {
    let mix = |[x, y, z, w]: [u32; 4]| {
        let x = x.wrapping_add(y.wrapping_mul(w));
        let y = y.wrapping_add(z.wrapping_mul(x));
        let z = z.wrapping_add(x.wrapping_mul(y));
        let w = w.wrapping_add(y.wrapping_mul(z));
        [x, y, z, w]
    };
    let v = v.map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    mix(mix(v).map(|x| x ^ x >> 16))
}

/// A sphere as the kernels read it; declared in search/closer_hit.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub struct SphereRecord {
    /// Centre minus eye in the canonical camera, and radius; times 2^-k.
    pub center_radius: [f32; 4],
    /// Power of the eye, |c - e|^2 - r^2; times 2^-2k. Its sign is exact.
    pub power: f32,
    /// t of this record times scale is t in the frame's unit.
    pub scale: f32,
    /// WGSL rounds the size up to the alignment of center_radius.
    pub unused: [u32; 2],
}

/// Rounding errors of a [`SphereRecord`]; declared in search/closer_hit.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub struct SphereResiduals {
    /// Rounding errors of centre and radius.
    pub center_radius: [f32; 4],
    /// Rounding error of the power.
    pub power: f32,
    /// WGSL rounds the size up to the alignment of center_radius.
    pub unused: [f32; 3],
}

/// [`SphereRecord`] in the arithmetic of a twin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere<R> {
    /// Centre and radius.
    pub center_radius: [R; 4],
    /// Power of the eye.
    pub power: R,
    /// Factor from the record's t to the frame's.
    pub scale: R,
}

impl<R: Number> From<&SphereRecord> for Sphere<R> {
    fn from(s: &SphereRecord) -> Self {
        Sphere { center_radius: s.center_radius, power: s.power, scale: s.scale }.map(R::from_f32)
    }
}

impl<R: Copy> Sphere<R> {
    /// The sphere with `f` applied to every number.
    #[inline(always)]
    pub(crate) fn map<S>(&self, f: impl Fn(R) -> S) -> Sphere<S> {
        Sphere { center_radius: self.center_radius.map(&f), power: f(self.power), scale: f(self.scale) }
    }
}

impl<R: Number> Sphere<R> {
    /// A record with its rounding errors, as far as the arithmetic holds them.
    pub(crate) fn with_residuals(s: &SphereRecord, low: &SphereResiduals) -> Self {
        Self {
            center_radius: std::array::from_fn(|k| R::from_hi_lo(s.center_radius[k], low.center_radius[k])),
            power: R::from_hi_lo(s.power, low.power),
            scale: R::from_f32(s.scale),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stratum_has_one_sample_in_every_window() {
        let record = ViewRecord { strata: 3, jitter: 16, step: 1, seed: 7, ..ViewRecord::zeroed() };
        let mut counts = [0u32; 16];
        for sample in 0..9 {
            for (row, column) in (0..100).flat_map(|i| (0..100).map(move |j| (i, j))) {
                let [i, j] = ViewRecord { sample, ..record }.sample_position(row, column);
                assert_eq!([i / 48, j / 48], [row, column], "within its pixel");
                assert_eq!([i % 48 / 16, j % 48 / 16], [sample / 3, sample % 3], "within its stratum");
                counts[(i % 16) as usize] += 1;
                counts[(j % 16) as usize] += 1;
            }
        }
        // 180000 in 16 bins: 11250 each, with a standard deviation of 103; the limit is five of them.
        assert!(counts.iter().all(|n| n.abs_diff(11_250) < 515), "{counts:?}");
    }
}
