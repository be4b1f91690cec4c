//! The balls that may be seen in each cell of the image.

use super::circle::{Ball, Projection};
use super::solids::Solids;
use glam::DVec2;
use halfline::parallel::{self, CHEAP};

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
    /// The depth behind which a ball hides all of a cell.
    bounds: Vec<f64>,
}

/// The extent of a ball in the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    /// A rectangle around its outline.
    pub(super) low: DVec2,
    pub(super) high: DVec2,
    /// The least depth.
    pub(super) depth: f64,
    /// A rectangle around the places of the middle of the ball at the depths of its points.
    middle: [DVec2; 2],
}

impl Extent {
    /// The extent of a ball in front of the eye.
    pub(super) fn of(ball: &Ball, projection: &Projection) -> Self {
        let Ball { center, radius } = *ball;
        let depth = -center.z;
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
        // The outline of a ball beside the axis reaches behind its middle.
        let [a, b] = [-radius, radius].map(|by| projection.place(center.truncate().extend(center.z + by)));
        let middle = [a.min(b), a.max(b)];
        Self { low: ends[0].min(ends[1]), high: ends[0].max(ends[1]), depth: depth - radius, middle }
    }

    /// A depth that no part of the ball within a rectangle is nearer than; `None` where none of it is.
    fn nearest(&self, ball: &Ball, projection: &Projection, [low, high]: [DVec2; 2]) -> Option<f64> {
        // A point of the surface at depth z has (z - c)^2 + |s z - m|^2 = r^2, with the slope s of its ray and the middle m. The second
        // square is not below the square of the gap between the rectangles at the least depth.
        let gap = (self.middle[0] - high).max(low - self.middle[1]).max(DVec2::ZERO) / projection.scale;
        let away = gap.length() * if projection.is_parallel { 1.0 } else { self.depth };
        let inner = (ball.radius - away) * (ball.radius + away);
        (inner >= 0.0).then(|| -ball.center.z - inner.sqrt())
    }

    /// Its longer side.
    pub(super) fn length(&self) -> f64 {
        (self.high - self.low).max_element()
    }
}

/// Sides of cells of the usual size of a ball; of the whole the largest has at most so many.
const SHARE: f64 = 0.25;
const MOST: f64 = 2048.0;

/// The part of a cell by which a place may lie beyond the edge on which it is.
const ON_EDGE: f64 = 1e-6;

impl Cells {
    /// The cells of what lies within a window of the image.
    pub(super) fn new(solids: &Solids, window: [DVec2; 2]) -> Self {
        let Solids { balls, projection, .. } = solids;
        let extents: Vec<Extent> = parallel::values(balls.len(), CHEAP, |n| Extent::of(&balls[n], projection));
        let around = |[low, high]: [DVec2; 2], extent: &Extent| [low.min(extent.low), high.max(extent.high)];
        let [low, high] = extents.iter().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], around);
        let (corner, end) = (low.max(window[0]), high.min(window[1]));
        let size = (end - corner).max(DVec2::ZERO);
        let mut sides: Vec<f64> = extents.iter().map(|extent| (extent.high - extent.low).min_element()).collect();
        let middle = sides.len() / 2;
        let usual = if sides.is_empty() { 1.0 } else { *sides.select_nth_unstable_by(middle, f64::total_cmp).1 };
        let side = (SHARE * usual).max(size.max_element() / MOST).max(f64::MIN_POSITIVE);
        let [columns, rows] = [size.x, size.y].map(|length| (length / side).ceil().max(1.0) as usize);
        let range = |low: f64, high: f64, count: usize| {
            let first = (low / side).floor().clamp(0.0, count as f64) as usize;
            first..((high / side).floor() + 1.0).clamp(first as f64, count as f64) as usize
        };
        let ranges = |extent: &Extent| {
            let [low, high] = [extent.low - corner, extent.high - corner];
            [range(low.x, high.x, columns), range(low.y, high.y, rows)]
        };
        // Each bound is the depth behind which a ball hides all. Depths of a convex body over a cell are greatest at a corner.
        let mut bounds = vec![f64::INFINITY; columns * rows];
        for (n, extent) in (0..).zip(&extents) {
            let [columns_in, rows_in] = ranges(extent);
            if columns_in.len() < 3 || rows_in.len() < 3 {
                continue;
            }
            for row in rows_in {
                for column in columns_in.clone() {
                    let bound = &mut bounds[row * columns + column];
                    if extent.depth >= *bound {
                        continue;
                    }
                    let at = |[x, y]: [usize; 2]| corner + DVec2::new((column + x) as f64, (row + y) as f64) * side;
                    let deepest = [[0, 0], [1, 0], [0, 1], [1, 1]]
                        .iter()
                        .try_fold(0.0_f64, |most, by| Some(most.max(solids.depth(n, at(*by))?)));
                    *bound = bound.min(deepest.map_or(f64::INFINITY, |depth| depth * (1.0 + 1e-12)));
                }
            }
        }
        let mut entries: Vec<(u32, u32)> = Vec::new();
        for (n, (extent, ball)) in (0..).zip(extents.iter().zip(balls)) {
            let [columns_in, rows_in] = ranges(extent);
            for row in rows_in {
                for column in columns_in.clone() {
                    let cell = row * columns + column;
                    let low = corner + DVec2::new(column as f64, row as f64) * side;
                    // Wider by what its corners may be rounded.
                    let around = [low - 1e-9 * side, low + (1.0 + 1e-9) * side];
                    let is_visible = |depth: f64| depth <= bounds[cell];
                    if is_visible(extent.depth) && extent.nearest(ball, projection, around).is_some_and(is_visible) {
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
        Self { corner, side, columns, rows, first, balls: listed, bounds }
    }

    /// The balls of the cell of a place; none outside of the cells.
    pub(super) fn at(&self, place: DVec2) -> &[u32] {
        let at = (place - self.corner) / self.side;
        let size = DVec2::new(self.columns as f64, self.rows as f64);
        // Places on the edges of the window are rounded.
        let is_within = at.cmpge(DVec2::splat(-ON_EDGE)).all() && at.cmple(size + ON_EDGE).all();
        let [column, row] = at.clamp(DVec2::ZERO, size - 1.0).to_array().map(|x| x as usize);
        if is_within { self.cell(row * self.columns + column) } else { &[] }
    }

    /// Whether all of what lies in a rectangle at this depth or behind it is hidden.
    pub(super) fn hide(&self, [low, high]: [DVec2; 2], depth: f64) -> bool {
        let [from, to] = [low, high].map(|place| ((place - self.corner) / self.side).floor());
        let size = DVec2::new(self.columns as f64, self.rows as f64) - 1.0;
        let [from, to] = [from, to].map(|cell| cell.clamp(DVec2::ZERO, size));
        let mut rows = from.y as usize..=to.y as usize;
        rows.all(|row| (from.x as usize..=to.x as usize).all(|column| self.bounds[row * self.columns + column] < depth))
    }

    fn cell(&self, n: usize) -> &[u32] {
        &self.balls[self.first[n] as usize..self.first[n + 1] as usize]
    }

    /// The balls of each cell.
    pub(super) fn all(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.columns * self.rows).map(|n| self.cell(n))
    }
}
