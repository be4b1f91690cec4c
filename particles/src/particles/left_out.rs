//! Rows that are left out because their coordinates or their radius are invalid.

use halfline_ground::error::{Error, Place};
use halfline_ground::quote::{count, shortened};

/// The number of rows, and the first of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct LeftOut {
    count: u64,
    /// Its place and problem.
    first: Option<(Box<Place>, String)>,
}

/// The longest name of a column in the message, in characters.
const FIELD: usize = 80;

impl LeftOut {
    /// Whether no row was left out.
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Counts a row that has this error.
    pub(crate) fn add(&mut self, error: Error) {
        self.count += 1;
        if let (None, Error::Scene { place, problem, .. }) = (&self.first, error) {
            self.first = Some((place, problem));
        }
    }

    /// Counts the rows of a later part of the file.
    pub(super) fn append(&mut self, more: Self) {
        self.count += more.count;
        self.first = self.first.take().or(more.first);
    }

    /// The warning; `None` where no row was left out.
    pub(crate) fn sentence(self) -> Option<String> {
        let (place, problem) = self.first?;
        let line = place.line.map_or_else(String::new, |line| format!(" in line {line}"));
        let field = place.field.unwrap_or_default();
        let field = shortened(&field, FIELD);
        Some(format!("{} left out, the first{line}: {field}: {problem}", count(self.count, "row")))
    }
}
