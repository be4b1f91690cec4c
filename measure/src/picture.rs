//! Two arrays and their difference as one picture: expected | difference | actual.

use super::compare::{Difference, distance_at, is_beyond};
use super::{Array, Values};
use halfline::error::{Error, Result};
use halfline::parallel;
use halfline_files::write::format::FileFormat;
use halfline_files::write::{file, png};
use std::path::Path;

/// Checks that the picture can be written to `path`, for use before the work begins.
///
/// # Errors
/// [`Error::Settings`] for an extension other than .png, [`Error::Io`] as [`file::check_writable`].
pub fn check(path: &Path) -> Result<()> {
    if !file::is_standard_output(path) && !file::is_special(path) && FileFormat::of(path) != Some(FileFormat::Png) {
        let problem = format!("{} cannot hold the picture of the difference", path.display());
        return Err(Error::settings(problem, "use the file name extension .png"));
    }
    file::check_writable(path)
}

/// Writes A | difference | B side by side as one PNG of 3 W x H pixels; `-` is standard output.
///
/// Pictures are shown unchanged but without alpha; other arrays from black at the minimum to white at the maximum
/// finite value of both, +inf white, -inf and NaN black. The difference is black where equal, grey within the
/// tolerance, and red to yellow beyond it, with brightness relative to the largest finite difference.
///
/// # Errors
/// [`Error::Settings`] for arrays that are unlike or empty, else as [`file::write_atomically`].
pub fn write(a: &Array, b: &Array, difference: &Difference, path: &Path) -> Result<()> {
    let [rows, columns, channels] = a.layout();
    if let Some(why) = &difference.unlike {
        return Err(Error::settings(format!("the difference has no picture: {why}"), "remove -o"));
    }
    if a.values().is_empty() {
        return Err(Error::settings("the difference has no picture: there are no pixels", "remove -o"));
    }
    let scale = GreyScale::of(a, b);
    let row_values = columns * channels;
    // A row of the picture: expected | difference | actual.
    let line = |row: usize| {
        let mut levels = vec![0; columns * 9];
        let (expected, rest) = levels.split_at_mut(columns * 3);
        let (between, actual) = rest.split_at_mut(columns * 3);
        for column in 0..columns {
            let (first, at) = (row * row_values + column * channels, column * 3..column * 3 + 3);
            expected[at.clone()].copy_from_slice(&scale.pixel(a, first, channels));
            actual[at.clone()].copy_from_slice(&scale.pixel(b, first, channels));
            let farthest =
                (first..first + channels).map(|i| distance_at(a.values(), b.values(), i)).fold(0.0, f64::max);
            between[at].copy_from_slice(&scale.difference(farthest, difference.tolerance));
        }
        levels
    };
    let text = |keyword: &str, text: &str| (keyword.to_owned(), text.to_owned());
    let provenance = [
        text("Software", concat!("halfline ", env!("CARGO_PKG_VERSION"))),
        text("Title", "expected | difference | actual"),
        text("Source", &format!("{} | {}", a.name(), b.name())),
    ];
    file::write_atomically(path, |out| {
        png::write_levels([columns * 3, rows], &provenance, out, |out| {
            // Several rows at a time, each in a thread.
            let together = ((1 << 22) / (columns * 9)).max(1);
            (0..rows).step_by(together).try_for_each(|first| {
                let some = first..(first + together).min(rows);
                let lines = parallel::blocks(some, 1, &|_, rows| line(rows.start));
                lines.iter().try_for_each(|line| out.write_all(line))
            })
        })
    })
}

/// The values of black and white.
struct GreyScale {
    least: f64,
    greatest: f64,
    /// The largest finite difference.
    farthest: f64,
}

impl GreyScale {
    fn of(a: &Array, b: &Array) -> Self {
        let finite = |array: &Array| {
            (0..array.values().len())
                .filter_map(|i| array.values().get(i))
                .map(super::ArrayValue::to_f64)
                .filter(|x| x.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, greatest), x| (least.min(x), greatest.max(x)))
        };
        let ((a_least, a_greatest), (b_least, b_greatest)) = (finite(a), finite(b));
        let farthest = (0..a.values().len()).map(|i| distance_at(a.values(), b.values(), i)).filter(|x| x.is_finite());
        Self {
            least: a_least.min(b_least),
            greatest: a_greatest.max(b_greatest),
            farthest: farthest.fold(0.0, f64::max),
        }
    }

    fn pixel(&self, array: &Array, first: usize, channels: usize) -> [u8; 3] {
        // Grey with or without alpha, else the first three components.
        let grey = channels < 3;
        std::array::from_fn(|channel| self.level(array, if grey { first } else { first + channel }))
    }

    fn level(&self, array: &Array, index: usize) -> u8 {
        match array.values() {
            Values::U8(values) if array.is_picture() => values[index],
            Values::U16(values) if array.is_picture() => (values[index] >> 8) as u8,
            // Halves, so that the range of the largest numbers stays finite; the cast saturates.
            values => {
                let x = values.get(index).map_or(f64::NAN, super::ArrayValue::to_f64);
                (255.0 * ((x / 2.0 - self.least / 2.0) / (self.greatest / 2.0 - self.least / 2.0))).round() as u8
            }
        }
    }

    fn difference(&self, apart: f64, tolerance: f64) -> [u8; 3] {
        if apart == 0.0 {
            return [0; 3];
        }
        // A minimum brightness keeps a single differing pixel visible.
        let share = if apart.is_finite() { apart / self.farthest } else { 1.0 };
        let level = (64.0 + 191.0 * share) as u8;
        if is_beyond(apart, tolerance) { [255, level, 0] } else { [level; 3] }
    }
}
