//! Parts of a frame: the window around what it shows, and the frame of a window.

use super::coverage::{Cover, Coverage};
use super::{Aov, Buffer, Data, Frame};
use crate::window::Window;
use halfline_ground::parallel;

impl Frame {
    /// The smallest window of the full frame that holds every hit, every pixel with alpha and, in a frame without alpha, every colour other
    /// than `background`; `None` where there is none.
    #[must_use]
    pub fn content(&self, background: [f32; 3]) -> Option<Window> {
        let [width, height] = [self.width as usize, self.height as usize];
        let (alpha, color) = (self.f32(Aov::Alpha), self.f32(Aov::Color).map(|all| all.as_chunks().0));
        let is_hit = |pixel: usize| match self.get(Aov::Id).map(|buffer| &buffer.data) {
            Some(Data::I32(ids)) => ids[pixel] >= 0,
            Some(Data::I64(ids)) => ids[pixel] >= 0,
            _ => false,
        };
        let shows = |pixel: usize| {
            is_hit(pixel)
                || match (alpha, color) {
                    (Some(alpha), _) => alpha[pixel] > 0.0,
                    (None, Some(color)) => color[pixel] != background,
                    (None, None) => false,
                }
        };
        // The first and the last column of each row that shows something.
        let ends = parallel::collect(height, 1, &|rows, out| {
            out.extend(rows.map(|row| {
                let mut columns = 0..width;
                let first = columns.find(|column| shows(row * width + column))?;
                Some([first, columns.rfind(|column| shows(row * width + column)).unwrap_or(first)])
            }));
        });
        let shown = || ends.iter().flatten();
        let (x0, x1) = (shown().map(|[first, _]| *first).min()?, shown().map(|[_, last]| *last).max()?);
        let (y0, y1) = (ends.iter().position(Option::is_some)?, ends.iter().rposition(Option::is_some)?);
        let Window { x0: left, y0: top, .. } = self.window;
        let [x0, x1] = [x0, x1 + 1].map(|x| left + x as u32);
        let [y0, y1] = [y0, y1 + 1].map(|y| top + y as u32);
        Some(Window { x0, y0, x1, y1 })
    }

    /// The part of the frame in a window of the full frame, which lies within the window of this one.
    #[must_use]
    pub fn cut(&self, window: Window) -> Self {
        let [left, top] = [(window.x0 - self.window.x0) as usize, (window.y0 - self.window.y0) as usize];
        let [columns, rows] = [window.width() as usize, window.height() as usize];
        let buffers = self.buffers.iter().map(|buffer| {
            let channels = buffer.channels();
            let starts = (top..top + rows).map(|row| channels * (row * self.width as usize + left));
            let part = Rows { starts: starts.collect(), length: channels * columns };
            let mut shape = buffer.shape.clone();
            (shape[0], shape[1]) = (rows, columns);
            Buffer { aov: buffer.aov, shape, data: part.of(&buffer.data) }
        });
        let coverage = self.coverage.as_ref().map(|coverage| {
            let inside = |cover: &&Cover| (left..left + columns).contains(&(cover.column as usize));
            let moved = |cover: &Cover| Cover { column: cover.column - left as u32, ..*cover };
            let row = |covers: &Vec<Cover>| covers.iter().filter(inside).map(moved).collect();
            Coverage { samples: coverage.samples, rows: coverage.rows[top..top + rows].iter().map(row).collect() }
        });
        let [width, height] = [window.width(), window.height()];
        let (full, report) = (self.full, self.report.clone());
        Self { width, height, window, full, buffers: buffers.collect(), coverage, report }
    }
}

/// Parts of rows, each of as many values, by the place of the first one.
struct Rows {
    starts: Vec<usize>,
    length: usize,
}

impl Rows {
    fn of(&self, data: &Data) -> Data {
        match data {
            Data::F32(values) => Data::F32(self.values(values)),
            Data::F64(values) => Data::F64(self.values(values)),
            Data::I32(values) => Data::I32(self.values(values)),
            Data::I64(values) => Data::I64(self.values(values)),
            Data::U8(values) => Data::U8(self.values(values)),
        }
    }

    fn values<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.starts.iter().flat_map(|start| &values[*start..start + self.length]).copied().collect()
    }
}
