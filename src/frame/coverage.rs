//! The spheres that the samples of each pixel show, and how many samples show each: mattes of objects are made of them.

use crate::view::ray::NONE;
use crate::window::Window;
use halfline_ground::parallel;

/// A sphere in a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cover {
    /// Column of the pixel in the frame's window.
    pub column: u32,
    /// Index of the sphere in the scene's order.
    pub id: u32,
    /// Samples of the pixel that show it.
    pub samples: u32,
}

/// The spheres that the samples of the pixels of a window show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage {
    /// Samples of each pixel.
    pub samples: u32,
    /// Each row of the window: its covers by column, the covers of a pixel in the order of the samples that show them first.
    pub rows: Vec<Vec<Cover>>,
}

impl Coverage {
    /// The coverage of a window before the first sample.
    pub(crate) fn new(window: Window) -> Self {
        Self { samples: 0, rows: vec![Vec::new(); window.height() as usize] }
    }

    /// The most bytes of a pixel with so many samples, while the last one is added.
    pub(crate) fn pixel_bytes(samples: u64) -> u64 {
        (samples + 1) * size_of::<Cover>() as u64
    }

    /// Adds one sample of every pixel: the spheres `ids` of rows of `width` pixels; only `window` is counted.
    pub(crate) fn add(&mut self, ids: &[u32], window: Window, width: u32) {
        self.samples += 1;
        parallel::fill(&mut self.rows[..], 1, &|rows, row| {
            let ids = &ids[(window.y0 as usize + rows.start) * width as usize..];
            row[0] = merged(&row[0], &ids[window.x0 as usize..window.x1 as usize]);
        });
    }
}

/// The covers of a row with one more sample of each of its pixels.
fn merged(row: &[Cover], ids: &[u32]) -> Vec<Cover> {
    let mut merged = Vec::with_capacity(row.len() + ids.len());
    let mut known = row.iter().peekable();
    for (column, id) in (0..).zip(ids) {
        let first = merged.len();
        merged.extend(std::iter::from_fn(|| known.next_if(|cover| cover.column == column)).copied());
        let same = merged[first..].iter_mut().find(|cover| cover.id == *id);
        match same {
            Some(cover) => cover.samples += 1,
            None if *id == NONE => {}
            None => merged.push(Cover { column, id: *id, samples: 1 }),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Rng;
    use std::collections::BTreeMap;

    /// Against a map of all samples that are counted.
    #[test]
    fn every_sample_of_the_window_is_counted_once() {
        let mut rng = Rng(5);
        let (window, width) = (Window { x0: 2, y0: 1, x1: 7, y1: 4 }, 9);
        let (mut coverage, mut counts) = (Coverage::new(window), BTreeMap::new());
        for _ in 0..20 {
            let ids: Vec<u32> = (0..width * 6).map(|_| [NONE, 0, 3, 4][rng.between(0.0, 4.0) as usize]).collect();
            coverage.add(&ids, window, width);
            for (y, x) in (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| (y, x))) {
                let id = ids[(y * width + x) as usize];
                if id != NONE {
                    *counts.entry((y - window.y0, x - window.x0, id)).or_insert(0) += 1;
                }
            }
        }
        let rows = (0..).zip(&coverage.rows);
        let found = rows.flat_map(|(y, row)| row.iter().map(move |c| ((y, c.column, c.id), c.samples)));
        assert_eq!(found.clone().count(), counts.len(), "each sphere of a pixel once");
        assert_eq!((coverage.samples, found.collect::<BTreeMap<_, _>>()), (20, counts));
        assert!(coverage.rows.iter().all(|row| row.is_sorted_by_key(|cover| cover.column)));
    }
}
