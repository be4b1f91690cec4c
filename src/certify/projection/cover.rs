//! Coverage of a tile's pixels from front to back: a sphere behind full coverage cannot be the nearest hit of any ray.

use super::ProjectionBounds;
use super::project::{floor, whole};
use crate::certify::entry::Placed;
use crate::number::{larger, smaller};
use crate::tile::TILE;

/// The margin that a disc is shrunk by, in pixels and relative to its radius. With one unit of the fixed point it far
/// exceeds the error of the record (2^-24 of a radius, half that unit), and is too small to leave a pixel uncovered.
/// Section 4 of docs/certificate.md.
const SHRINK: [f64; 2] = [1.0 / (1u64 << 16) as f64, 1.0 / (1u64 << 20) as f64];

/// Error of a record's depth: the rounding of its relative part to f32, and the host's 2^-43 of the total.
/// Section 4 of docs/certificate.md.
const DEEPER: [f64; 2] = [1.0 / (1u64 << 20) as f64, 1.0 / (1u64 << 40) as f64];

/// Layers of translucent spheres up to which these are counted; in a picture of more, opaque spheres alone hide others.
const MOST_COUNTED: usize = 4;

/// The layers that a ray shows: translucent spheres up to an opaque one.
#[derive(Clone, Copy)]
pub(crate) struct Through<'a> {
    pub(crate) opacities: &'a [f32],
    /// The most translucent spheres, at least 1.
    pub(crate) layers: u32,
}

/// The inputs of coverage that all tiles of a frame share.
#[derive(Debug, Clone, Copy)]
pub(in crate::certify) struct Coverage {
    /// The size of the image.
    pub(super) size: [u32; 2],
    reference: f64,
    /// Pixels per fixed-point unit: a power of two. Units of rho per pixel of the image, and their inverse.
    per_fixed: f64,
    step: [f64; 2],
    per_step: [f64; 2],
    /// Image pixels per pixel of the view's frame, and the middle of the image's first pixel in that frame.
    pub(super) per_fine: f64,
    middle: [f64; 2],
    /// The part of a disc's inset that does not depend on its radius.
    margin: f64,
    /// Half of the length of the unit of rho, per unit of depth.
    rise: f64,
    /// The cull margin of the host: the distance behind a hit from which on spheres are left out, relative to the hit's
    /// depth.
    behind: f64,
}

impl Coverage {
    /// The coverage of an image of `size` pixels, with depths relative to `reference`; `behind` is the cull margin, infinite where
    /// nothing hides a sphere.
    /// `per_pixel` pixels of the view's frame are a pixel's side, or 1 for the places of rays one by one.
    pub(in crate::certify) fn new(
        projection: &ProjectionBounds,
        size: [u32; 2],
        reference: f64,
        behind: f64,
        per_pixel: f64,
    ) -> Self {
        let ProjectionBounds { step, fixed, corner, scale, .. } = *projection;
        let widest = step[0].max(step[1]);
        // The disc has to cover every sample of a pixel: none is farther from the centre than this.
        let sample_reach = 0.5 * (per_pixel - 1.0) * step[0].hypot(step[1]);
        let pixel = step.map(|step| step * per_pixel);
        Self {
            size,
            reference,
            per_fixed: 1.0 / fixed,
            step: pixel,
            per_step: pixel.map(|step| 1.0 / step),
            per_fine: 1.0 / per_pixel,
            middle: corner.map(|corner| corner + 0.5 * (per_pixel - 1.0)),
            margin: widest * (SHRINK[0] + 1.0 / fixed) + sample_reach,
            rise: 0.5 * scale[0],
            behind,
        }
    }

    /// The pixels that a projected sphere certainly covers; `None` where it covers none: |o| < rho suffices for a hit,
    /// since then a rho^2 - |o|^2 - (slopes x o)^2 >= a (rho^2 - |o|^2) > 0.
    #[inline(always)]
    pub(super) fn outline(&self, sphere: &Placed) -> Option<Outline> {
        let (record, detail) = (&sphere.record, &sphere.detail);
        let Self { reference, per_fixed, step, per_step, per_fine, middle, margin, rise, .. } = *self;
        let rho = f64::from(record.rho);
        let inner = rho - (rho * SHRINK[1] + margin);
        // Under parallel projection, a sphere that may intersect the eye plane has no depth and occludes nothing.
        let center = f64::from(detail.center);
        let depth = center + reference;
        if inner <= 0.0 || depth <= 0.0 || self.behind == f64::INFINITY {
            return None;
        }
        let [x, y] = [(record.x, 0), (record.y, 1)].map(|(n, k)| (f64::from(n) * per_fixed - middle[k]) * per_fine);
        // z = z_c - z_c unit (m + sqrt D) / a, and -m / a <= rho |slopes| / (1 + |slopes|^2) <= rho / 2. Depths are relative
        // to the reference, like the minima of chunks.
        let high = center + depth * (rise * rho) + center.abs() * DEEPER[0] + depth * DEEPER[1];
        let limit = high + self.behind * (high + reference).abs();
        Some(Outline { center: [x, y], inner, steps: step, per_step, limit })
    }
}

