//! Texts among the numbers of columns. A survey counts them, and the column is one of text; other readings report the
//! first of them as an error.

use halfline::error::Result;
use halfline::memory::Ledger;
use std::collections::BTreeMap;

/// The number of each text, by the index of its column.
#[derive(Debug, Clone, Default)]
pub(in crate::read) struct Mixed {
    counts: BTreeMap<usize, BTreeMap<String, u64>>,
    ledger: Ledger,
}

/// Bytes per text, besides its letters, in a map.
const TEXT: usize = 64;

impl Mixed {
    /// Counts a text.
    ///
    /// # Errors
    /// [`Error::Limits`](halfline::error::Error::Limits) where memory is short.
    pub(super) fn add(&mut self, column: usize, text: &str, count: u64) -> Result<()> {
        let counts = self.counts.entry(column).or_default();
        if let Some(known) = counts.get_mut(text) {
            *known += count;
            return Ok(());
        }
        self.ledger.add(TEXT + text.len())?;
        counts.insert(text.to_owned(), count);
        Ok(())
    }

    /// Adds the texts of a later part of the file.
    ///
    /// # Errors
    /// As [`Mixed::add`].
    pub(super) fn append(&mut self, more: Self) -> Result<()> {
        for (column, counts) in more.counts {
            counts.iter().try_for_each(|(text, count)| self.add(column, text, *count))?;
        }
        Ok(())
    }

    /// The texts of each column that has some.
    pub(in crate::read) fn into_counts(self) -> BTreeMap<usize, BTreeMap<String, u64>> {
        self.counts
    }
}
