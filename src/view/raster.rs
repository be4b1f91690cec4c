//! The rays of a frame: through the centres of the window's pixels, or through samples of them.
//!
//! A sample is a pixel of a finer frame of W K x H K pixels, so every formula and every bound holds for it with W K and
//! H K in place of W and H. A pixel is divided into n x n strata of J x J finer pixels, K = n J. Each stratum is
//! sampled at one of them, chosen by a hash of row, column, sample and seed.

use super::records::ViewRecord;
use crate::scene::{ImagePlane, MAX_SIDE};
use crate::window::Window;
use bytemuck::Zeroable;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{APERTURE, SAMPLES, SIZE};

/// The most finer pixels along a side of a stratum. Section 8 of docs/certificate.md.
const FINEST: u32 = 16;

/// The rays of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Raster {
    pub(crate) window: Window,
    /// n: strata along a side of a pixel.
    pub(crate) strata: u32,
    /// J: finer pixels along a side of a stratum, a power of two.
    pub(crate) jitter: u32,
    pub(crate) seed: u32,
    /// The offset of the frame of a point of a lens from the frame of the eye: columns to the right and rows down; 0
    /// for a pinhole.
    pub(crate) lens_offset: [f64; 2],
}

/// The most rows of samples in a pixel: light keeps directions for each of their squares.
const STRATA: u32 = 1 << 10;

/// Columns and rows of the samples of a pixel: `samples` of them, at least 1, rounded up to a square number.
#[must_use]
pub fn strata_of(samples: u32) -> u32 {
    samples.saturating_sub(1).isqrt() + 1
}

impl Raster {
    /// Pixel centres.
    pub(crate) fn centres(window: Window) -> Self {
        Self { window, strata: 1, jitter: 1, seed: 0, lens_offset: [0.0; 2] }
    }

    /// `samples` per pixel of the image, rounded up to the next square and placed by `seed`; `None` for one.
    ///
    /// # Errors
    /// [`Error::Limits`] where the finer frame would have more columns or rows than a frame can have.
    pub(crate) fn samples(window: Window, samples: u32, seed: u32, image: &ImagePlane) -> Result<Option<Self>> {
        if samples < 2 {
            return Ok(None);
        }
        let strata = strata_of(samples);
        let most = MAX_SIDE as u32 / image.width.max(image.height).max(1);
        if strata > STRATA {
            let problem = format!("{samples} samples per pixel are too many");
            return Err(Error::Limits { problem, mend: format!("use at most {}", STRATA * STRATA) });
        }
        if strata > most {
            let problem = format!("{samples} samples per pixel are too many for an image of this size");
            return Err(Error::Limits { problem, mend: format!("use at most {}, or a smaller {SIZE}", most * most) });
        }
        let mut jitter = FINEST;
        while strata * jitter > most {
            jitter /= 2;
        }
        Ok(Some(Self { window, strata, jitter, seed, lens_offset: [0.0; 2] }))
    }

    /// The same where frames are larger by this many pixels on each side: with fewer finer pixels if they must be.
    ///
    /// # Errors
    /// [`Error::Limits`] where the finer frame would have more columns or rows than a frame can have.
    pub(crate) fn with_margin(mut self, pixels: f64, image: &ImagePlane) -> Result<Self> {
        // A place more on each side for the rounding of the move.
        let side = f64::from(image.width.max(image.height)) + 2.0 * (pixels + 1.0);
        let fits = |jitter: u32| f64::from(self.strata) * f64::from(jitter) * side <= MAX_SIDE as f64;
        while self.jitter > 1 && !fits(self.jitter) {
            self.jitter /= 2;
        }
        if fits(self.jitter) {
            return Ok(self);
        }
        let samples = self.count();
        let problem =
            format!("the lens moves the frame by {pixels:.0} pixels, which is too far for {samples} samples per pixel");
        Err(Error::Limits { problem, mend: format!("use a smaller {APERTURE}, fewer {SAMPLES} or a smaller {SIZE}") })
    }

    /// The record of these rays, with the background of a miss and without the numbers of a camera.
    pub(crate) fn record(&self, [red, green, blue]: [f32; 3]) -> ViewRecord {
        ViewRecord {
            background: [red, green, blue, 0.0],
            first_row: self.window.y0,
            rows: self.window.height(),
            first_column: self.window.x0,
            columns: self.window.width(),
            strata: self.strata,
            jitter: self.jitter,
            seed: self.seed,
            ..ViewRecord::zeroed()
        }
    }

    /// Samples of a pixel.
    pub(crate) fn count(&self) -> u32 {
        self.strata.saturating_mul(self.strata)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(samples: u32, width: u32, height: u32) -> Result<Option<Raster>> {
        let image = ImagePlane { width, height, background: [0.0; 3] };
        Raster::samples(Window::full(width, height), samples, 0, &image)
    }

    #[test]
    fn samples_are_the_next_square_within_the_limits_of_a_frame() {
        let cut = |samples, side| raster(samples, side, 5).expect("room").map(|r| [r.count(), r.jitter]);
        assert_eq!([cut(0, 64), cut(1, 64)], [None; 2]);
        assert_eq!([cut(2, 64), cut(4, 64), cut(5, 64)], [Some([4, 16]), Some([4, 16]), Some([9, 16])]);
        // At most 2^20 columns: exactly that many, or one short of twice as many.
        assert_eq!([cut(64, 1 << 13), cut(64, (1 << 13) + 1)], [Some([64, 16]), Some([64, 8])]);
        assert_eq!([cut(16, 1 << 18), cut(9, 1 << 18)], [Some([16, 1]), Some([9, 1])]);
        raster(u32::MAX, 17, 1).expect_err("2^16 strata of 17 columns");
        let error = raster(17, 1 << 18, 1).expect_err("5 x 2^18").to_string();
        assert!(error.contains("at most 16"), "{error}");
    }
}