/// The pixels that a sphere certainly covers: an ellipse in the image.
pub(super) struct Outline {
    /// Column and row of the middle, in pixels of the image.
    center: [f64; 2],
    /// The radius in the unit of rho, that unit per column and row, and its inverse.
    inner: f64,
    steps: [f64; 2],
    per_step: [f64; 2],
    /// The least depth from which on a sphere cannot change these pixels: the upper bound of the hit's depth, and the
    /// cull margin behind it. Relative to the reference, like the minima of chunks.
    pub(super) limit: f64,
}

impl Outline {
    /// The first and last row.
    #[inline(always)]
    pub(super) fn rows(&self) -> (f64, f64) {
        let up = self.inner * self.per_step[1];
        (-floor(up - self.center[1]), floor(self.center[1] + up))
    }

    /// The first and last column of a row; the first is greater where there are none.
    #[inline(always)]
    pub(super) fn columns(&self, row: f64) -> (f64, f64) {
        let down = (row - self.center[1]) * self.steps[1];
        let half = larger(self.inner * self.inner - down * down, 0.0).sqrt() * self.per_step[0];
        (-floor(half - self.center[0]), floor(self.center[0] + half))
    }

    /// The first and last column of all rows.
    #[inline(always)]
    pub(super) fn widest(&self) -> (f64, f64) {
        let half = self.inner * self.per_step[0];
        (-floor(half - self.center[0]), floor(self.center[0] + half))
    }

    /// Whether the place in a column and a row is covered.
    #[inline(always)]
    pub(super) fn contains(&self, column: f64, row: f64) -> bool {
        // Rounding of f64 is far below what the radius was shrunk by.
        let [across, down] = [(column - self.center[0]) * self.steps[0], (row - self.center[1]) * self.steps[1]];
        across * across + down * down <= self.inner * self.inner
    }
}

/// The pixels of one tile.
pub(in crate::certify) struct Cover {
    coverage: Coverage,
    /// The first column and row.
    corner: [f64; 2],
    /// A bit per pixel that no sphere certainly covers yet, row by row; for a picture through translucent spheres, neither an opaque one nor
    /// as many translucent ones as it shows.
    pub(in crate::certify) open: u64,
    /// Of such a picture the pixels that more than so many translucent spheres certainly cover.
    through: [u64; MOST_COUNTED],
    /// The least depth from which on a sphere cannot change the covered pixels, relative to the reference like the minima
    /// of chunks.
    pub(in crate::certify) deepest: f64,
}

impl Cover {
    /// The tile at this column and row of tiles.
    pub(in crate::certify) fn new(coverage: Coverage, tile: [u32; 2]) -> Self {
        let corner = tile.map(|n| n * TILE);
        let [columns, rows] = [0, 1].map(|k| (coverage.size[k] - corner[k]).min(TILE));
        let row = (1u64 << columns) - 1;
        let open = (0..rows).fold(0, |open, i| open | row << (TILE * i));
        let (corner, through) = (corner.map(f64::from), [0; MOST_COUNTED]);
        Self { coverage, corner, open, through, deepest: f64::NEG_INFINITY }
    }

    /// The least depth from which on a sphere cannot change any pixel, once every pixel is covered.
    pub(in crate::certify) fn limit(&self) -> Option<f64> {
        (self.open == 0).then_some(self.deepest)
    }

    /// Marks the pixels that a projected sphere certainly covers.
    #[inline(always)]
    pub(in crate::certify) fn add(&mut self, sphere: &Placed) {
        if let Some((bits, limit)) = self.covered(sphere)
            && bits & self.open != 0
        {
            self.open &= !bits;
            self.deepest = self.deepest.max(limit);
        }
    }

    /// Marks the pixels that a translucent sphere certainly covers, of a picture with so many layers, at least 1. Where as many cover a pixel,
    /// what lies behind all of them is not shown.
    #[inline(always)]
    pub(in crate::certify) fn add_layer(&mut self, sphere: &Placed, layers: u32) {
        let last = layers as usize - 1;
        let covered = if last < MOST_COUNTED { self.covered(sphere) } else { None };
        if let Some((bits, limit)) = covered
            && bits & self.open != 0
        {
            for k in (1..=last).rev() {
                self.through[k] |= self.through[k - 1] & bits;
            }
            self.through[0] |= bits;
            self.open &= !self.through[last];
            self.deepest = self.deepest.max(limit);
        }
    }

    /// The pixels that a projected sphere certainly covers, and the depth from which on what lies behind it does not change them.
    #[inline(always)]
    fn covered(&self, sphere: &Placed) -> Option<(u64, f64)> {
        let outline = self.coverage.outline(sphere).filter(|_| self.open != 0)?;
        let most = f64::from(TILE - 1);
        let [x, y] = self.corner;
        let (top, bottom) = outline.rows();
        let mut bits = 0;
        // All rows without branches, so that compilers make a vector of them.
        for k in 0..TILE {
            let row = f64::from(k);
            let (left, right) = outline.columns(row + y);
            let (left, right) = (larger(left - x, 0.0), smaller(right - x, most));
            let is_covered = (row >= top - y) & (row <= bottom - y) & (left <= right);
            let (left, right) = if is_covered { (left, right) } else { (1.0, 0.0) };
            bits |= ((2u64 << whole(right)) - (1u64 << whole(left))) << (TILE * k);
        }
        Some((bits, outline.limit))
    }
}
