//! A grid of coloured cells.

use std::collections::BTreeMap;
use std::fmt::Write;

/// A grid of square cells of colour.
pub(super) struct Cells {
    /// The upper left corner.
    pub(super) at: (i32, i32),
    /// The side of a cell.
    pub(super) side: f64,
    /// Columns and rows.
    pub(super) size: [usize; 2],
    /// sRGB, row by row.
    pub(super) colors: Vec<[u8; 3]>,
}

impl Cells {
    pub(super) fn new(at: (i32, i32), side: f64, size: [usize; 2], color: impl Fn(usize) -> [u8; 3]) -> Self {
        Self { at, side, size, colors: (0..size[0] * size[1]).map(color).collect() }
    }

    /// The cells as SVG: the runs of a row in one path per colour, because a rectangle per cell would need megabytes.
    pub(super) fn svg(&self) -> String {
        let [columns, rows] = self.size;
        let mut paths: BTreeMap<[u8; 3], (usize, String)> = BTreeMap::new();
        for row in 0..rows {
            let colors = &self.colors[row * columns..][..columns];
            let mut first = 0;
            while first < columns {
                let run = colors[first..].iter().take_while(|color| **color == colors[first]).count();
                let (covered, path) = paths.entry(colors[first]).or_default();
                *covered += run;
                // Writing to a String cannot fail.
                let _ = write!(path, "M{first} {row}h{run}v1h-{run}z");
                first += run;
            }
        }
        let mut svg = format!(
            "<g transform=\"translate({} {}) scale({:.5})\" shape-rendering=\"crispEdges\">\n",
            self.at.0, self.at.1, self.side
        );
        // The most frequent colour is drawn first over the whole area, so that it needs no path.
        let ground = paths.iter().max_by_key(|(_, (covered, _))| *covered).map(|(color, _)| *color);
        let hex = |[r, g, b]: [u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
        if let Some(ground) = ground {
            let _ = writeln!(svg, "<path fill=\"{}\" d=\"M0 0h{columns}v{rows}h-{columns}z\"/>", hex(ground));
        }
        for (color, (_, path)) in paths.iter().filter(|(color, _)| Some(**color) != ground) {
            let _ = writeln!(svg, "<path fill=\"{}\" d=\"{path}\"/>", hex(*color));
        }
        svg + "</g>\n"
    }
}
