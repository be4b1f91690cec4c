//! Images whose principal point is not their middle. The lecture's viewport reaches from l to r and from b to t; such an
//! image is a part of a larger one whose middle is the principal point, and its pixels are pixels of that frame, or of a
//! finer one if the principal point lies between the middles and the borders of pixels.

use super::{Camera, Lens, Viewport, too_unlike};
use crate::double_double::{self as dd, Dd};
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{APERTURE, SAMPLES};

/// The most columns and rows of a frame, 2^20: twice as many odd numbers are exact in f32.
/// Section 8a of docs/certificate.md.
const MAX_PLACES: i64 = 1 << 20;

/// The most parts of a pixel in which the principal point is given.
const MAX_PARTS_OF_PIXEL: u32 = 256;

/// The strata along a side of a pixel that must be possible beside the parts: 64 samples.
const STRATA: f64 = 8.0;

/// A frame whose middle is the principal point, and the place of an image's rays in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CentredFrame {
    /// Of the whole frame.
    pub(crate) viewport: ExactViewport,
    /// Columns and rows.
    pub(crate) size: [u32; 2],
    /// Columns, or rows, of the frame from a place of a ray to the next.
    pub(crate) step: u32,
    /// Column and row of the image's first place.
    pub(crate) shift: [u32; 2],
}

/// A [`Viewport`] without rounded numbers: its height is `tall` fx / fy, a quotient that f64 cannot hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ExactViewport {
    /// Width.
    pub(crate) vw: f64,
    /// Distance from the eye, infinite for parallel rays.
    pub(crate) d: f64,
    /// The height but for `pitch`.
    pub(crate) tall: f64,
    /// fx and fy; 1 and 1 where they are equal, and for lenses without them.
    pub(crate) pitch: [f64; 2],
}

impl From<Viewport> for ExactViewport {
    fn from(Viewport { vw, vh, d }: Viewport) -> Self {
        Self { vw, d, tall: vh, pitch: [1.0; 2] }
    }
}

impl ExactViewport {
    /// Whether the rays through it are parallel.
    pub(crate) fn is_parallel(&self) -> bool {
        self.d.is_infinite()
    }

    /// Width and height, the latter rounded.
    pub(crate) fn rounded(&self) -> [f64; 2] {
        [self.vw, self.height_over(0, 1.0)]
    }

    /// The height times 2^-`k` is x y / z, exact away from the limits of f64, with y and z in [1, 2).
    pub(crate) fn height(&self, k: i32) -> [f64; 3] {
        let [up, down] = self.pitch.map(dd::exponent);
        let [y, z] = [dd::ldexp(self.pitch[0], -up), dd::ldexp(self.pitch[1], -down)];
        [dd::ldexp(self.tall, up - down - k), y, z]
    }

    /// The height times 2^-`k` over `divisor`: rounded once.
    pub(crate) fn height_over(&self, k: i32, divisor: f64) -> f64 {
        let [x, y, z] = self.height(k);
        let near = x * y / z / divisor;
        if y == z || !near.is_finite() {
            return near;
        }
        let e = dd::exponent(divisor);
        let [x, ..] = self.height(k + e);
        (Dd::product(x, y) / Dd::product(z, dd::ldexp(divisor, -e))).value()
    }
}

impl CentredFrame {
    /// The frame of an eye that is moved aside: the same places of rays lie `offset` columns and rows of it farther
    /// toward the first column and row. The frame is as much larger, on both sides, as that takes.
    ///
    /// # Errors
    /// [`Error::Limits`] for more than 2^20 columns or rows.
    pub(crate) fn moved(self, offset: [f64; 2]) -> Result<Self> {
        let mut frame = self;
        let sides = [&mut frame.viewport.vw, &mut frame.viewport.tall];
        for (k, side) in sides.into_iter().enumerate().filter(|(k, _)| offset[*k] != 0.0) {
            let (by, count) = (offset[k], f64::from(self.size[k]));
            let wide = count + 2.0 * by.abs();
            if wide.is_nan() || wide > MAX_PLACES as f64 {
                let problem =
                    format!("the lens is so large that a frame needs {wide} places, and {MAX_PLACES} are possible");
                return Err(Error::Limits {
                    problem,
                    mend: format!("use a smaller {APERTURE}, fewer {SAMPLES} or a smaller image"),
                });
            }
            *side = *side * wide / count;
            frame.size[k] = wide as u32;
            frame.shift[k] += (by.abs() - by) as u32;
        }
        Ok(frame)
    }
}

