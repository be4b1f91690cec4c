//! The balls that may be seen in each cell of the image.

use super::circle::{Ball, Projection};
use glam::DVec2;

/// Square cells of the image with the balls that may be seen there: those whose outlines reach the cell, but for such as lie behind one that
/// covers all of it.
pub(super) struct Cells {
    /// The place of the first cell's corner.
    corner: DVec2,
    side: f64,
    columns: usize,
    rows: usize,
    first: Vec<u32>,
    balls: Vec<u32>,
}

/// The extent of a ball in the image, and its depths.
#[derive(Debug, Clone, Copy)]
struct Extent {
    /// A rectangle around its outline.
    low: DVec2,
    high: DVec2,
    /// The least depth, and the largest of what is seen of it.
    depths: [f64; 2],
}

impl Extent {
    /// The extent of a ball in front of the eye.
    pub(super) fn of(ball: &Ball, projection: &Projection) -> Option<Self> {
        let Ball { center, radius } = *ball;
        let depth = -center.z;
        if !projection.is_parallel && depth <= radius {
            return None;
        }
        // Of the slopes along each axis the tangents in the plane of the axis and the view.
        let range = |x: f64| {
            if projection.is_parallel {
                return [x - radius, x + radius];
            }
            let (power, root) =
                (depth * depth - radius * radius, radius * (x * x + depth * depth - radius * radius).sqrt());
            [(x * depth - root) / power, (x * depth + root) / power]
        };
        let [x, y] = [range(center.x), range(center.y)];
        let ends = [0, 1].map(|n| projection.middle + projection.scale * DVec2::new(x[n], y[n]));
        let inner = if projection.is_parallel { 0.0 } else { radius * radius / center.length_squared() };
        // The contour lies in a plane; its farthest point is not deeper than its centre by more than its radius times the slant.
        let slant = if projection.is_parallel { 0.0 } else { center.truncate().length() / center.length() };
        let contour = depth * (1.0 - inner) + radius * (1.0 - inner).sqrt() * slant;
        Some(Self { low: ends[0].min(ends[1]), high: ends[0].max(ends[1]), depths: [depth - radius, contour] })
    }
}

impl Cells {
    /// The cells of all that reaches into an image of this size; of what does not, nothing is listed.
    pub(super) fn new(balls: &[Ball], projection: &Projection, size: DVec2) -> Self {
        let reaches = |extent: &Extent| extent.high.cmpge(DVec2::ZERO).all() && extent.low.cmple(size).all();
        let extents: Vec<_> = balls.iter().map(|ball| Extent::of(ball, projection).filter(reaches)).collect();
        let around = |[low, high]: [DVec2; 2], extent: &Extent| [low.min(extent.low), high.max(extent.high)];
        let [corner, end] = extents.iter().flatten().fold([DVec2::ZERO, size], around);
        let size = end - corner;
        let extents: Vec<_> = extents
            .into_iter()
            .map(|extent| extent.map(|of| Extent { low: of.low - corner, high: of.high - corner, ..of }))
            .collect();
        let mut sides: Vec<f64> =
            extents.iter().flatten().map(|extent| (extent.high - extent.low).min_element()).collect();
        let middle = sides.len() / 2;
        let usual = if sides.is_empty() { 1.0 } else { *sides.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let side = (0.25 * usual).max(size.max_element() / 2048.0);
        let [columns, rows] = [size.x, size.y].map(|length| (length / side).ceil().max(1.0) as usize);
        let range = |low: f64, high: f64, count: usize| {
            let first = (low / side).floor().clamp(0.0, count as f64) as usize;
            first..((high / side).floor() + 1.0).clamp(first as f64, count as f64) as usize
        };
        let mut bounds = vec![f64::INFINITY; columns * rows];
        let inside = |ball: &Ball, place: DVec2| ball.depth(projection, place).is_some();
        for (ball, extent) in balls.iter().zip(&extents).filter_map(|(ball, extent)| Some((ball, (*extent)?))) {
            let (columns_in, rows_in) =
                (range(extent.low.x, extent.high.x, columns), range(extent.low.y, extent.high.y, rows));
            if columns_in.len() < 3 || rows_in.len() < 3 {
                continue;
            }
            for row in rows_in {
                for column in columns_in.clone() {
                    let bound = &mut bounds[row * columns + column];
                    let at = |x: usize, y: usize| corner + DVec2::new((column + x) as f64, (row + y) as f64) * side;
                    let covers = || [(0, 0), (1, 0), (0, 1), (1, 1)].iter().all(|(x, y)| inside(ball, at(*x, *y)));
                    if extent.depths[1] < *bound && covers() {
                        *bound = extent.depths[1];
                    }
                }
            }
        }
        let mut entries: Vec<(u32, u32)> = Vec::new();
        for (n, extent) in (0..).zip(&extents).filter_map(|(n, extent)| Some((n, (*extent)?))) {
            for row in range(extent.low.y, extent.high.y, rows) {
                for column in range(extent.low.x, extent.high.x, columns) {
                    let cell = row * columns + column;
                    if extent.depths[0] <= bounds[cell] {
                        entries.push((cell as u32, n));
                    }
                }
            }
        }
        let mut first = vec![0; columns * rows + 1];
        entries.iter().for_each(|(cell, _)| first[*cell as usize + 1] += 1);
        for n in 0..columns * rows {
            first[n + 1] += first[n];
        }
        let (mut next, mut listed) = (first.clone(), vec![0; entries.len()]);
        for (cell, ball) in entries {
            listed[next[cell as usize] as usize] = ball;
            next[cell as usize] += 1;
        }
        Self { corner, side, columns, rows, first, balls: listed }
    }

    /// The balls of the cell of a place; none outside of the image.
    pub(super) fn at(&self, place: DVec2) -> &[u32] {
        let [column, row] = ((place - self.corner) / self.side).floor().to_array();
        let is_within = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        if is_within { self.cell(row as usize * self.columns + column as usize) } else { &[] }
    }

    fn cell(&self, n: usize) -> &[u32] {
        &self.balls[self.first[n] as usize..self.first[n + 1] as usize]
    }

    /// The balls of each cell.
    pub(super) fn all(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.columns * self.rows).map(|n| self.cell(n))
    }
}
