//! Coverage of a tile's pixels from front to back: a sphere behind full coverage cannot be the nearest hit of any ray.

use super::ProjectionBounds;
use super::project::floor;
use crate::certify::tiles::Placed;
use crate::tile::TILE;

/// The margin that a disc is shrunk by, in pixels and relative to its radius. With one unit of the fixed point it far
/// exceeds the error of the record (2^-24 of a radius, half that unit), and is too small to leave a pixel uncovered.
const SHRINK: [f64; 2] = [1.0 / (1u64 << 16) as f64, 1.0 / (1u64 << 20) as f64];

/// Error of a record's depth: the rounding of its relative part to f32, and the host's 2^-43 of the total.
const DEEPER: [f64; 2] = [1.0 / (1u64 << 20) as f64, 1.0 / (1u64 << 40) as f64];

/// What all tiles of a frame share.
#[derive(Debug, Clone, Copy)]
pub(in crate::certify) struct Coverage {
    /// The size of the image.
    size: [u32; 2],
    reference: f64,
    /// Pixels per fixed-point unit: a power of two. Units of rho per pixel of the image, and their inverse.
    per_fixed: f64,
    step: [f64; 2],
    per_step: [f64; 2],
    /// Image pixels per pixel of the view's frame, and the middle of the image's first pixel in that frame.
    per_fine: f64,
    middle: [f64; 2],
    /// What a disc loses on every side, without what depends on its radius.
    margin: f64,
    /// Half of the length of the unit of rho, per unit of depth.
    rise: f64,
}

impl Coverage {
    /// The coverage of an image of `size` pixels, with depths relative to `reference`.
    pub(in crate::certify) fn new(projection: &ProjectionBounds, size: [u32; 2], reference: f64) -> Self {
        let ProjectionBounds { step, fixed, per_pixel, corner, scale, .. } = *projection;
        let widest = step[0].max(step[1]);
        // The disc has to cover every sample of a pixel: none is farther from the centre than this.
        let aside = 0.5 * (per_pixel - 1.0) * step[0].hypot(step[1]);
        let pixel = step.map(|step| step * per_pixel);
        Self {
            size,
            reference,
            per_fixed: 1.0 / fixed,
            step: pixel,
            per_step: pixel.map(|step| 1.0 / step),
            per_fine: 1.0 / per_pixel,
            middle: corner.map(|corner| corner + 0.5 * (per_pixel - 1.0)),
            margin: widest * (SHRINK[0] + 1.0 / fixed) + aside,
            rise: 0.5 * scale[0],
        }
    }
}

/// The pixels of one tile.
pub(in crate::certify) struct Cover {
    coverage: Coverage,
    /// The first column and row.
    corner: [f64; 2],
    /// A bit per pixel that no sphere certainly covers yet, row by row.
    pub(in crate::certify) open: u64,
    /// Upper bound of the nearest hit's depth over the covered pixels, relative to the reference like the minima of
    /// chunks.
    pub(in crate::certify) deepest: f64,
}

impl Cover {
    /// The tile at this column and row of tiles.
    pub(in crate::certify) fn new(coverage: Coverage, tile: [u32; 2]) -> Self {
        let corner = tile.map(|n| n * TILE);
        let [columns, rows] = [0, 1].map(|k| (coverage.size[k] - corner[k]).min(TILE));
        let row = (1u64 << columns) - 1;
        let open = (0..rows).fold(0, |open, i| open | row << (TILE * i));
        Self { coverage, corner: corner.map(f64::from), open, deepest: f64::NEG_INFINITY }
    }

    /// An upper bound of the nearest hit's depth for all pixels, once every pixel is covered.
    pub(in crate::certify) fn limit(&self) -> Option<f64> {
        (self.open == 0).then_some(self.deepest)
    }

    /// Marks the pixels that a projected sphere certainly covers: |o| < rho suffices for a hit, since then a rho^2 -
    /// |o|^2 - (slopes x o)^2 >= a (rho^2 - |o|^2) > 0.
    pub(in crate::certify) fn add(&mut self, sphere: &Placed) {
        let (record, detail) = (&sphere.record, &sphere.detail);
        let Coverage { reference, per_fixed, step, per_step, per_fine, middle, margin, rise, .. } = self.coverage;
        let rho = f64::from(record.rho);
        let inner = rho - (rho * SHRINK[1] + margin);
        // Under parallel projection, a sphere that may intersect the eye plane has no depth and occludes nothing.
        let center = f64::from(detail.center);
        let depth = center + reference;
        if inner <= 0.0 || depth <= 0.0 || self.open == 0 {
            return;
        }
        let [x, y] = [(record.x, 0), (record.y, 1)]
            .map(|(n, k)| (f64::from(n) * per_fixed - middle[k]) * per_fine - self.corner[k]);
        let most = f64::from(TILE - 1);
        let up = inner * per_step[1];
        let (top, bottom) = ((-floor(up - y)).max(0.0), floor(y + up).min(most));
        let mut bits = 0u64;
        let mut row = top;
        while row <= bottom {
            let down = (row - y) * step[1];
            let half = (inner * inner - down * down).max(0.0).sqrt() * per_step[0];
            let (left, right) = ((-floor(half - x)).max(0.0), floor(x + half).min(most));
            if left <= right {
                bits |= ((2u64 << right as u32) - (1u64 << left as u32)) << (TILE * row as u32);
            }
            row += 1.0;
        }
        if bits & self.open != 0 {
            self.open &= !bits;
            // z = z_c - z_c unit (m + sqrt D) / a, and -m / a <= rho |slopes| / (1 + |slopes|^2) <= rho / 2.
            let high = center + depth * (rise * rho) + center.abs() * DEEPER[0] + depth * DEEPER[1];
            self.deepest = self.deepest.max(high);
        }
    }
}