impl Camera {
    /// The frame for an image of `width` x `height` pixels, each divided into `strata` x `strata` parts with `jitter` x
    /// `jitter` places for rays. A place n from the left is column n step + shift; with a principal point in the middle of
    /// the image that is n.
    ///
    /// # Errors
    /// Errors of [`Camera::viewport`]; [`Error::Limits`] for more than 2^20 columns or rows.
    pub(crate) fn centred(&self, [width, height]: [u32; 2], strata: u32, jitter: u32) -> Result<CentredFrame> {
        let viewport = self.viewport(width, height)?;
        let Lens::Intrinsics { fx, fy, cx, cy } = self.lens else {
            let size = [width, height].map(|side| side * strata * jitter);
            return Ok(CentredFrame { viewport: viewport.into(), size, step: 1, shift: [0; 2] });
        };
        let parts = parts([width, height], [cx, cy]);
        let step = (parts / jitter).max(1);
        let fine = i64::from(strata) * i64::from(jitter) * i64::from(step);
        let axis = |side: u32, center: f64| {
            // Twice the principal point's column in the finer frame; `fine` is a multiple of the parts.
            let middle = halves(center, parts) * (fine / i64::from(parts));
            // The ray of place n is (2 n + 1) step - middle half columns from the principal point; the frame is wide enough
            // for all of them, and its middle is the principal point.
            let shift = (fine * i64::from(side) - middle + i64::from(step) - 1).max(0);
            [shift, 2 * shift + 1 - i64::from(step) + middle]
        };
        let ([left, columns], [top, rows]) = (axis(width, cx), axis(height, cy));
        if columns.max(rows) > MAX_PLACES {
            let problem = format!(
                "the principal point {cx}, {cy} of an image of {width} x {height} pixels with {} samples per pixel needs a \
                 frame of {columns} x {rows} places, and {MAX_PLACES} are possible",
                strata * strata
            );
            return Err(Error::Limits { problem, mend: format!("use fewer {SAMPLES}, or a smaller image") });
        }
        let [w, h] = [columns, rows].map(|side| side as f64 / fine as f64);
        let pitch = if fx == fy { [1.0; 2] } else { [fx, fy] };
        let viewport = ExactViewport { vw: w, d: fx, tall: h, pitch };
        if !viewport.height_over(0, 1.0).is_finite() {
            return Err(too_unlike(fx, fy));
        }
        Ok(CentredFrame { viewport, size: [columns as u32, rows as u32], step, shift: [left as u32, top as u32] })
    }

    /// The principal point of the rays, in pixels from the top left corner: the lens's, rounded to a share of a pixel, or
    /// the middle. The share is a half, or between 1/512 and 1/32 by the size of the image.
    pub(crate) fn principal_point(&self, [width, height]: [u32; 2]) -> [f64; 2] {
        match self.lens {
            Lens::Intrinsics { cx, cy, .. } => {
                let parts = parts([width, height], [cx, cy]);
                [cx, cy].map(|center| halves(center, parts) as f64 / f64::from(2 * parts))
            }
            Lens::Curved { cx, cy, .. } => [cx, cy],
            _ => [width, height].map(|side| f64::from(side) / 2.0),
        }
    }
}

/// The number of parts along a side of a pixel: 1 where the principal point is a whole number of half pixels, else a power
/// of two that leaves room for samples.
fn parts(size: [u32; 2], center: [f64; 2]) -> u32 {
    if center.iter().all(|x| (2.0 * x).fract() == 0.0) {
        return 1;
    }
    let reach = |k: usize| center[k].abs().max((f64::from(size[k]) - center[k]).abs());
    let side = 2.0 * reach(0).max(reach(1)) + 2.0;
    let mut parts = MAX_PARTS_OF_PIXEL;
    while parts > 1 && STRATA * f64::from(parts) * side > MAX_PLACES as f64 {
        parts /= 2;
    }
    parts
}

/// Twice a number of pixels in parts of a pixel, rounded.
fn halves(center: f64, parts: u32) -> i64 {
    (2.0 * center * f64::from(parts)).round() as i64
}
