//! Compares two arrays: the places and sizes of their differences.

use super::{Array, ArrayValue, Values};
use halfline::parallel::{self, CHEAP};

/// The result of [`compare`]. Differences are absolute, in the files' own units (PNG: levels).
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// The tolerance.
    pub tolerance: f64,
    /// Why the arrays cannot be compared value by value, such as different shapes; the other fields are then zero and
    /// empty.
    pub unlike: Option<String>,
    /// The number of pixels.
    pub pixels: usize,
    /// Pixels in which any component differs.
    pub differing: usize,
    /// Pixels in which any component differs by more than the tolerance.
    pub beyond: usize,
    /// The share of the pixels that may, from 0 to 1.
    pub share: f64,
    /// The largest difference of two values.
    pub max: f64,
    /// The mean difference over all values; infinite if one is.
    pub mean: f64,
    /// The first place of the largest difference; `None` where all values are equal.
    pub at: Option<At>,
}

/// A value in both arrays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// RowDifference, from 0 at the top.
    pub row: usize,
    /// Column, from 0 at the left.
    pub column: usize,
    /// Component of the pixel, from 0.
    pub channel: usize,
    /// The first array's value.
    pub a: ArrayValue,
    /// The second array's value.
    pub b: ArrayValue,
}

impl Difference {
    /// Whether the arrays are equal within the tolerance, but for the share of pixels that need not be.
    pub fn is_within(&self) -> bool {
        self.unlike.is_none() && self.beyond as f64 <= self.share * self.pixels as f64
    }
}

/// Compares value by value; `tolerance` is the largest allowed difference, 0 or more, which this share of the pixels may exceed.
///
/// Numbers of different types are compared as numbers: integers exactly, others in f64. NaN equals NaN, and an infinity
/// equals itself; against anything else they differ infinitely, beyond any tolerance. Arrays of different shapes, and
/// pictures of 8 and of 16 bits, are [unlike](Difference::unlike).
pub fn compare(a: &Array, b: &Array, tolerance: f64, share: f64) -> Difference {
    let [rows, columns, channels] = a.layout();
    let mut found = Difference {
        tolerance,
        unlike: unlike(a, b),
        pixels: rows * columns,
        differing: 0,
        beyond: 0,
        share,
        max: 0.0,
        mean: 0.0,
        at: None,
    };
    if found.unlike.is_some() || a.values().is_empty() {
        return found;
    }
    let width = columns * channels;
    let row =
        |row: usize| RowDifference::of(a.values(), b.values(), row * width..(row + 1) * width, channels, tolerance);
    let per_row = parallel::values(rows, (CHEAP / width).max(1), row);
    // Summed in the order of the rows, so that the mean does not depend on the threads.
    for row in per_row {
        found.differing += row.differing;
        found.beyond += row.beyond;
        found.mean += row.sum;
        if row.max > found.max {
            found.max = row.max;
            found.at = row.at.and_then(|index| {
                let (row, column, channel) = (index / width, index % width / channels, index % channels);
                Some(At { row, column, channel, a: a.values().get(index)?, b: b.values().get(index)? })
            });
        }
    }
    found.mean /= a.values().len() as f64;
    found
}

/// Why two arrays have no common pixels to compare.
fn unlike(a: &Array, b: &Array) -> Option<String> {
    if a.shape() != b.shape() {
        return Some(format!("the shapes are {} and {}", sides(a.shape()), sides(b.shape())));
    }
    let (this, that) = (a.values().dtype(), b.values().dtype());
    (a.is_picture() && b.is_picture() && this != that)
        .then(|| format!("the pictures have levels of {this} and of {that}"))
}

/// A shape as text: `480 x 640 x 3`.
pub fn sides(shape: &[usize]) -> String {
    match shape {
        [] => "one value".into(),
        _ => shape.iter().map(ToString::to_string).collect::<Vec<_>>().join(" x "),
    }
}

/// The difference of two values.
pub(crate) fn distance(a: ArrayValue, b: ArrayValue) -> f64 {
    if let (ArrayValue::Int(a), ArrayValue::Int(b)) = (a, b) {
        return a.abs_diff(b) as f64;
    }
    let (a, b) = (a.to_f64(), b.to_f64());
    if a == b || a.is_nan() && b.is_nan() {
        return 0.0;
    }
    let apart = (a - b).abs();
    if apart.is_nan() { f64::INFINITY } else { apart }
}

/// Whether a difference exceeds `tolerance`; infinity always does.
pub(crate) fn is_beyond(distance: f64, tolerance: f64) -> bool {
    distance > 0.0 && !(distance <= tolerance && distance.is_finite())
}

/// The difference at `index`, which both arrays have.
pub(crate) fn distance_at(a: &Values, b: &Values, index: usize) -> f64 {
    a.get(index).zip(b.get(index)).map_or(0.0, |(a, b)| distance(a, b))
}

/// The sums of one row.
#[derive(Default)]
struct RowDifference {
    differing: usize,
    beyond: usize,
    sum: f64,
    max: f64,
    at: Option<usize>,
}

impl RowDifference {
    fn of(a: &Values, b: &Values, row: std::ops::Range<usize>, channels: usize, tolerance: f64) -> Self {
        let mut found = Self::default();
        for pixel in row.step_by(channels) {
            let mut farthest = 0.0;
            for index in pixel..pixel + channels {
                let apart = distance_at(a, b, index);
                found.sum += apart;
                if apart > farthest {
                    farthest = apart;
                }
                if apart > found.max {
                    (found.max, found.at) = (apart, Some(index));
                }
            }
            found.differing += usize::from(farthest > 0.0);
            found.beyond += usize::from(is_beyond(farthest, tolerance));
        }
        found
    }
}
