//! Words of a line.

use super::Lines;
use halfline::error::{Error, Result};
use halfline::quote::quote;
use std::borrow::Cow;
use std::io::BufRead;

/// A word of a line.
pub(in crate::read) struct Word<'a, R> {
    /// Its bytes in the line; see [`Word::content`].
    pub(in crate::read) text: &'a str,
    /// The position of its first byte.
    pub(in crate::read) at: usize,
    /// Whether it stood in quotes.
    pub(in crate::read) is_quoted: bool,
    pub(super) lines: &'a Lines<R>,
}

impl<'a, R: BufRead> Word<'a, R> {
    /// The text: a doubled quote within quotes is one (RFC 4180, section 2).
    pub(in crate::read) fn content(&self) -> Cow<'a, str> {
        if self.is_quoted && self.text.contains("\"\"") {
            return self.text.replace("\"\"", "\"").into();
        }
        self.text.into()
    }

    /// Parses a finite number; errors name `field`.
    pub(in crate::read) fn finite(&self, field: &str) -> Result<f64> {
        let number = self.number(field)?;
        if number.is_finite() { Ok(number) } else { Err(self.wrong(field, "is not finite")) }
    }

    /// Parses a positive finite number.
    pub(in crate::read) fn positive(&self, field: &str) -> Result<f64> {
        let number = self.finite(field)?;
        if number > 0.0 { Ok(number) } else { Err(self.wrong(field, "is not positive")) }
    }

    /// Parses any number, including infinities and NaN.
    pub(in crate::read) fn number(&self, field: &str) -> Result<f64> {
        self.text.parse().map_err(|_| self.wrong(field, "is not a number"))
    }

    /// Parses a whole number.
    pub(in crate::read) fn whole(&self, field: &str) -> Result<i64> {
        let problem = || format!("{} is not a whole number", quote(self.text));
        let place = || self.lines.place(self.at).named(field);
        self.text.parse().map_err(|_| Error::scene(place(), problem(), "use a whole number such as 7"))
    }

    fn wrong(&self, field: &str, what: &str) -> Error {
        let problem = match self.text {
            "" => "the field is blank".to_owned(),
            text => format!("{} {what}", quote(text)),
        };
        Error::scene(
            self.lines.place(self.at).named(field),
            problem,
            mend_number(self.text, "use a finite number such as 0.5"),
        )
    }
}

/// The remedy for a text that is not a finite number: the number respelled where the text has a Fortran exponent or a
/// decimal comma, else `otherwise`.
pub(in crate::read) fn mend_number(text: &str, otherwise: &str) -> String {
    let spelled = |spelling: String| Some(spelling).filter(|text| text.parse::<f64>().is_ok_and(f64::is_finite));
    if let Some(number) = spelled(text.replace(['D', 'd'], "E")).filter(|_| text.parse::<f64>().is_err()) {
        return format!("write the exponent with E, as in {number}");
    }
    if let Some(number) = spelled(text.replacen(',', ".", 1)).filter(|_| text.parse::<f64>().is_err()) {
        return format!("write decimals with a point, as in {number}");
    }
    otherwise.to_owned()
}

/// The words of a line, separated by white space.
pub(in crate::read) struct Words<'a, R> {
    lines: &'a Lines<R>,
    at: usize,
}

impl<R> Clone for Words<'_, R> {
    fn clone(&self) -> Self {
        Self { lines: self.lines, at: self.at }
    }
}

impl<'a, R: BufRead> Words<'a, R> {
    /// The words of the current line.
    pub(in crate::read) fn of(lines: &'a Lines<R>) -> Self {
        Self { lines, at: 0 }
    }
}

impl<'a, R: BufRead> Iterator for Words<'a, R> {
    type Item = Word<'a, R>;

    fn next(&mut self) -> Option<Self::Item> {
        // Splitting by bytes is safe, because the separators are ASCII and no part of another character.
        let bytes = self.lines.text.as_bytes();
        let at = self.at + bytes.get(self.at..)?.iter().position(|b| !b.is_ascii_whitespace())?;
        let end = bytes[at..].iter().position(u8::is_ascii_whitespace).map_or(bytes.len(), |length| at + length);
        self.at = end;
        Some(self.lines.word(at, end))
    }
}
