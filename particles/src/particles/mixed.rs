//! Columns whose rows decide what they are: columns of texts where some row has a text, else of numbers.

use super::names::Names;
use halfline_ground::error::Result;
use halfline_ground::memory::check;
use std::collections::BTreeMap;

/// Words for a number that is missing, in lower case, as R, pandas, astropy, databases and spreadsheets write them. A column of
/// texts has them as texts.
const MISSING: [&str; 13] = ["na", "n/a", "#n/a", "#na", "<na>", "null", "none", "nil", "-", "--", "?", ".", "\\n"];

/// Whether a text is a word for a number that is missing.
pub(super) fn is_missing(text: &str) -> bool {
    text.len() <= 4 && MISSING.iter().any(|word| word.eq_ignore_ascii_case(text))
}

/// Whether a text is no number and no word for one that is missing.
pub(crate) fn is_text(text: &str) -> bool {
    !text.is_empty() && !is_missing(text) && text.parse::<f64>().is_err()
}

/// The rows of such a column so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mixed {
    /// The index of the column.
    pub(super) column: usize,
    /// The texts of all rows while they are numbers, each with [`END`] behind it.
    spelled: Vec<u8>,
    /// Whether some row has a number, and whether one has a word for a missing number.
    has_number: bool,
    has_word: bool,
    /// The texts, once some row has one; the values are then their numbers.
    names: Option<Names>,
}

/// The byte behind a text, which UTF-8 does not have.
const END: u8 = 0xff;

/// The bytes of a row's text that the memory is checked for.
pub(super) const SPELLED: usize = 12;

impl Mixed {
    /// No rows of a column yet.
    pub(super) fn of(column: usize) -> Self {
        Self { column, ..Self::default() }
    }

    /// Adds a row with this text to the values of the column.
    ///
    /// # Errors
    /// [`Error::Limits`](halfline_ground::error::Error::Limits) where memory is short.
    pub(super) fn add(&mut self, text: &str, values: &mut Vec<f64>) -> Result<()> {
        if self.names.is_none() {
            let number = text.parse().ok();
            self.has_number |= number.is_some();
            if number.is_none() && !text.is_empty() {
                if !is_missing(text) {
                    self.name(values)?;
                }
                self.has_word = true;
            }
            if self.names.is_none() {
                self.spelled.extend_from_slice(text.as_bytes());
                self.spelled.push(END);
                values.push(number.unwrap_or(f64::NAN));
            }
        }
        if let Some(names) = &mut self.names {
            values.push(names.number(text.as_bytes())?.into());
        }
        Ok(())
    }

    /// Adds the rows of a later part of the file, whose values are appended by the caller.
    ///
    /// # Errors
    /// As [`Mixed::add`].
    pub(super) fn append(&mut self, values: &mut [f64], mut more: Self, others: &mut [f64]) -> Result<()> {
        self.has_number |= more.has_number;
        self.has_word |= more.has_word;
        if self.names.is_none() && more.names.is_none() {
            self.spelled.append(&mut more.spelled);
            return Ok(());
        }
        self.name(values)?;
        more.name(others)?;
        if let (Some(names), Some(more)) = (&mut self.names, more.names) {
            names.renumber(&more, others)?;
        }
        Ok(())
    }

    /// Turns the values into values of a column of texts.
    fn name(&mut self, values: &mut [f64]) -> Result<()> {
        if self.names.is_some() {
            return Ok(());
        }
        let mut names = Names::default();
        for (text, value) in std::mem::take(&mut self.spelled).split(|byte| *byte == END).zip(values) {
            *value = names.number(text)?.into();
        }
        self.names = Some(names);
        Ok(())
    }

    /// The texts of a column of texts, once all rows are there; `None` for a column of numbers. Words for missing numbers alone are
    /// texts.
    ///
    /// # Errors
    /// As [`Mixed::add`].
    pub(super) fn settle(mut self, values: &mut [f64]) -> Result<Option<Vec<String>>> {
        if self.has_word && !self.has_number {
            check(32 * values.len() as u64, || "a column of texts".into())?;
            self.name(values)?;
        }
        Ok(self.names.map(|names| names.labels()))
    }

    /// Makes the values numbers, NaN for a text, and forgets the rows; returns the texts and words for missing numbers with their
    /// numbers.
    pub(super) fn take_texts(&mut self, values: &mut [f64]) -> BTreeMap<String, u64> {
        let mut texts = BTreeMap::new();
        let Self { spelled, has_word, names, .. } = std::mem::replace(self, Self::of(self.column));
        if let Some(names) = names {
            let labels = names.labels();
            let numbers: Vec<f64> = labels.iter().map(|text| text.parse().unwrap_or(f64::NAN)).collect();
            let mut counts = vec![0; labels.len()];
            for value in values {
                counts[*value as usize] += 1;
                *value = numbers[*value as usize];
            }
            let named = labels.into_iter().zip(counts);
            texts.extend(named.filter(|(text, _)| !text.is_empty() && text.parse::<f64>().is_err()));
        } else if has_word {
            for text in spelled.split(|byte| *byte == END).filter_map(|text| str::from_utf8(text).ok()) {
                if is_missing(text) {
                    *texts.entry(text.to_owned()).or_default() += 1;
                }
            }
        }
        texts
    }
}

#[cfg(test)]
mod tests;
