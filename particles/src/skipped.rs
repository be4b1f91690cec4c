//! The report of reading: what a file contains that a scene does not, and what was assumed.

use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::count;

/// The items that a reader left out, counted by kind in the order of first occurrence, and its assumptions.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Skipped {
    /// Kind in the singular (`polygon`) and count.
    pub kinds: Vec<(&'static str, u64)>,
    /// Assumptions about what the file does not say, and choices among what it says: whole sentences, with the numbers.
    pub assumed: Vec<String>,
}

impl Skipped {
    /// Counts one more of `kind`.
    #[doc(hidden)]
    pub fn add(&mut self, kind: &'static str) {
        self.count(kind, 1);
    }

    /// Adds the items left out and the assumptions of another part.
    #[doc(hidden)]
    pub fn append(&mut self, more: Self) {
        more.kinds.into_iter().for_each(|(kind, n)| self.count(kind, n));
        self.assumed.extend(more.assumed);
    }

    fn count(&mut self, kind: &'static str, more: u64) {
        match self.kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, n)) => *n += more,
            None => self.kinds.push((kind, more)),
        }
    }

    /// One warning per kind, then the assumptions.
    pub fn warnings(&self) -> Vec<String> {
        self.kinds
            .iter()
            .map(|(kind, n)| format!("{} skipped: only spheres are rendered", count(*n, kind)))
            .chain(self.assumed.iter().cloned())
            .collect()
    }

    /// Adds this to the count and the warnings of a report, after the first `others` of them.
    #[doc(hidden)]
    pub fn report(&self, skipped: &mut u64, warnings: &mut Vec<String>, others: usize) {
        *skipped = self.total();
        warnings.splice(others..others, self.warnings());
    }

    /// Counts one more of `kind`, or returns an error where it is `strict`.
    #[doc(hidden)]
    pub fn skip(&mut self, kind: &'static str, strict: bool, place: impl FnOnce() -> Place) -> Result<()> {
        if strict {
            let mend = "remove it, or read without strict to skip it";
            return Err(Error::scene(place(), format!("expected a sphere, found a {kind}"), mend));
        }
        self.add(kind);
        Ok(())
    }

    /// The number of skipped items of all kinds.
    pub fn total(&self) -> u64 {
        self.kinds.iter().map(|(_, n)| n).sum()
    }
}
