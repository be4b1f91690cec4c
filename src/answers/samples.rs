//! Means over the samples of each pixel.

use super::raw::Raw;
use crate::view::ray::NONE;
use crate::window::Window;
use halfline_ground::error::Result;
use halfline_ground::memory::Pool;
use halfline_ground::parallel::{self, CHEAP, Rows};

/// The means over all samples of each pixel.
#[derive(Debug, Default)]
pub(crate) struct Means {
    /// Linear RGB, three numbers per pixel; empty if colour is not requested.
    pub(crate) color: Vec<f32>,
    /// Share of the samples that hit a sphere, of translucent ones by their opacity.
    pub(crate) alpha: Vec<f32>,
}

impl Means {
    /// The means of `count` samples in a window, from the sums of colour and coverage, four numbers a pixel, of rows of `width` pixels.
    pub(crate) fn of_part(sums: &[f32], window: Window, width: u32, count: u32) -> Self {
        let pixels = window.width() as usize * window.height() as usize;
        let mut means = Self { color: vec![0.0; 3 * pixels], alpha: vec![0.0; pixels] };
        let each = window.width() as usize;
        let rows = (Rows { values: &mut means.color, each: 3 * each }, Rows { values: &mut means.alpha, each });
        parallel::fill(rows, 1, &|row, (color, alpha)| {
            let first = 4 * ((window.y0 as usize + row.start) * width as usize + window.x0 as usize);
            let pixels = sums[first..first + 4 * each].chunks_exact(4);
            for ((sums, color), alpha) in pixels.zip(color.values.chunks_exact_mut(3)).zip(alpha.values) {
                let [red, green, blue, cover] = [0, 1, 2, 3].map(|k| sums[k] / count as f32);
                color.copy_from_slice(&[red, green, blue]);
                *alpha = cover;
            }
        });
        means
    }

    /// The pixels of a window alone, of rows of `width` pixels.
    pub(crate) fn part(&self, window: Window, width: u32) -> Self {
        let rows = |values: &[f32], each: usize| {
            let row = |y: u32| {
                let [first, end] = [window.x0, window.x1].map(|x| each * (y as usize * width as usize + x as usize));
                values.get(first..end).unwrap_or_default().iter().copied()
            };
            (window.y0..window.y1).flat_map(row).collect()
        };
        Self { color: rows(&self.color, 3), alpha: rows(&self.alpha, 1) }
    }
}

/// Sums over samples. f64 holds the sum of equal colours exactly, so flat areas keep their colour to the last bit.
pub(crate) struct Sums {
    color: Vec<f64>,
    /// Of what is covered; f32 holds the sum of so many ones exactly.
    cover: Vec<f32>,
}

impl Sums {
    /// Zeros for `pixels` pixels, with colour or without.
    ///
    /// # Errors
    /// [`crate::Error::Limits`] when the memory cannot be allocated.
    pub(crate) fn new(pixels: usize, color: bool, pool: &Pool) -> Result<Self> {
        let mut sums = Self { color: pool.values(if color { 3 * pixels } else { 0 })?, cover: pool.values(pixels)? };
        parallel::fill(&mut sums.color[..], CHEAP, &|_, color| color.fill(0.0));
        parallel::fill(&mut sums.cover[..], CHEAP, &|_, cover| cover.fill(0.0));
        Ok(sums)
    }

    /// Adds one sample of every pixel; `passing` is the share of what it shows that layers before it let pass, empty without layers.
    pub(crate) fn add(&mut self, raw: &Raw, passing: &[f32]) {
        parallel::fill(&mut self.color[..], CHEAP, &|range, sums| {
            sums.iter_mut().zip(&raw.color[range]).for_each(|(sum, x)| *sum += f64::from(*x));
        });
        parallel::fill(&mut self.cover[..], CHEAP, &|range, cover| {
            let hits = cover.iter_mut().zip(&raw.id[range.clone()]);
            match passing {
                [] => hits.for_each(|(cover, id)| *cover += f32::from(*id != NONE)),
                _ => hits
                    .zip(&passing[range])
                    .for_each(|((cover, id), passing)| *cover += if *id == NONE { 1.0 - passing } else { 1.0 }),
            }
        });
    }

    /// The means of `count` samples.
    ///
    /// # Errors
    /// [`crate::Error::Limits`] when the memory cannot be allocated.
    pub(crate) fn means(self, count: u32, pool: &Pool) -> Result<Means> {
        let count = f64::from(count);
        let mut means = Means { color: pool.values(self.color.len())?, alpha: pool.values(self.cover.len())? };
        parallel::zip(&mut means.color, &self.color, |mean, sum| *mean = (sum / count) as f32);
        parallel::zip(&mut means.alpha, &self.cover, |mean, cover| *mean = (f64::from(*cover) / count) as f32);
        pool.put_back(self.color);
        pool.put_back(self.cover);
        Ok(means)
    }
}
