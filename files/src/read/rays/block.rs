//! Rows of rays: their numbers, what makes one invalid, and blocks of them.

use halfline::error::{Error, Result};
use halfline::progress::Watch;
use halfline::quote::setting::SKIP_INVALID;
use halfline::render::trace::Rays;

/// The names of the columns, in the order of a row's numbers.
pub const COLUMNS: [&str; 7] = ["ox", "oy", "oz", "dx", "dy", "dz", "tmax"];

/// The columns without tmax, which is optional.
pub(super) const REQUIRED: usize = 6;

/// Options for reading rays.
#[derive(Debug, Clone, Default)]
pub struct RayOptions {
    /// Leaves invalid rows out of the rays and counts them; otherwise the first one is an error.
    pub skip_invalid: bool,
    /// Can cancel the reading.
    pub watch: Watch,
}

/// The rays of consecutive rows.
#[derive(Debug, Default)]
pub struct RayBlock {
    /// The origins of the valid rows, or a single one for all.
    pub origins: Vec<[f64; 3]>,
    /// Their directions, of any length but zero.
    pub directions: Vec<[f64; 3]>,
    /// Their limits, or none at all if the file has none.
    pub limits: Vec<f64>,
    /// The places of the invalid rows in the block, from 0, in ascending order.
    pub invalid: Vec<u32>,
    /// The error of the first invalid row; `None` where all rows are valid.
    pub fault: Option<Error>,
}

impl RayBlock {
    /// The number of rows, the invalid ones included.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.directions.len() + self.invalid.len()
    }

    /// The valid rows.
    #[must_use]
    pub fn rays(&self) -> Rays<'_> {
        Rays { origins: &self.origins, directions: &self.directions, limits: &self.limits }
    }

    /// Adds a valid row.
    pub(super) fn push(&mut self, [ox, oy, oz, dx, dy, dz, tmax]: Row, limited: bool) {
        self.origins.push([ox, oy, oz]);
        self.directions.push([dx, dy, dz]);
        if limited {
            self.limits.push(tmax);
        }
    }

    /// Counts an invalid row, or returns its error where none may be left out.
    pub(super) fn leave_out(&mut self, options: &RayOptions, fault: impl FnOnce() -> Error) -> Result<()> {
        if !options.skip_invalid {
            return Err(fault());
        }
        self.invalid.push(self.rows() as u32);
        self.fault.get_or_insert_with(fault);
        Ok(())
    }

    /// Adds the rows of another block behind its own.
    pub(super) fn append(&mut self, mut other: Self) {
        let before = self.rows() as u32;
        self.invalid.extend(other.invalid.iter().map(|place| before + place));
        self.origins.append(&mut other.origins);
        self.directions.append(&mut other.directions);
        self.limits.append(&mut other.limits);
        self.fault = self.fault.take().or(other.fault);
    }
}

/// The numbers of a row.
pub(super) type Row = [f64; 7];

/// The field and the problem of an invalid row; `None` for a valid row.
pub(super) fn flaw([ox, oy, oz, dx, dy, dz, tmax]: &Row) -> Option<(&'static str, &'static str)> {
    let finite = |point: [&f64; 3]| point.into_iter().all(|x| x.is_finite());
    if !finite([ox, oy, oz]) {
        Some(("origin", "a coordinate is not finite"))
    } else if !finite([dx, dy, dz]) {
        Some(("direction", "a component is not finite"))
    } else if [dx, dy, dz].into_iter().all(|x| *x == 0.0) {
        Some(("direction", "the direction is zero"))
    } else if tmax.is_nan() {
        Some(("tmax", "the limit is NaN"))
    } else {
        None
    }
}

/// The remedy for an invalid row.
pub(super) fn mend_row() -> String {
    format!("correct the row, or use {SKIP_INVALID} to count it as a miss")
}
