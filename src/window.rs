//! The part of a frame that is rendered: a rectangle in pixels of the full frame.

use halfline_ground::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Columns x0 to x1 and rows y0 to y1 of a full frame, ends excluded, counted from its top left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Window {
    /// First column.
    pub x0: u32,
    /// First row.
    pub y0: u32,
    /// One past the last column.
    pub x1: u32,
    /// One past the last row.
    pub y1: u32,
}

impl Window {
    /// The whole of a frame of `width` x `height` pixels.
    #[must_use]
    pub fn full(width: u32, height: u32) -> Self {
        Self { x0: 0, y0: 0, x1: width, y1: height }
    }

    /// Tile `number` of `count`, from 1, of a frame of `width` x `height` pixels. The frame is cut into equal bands of
    /// rows, and each band into equal columns; the number of bands divides `count` and makes the tiles nearest to
    /// squares. Tiles are numbered row by row.
    ///
    /// # Errors
    /// [`Error::Settings`] where there is no such tile, or where a tile would have no pixels.
    pub fn tile(number: u32, count: u32, width: u32, height: u32) -> Result<Self> {
        if !(1..=count).contains(&number) {
            let problem = format!("there is no tile {number} of {count}");
            return Err(Error::settings(problem, format!("count tiles from 1 to {}", count.max(1))));
        }
        // Aspect ratio of a tile: the longer side over the shorter.
        let lank = |rows: u32| {
            let [w, h] = [f64::from(width) / f64::from(count / rows), f64::from(height) / f64::from(rows)];
            (w / h).max(h / w)
        };
        let fits = |rows: &u32| count.is_multiple_of(*rows) && *rows <= height && count / rows <= width;
        let rows = (1..=count.min(height)).filter(fits).min_by(|a, b| lank(*a).total_cmp(&lank(*b)));
        let Some(rows) = rows else {
            let problem = format!("{width} x {height} pixels cannot be cut into {count} equal tiles");
            return Err(Error::settings(problem, "use fewer tiles"));
        };
        let columns = count / rows;
        let [row, column] = [(number - 1) / columns, (number - 1) % columns];
        let cut = |n: u32, parts: u32, side: u32| (u64::from(n) * u64::from(side) / u64::from(parts)) as u32;
        Ok(Self {
            x0: cut(column, columns, width),
            y0: cut(row, rows, height),
            x1: cut(column + 1, columns, width),
            y1: cut(row + 1, rows, height),
        })
    }

    /// The window with so many pixels more on all sides, as far as the frame of `width` x `height` reaches.
    #[must_use]
    pub fn grown(self, margin: u32, width: u32, height: u32) -> Self {
        Self {
            x0: self.x0.saturating_sub(margin),
            y0: self.y0.saturating_sub(margin),
            x1: self.x1.saturating_add(margin).min(width),
            y1: self.y1.saturating_add(margin).min(height),
        }
    }

    /// The place of this window in another that contains it.
    #[must_use]
    pub fn inside(self, outer: Self) -> Self {
        let Self { x0, y0, .. } = outer;
        Self { x0: self.x0 - x0, y0: self.y0 - y0, x1: self.x1 - x0, y1: self.y1 - y0 }
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }

    /// The window, if it is not empty and lies within a frame of `width` x `height`.
    ///
    /// # Errors
    /// [`Error::Settings`] with both.
    pub fn within(self, width: u32, height: u32) -> Result<Self> {
        if self.x0 < self.x1 && self.y0 < self.y1 && self.x1 <= width && self.y1 <= height {
            return Ok(self);
        }
        let problem = format!("the crop {self} does not lie within the frame of {width} x {height} pixels");
        Err(Error::settings(
            problem,
            "give x0,y0,x1,y1 with x0 < x1 and y0 < y1, within the frame; x1 and y1 are excluded",
        ))
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x0, self.y0, self.x1, self.y1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for (count, width, height) in [(1, 7, 5), (16, 1920, 1080), (16, 33, 31), (6, 100, 10), (7, 50, 50), (12, 4, 3)]
        {
            let mut covered = vec![0; (width * height) as usize];
            for number in 1..=count {
                let w =
                    Window::tile(number, count, width, height).and_then(|w| w.within(width, height)).expect("a tile");
                (w.y0..w.y1).for_each(|i| (w.x0..w.x1).for_each(|j| covered[(i * width + j) as usize] += 1));
            }
            assert!(covered.iter().all(|n| *n == 1), "{count} of {width} x {height}");
        }
        let square = Window::tile(6, 16, 1024, 1024).expect("a tile");
        assert_eq!(square, Window { x0: 256, y0: 256, x1: 512, y1: 512 });
    }

    #[test]
    fn an_invalid_tile_is_refused() {
        for (number, count, width, height) in [(0, 4, 8, 8), (5, 4, 8, 8), (1, 0, 8, 8), (1, 11, 10, 10)] {
            Window::tile(number, count, width, height).expect_err("no tile");
        }
        for (x0, y0, x1, y1) in [(0, 0, 0, 1), (2, 0, 1, 1), (0, 0, 9, 1), (0, 3, 1, 9)] {
            Window { x0, y0, x1, y1 }.within(8, 8).expect_err("no part");
        }
    }
}
