//! Values of a list in a selection: names with wildcards, and ranges of numbers with insertion codes.

use super::expression::Value;
use super::selection::Selection;
use glob::Pattern;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::quote;
use std::fmt;

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Word(word) => f.write_str(word),
            Self::Range(first, last) => write!(f, "{first} to {last}"),
        }
    }
}

/// A number and an insertion code; without a code it is blank.
type Bound = (f64, String);

/// The numbers from one bound to another, both included. Codes are compared where the numbers are equal.
pub(super) struct Range {
    first: Bound,
    last: Bound,
}

impl Range {
    /// The range of a value.
    ///
    /// # Errors
    /// [`Error::Settings`] for a value that is not a number or a range of numbers.
    pub(super) fn of(value: &Value, column: &str, selection: &Selection) -> Result<Self> {
        let range = match value {
            Value::Range(first, last) => bound(first).zip(bound(last)),
            Value::Word(word) => split(word),
        };
        let fail = || {
            let problem = format!("{column} is a number in this file, and {} is not", quote(&value.to_string()));
            Error::settings(
                format!("selection `{}`: {problem}", selection.brief()),
                "use numbers and ranges such as 7, 10:20 or 10 to 20",
            )
        };
        range.map(|(first, last)| Self { first, last }).ok_or_else(fail)
    }

    /// Whether a number is in the range.
    pub(super) fn contains(&self, x: f64) -> bool {
        self.first.0 <= x && x <= self.last.0
    }

    /// Whether a number with an insertion code is in the range.
    pub(super) fn contains_with_code(&self, x: f64, code: &str) -> bool {
        let after = x > self.first.0 || x == self.first.0 && code >= self.first.1.as_str();
        let before = x < self.last.0 || x == self.last.0 && code <= self.last.1.as_str();
        after && before
    }
}

/// A number, and a letter after it.
fn bound(text: &str) -> Option<Bound> {
    if let Ok(number) = text.parse::<f64>() {
        return Some((number, String::new()));
    }
    let (code, _) = text.char_indices().next_back()?;
    let number = text[..code].parse().ok().filter(|_| text[code..].chars().all(char::is_alphanumeric))?;
    Some((number, text[code..].to_owned()))
}

/// `7`, `10:20`, `10-20`: a minus sign at the beginning of a number is its sign.
fn split(text: &str) -> Option<(Bound, Bound)> {
    if let Some(only) = bound(text) {
        return Some((only.clone(), only));
    }
    let marks = text.char_indices().skip(1).filter(|(_, c)| ":-".contains(*c));
    marks.map(|(at, _)| bound(&text[..at]).zip(bound(&text[at + 1..]))).find_map(|range| range)
}

/// A name with the wildcards `*`, `?` and `[...]`, as in a shell; text that is not a pattern means itself.
pub(super) fn pattern(value: &Value) -> Pattern {
    let mut text = value.to_string();
    // Several asterisks mean the same as one; the crate gives them a meaning for paths.
    while text.contains("**") {
        text = text.replace("**", "*");
    }
    Pattern::new(&text).or_else(|_| Pattern::new(&Pattern::escape(&text))).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(text: &str) -> Range {
        let selection = format!("resid {text}").parse().expect("a selection");
        Range::of(&Value::Word(text.into()), "resid", &selection).expect("a range")
    }

    #[test]
    fn ranges_of_numbers_may_be_negative_and_have_codes() {
        for (text, inside, outside) in [
            ("7", vec![7.0], vec![6.0, 8.0, 7.5, f64::NAN]),
            ("10:20", vec![10.0, 15.5, 20.0], vec![9.0, 21.0]),
            ("10-20", vec![10.0, 20.0], vec![-20.0]),
            ("-5:-3", vec![-5.0, -4.0, -3.0], vec![4.0]),
            ("-5--3", vec![-5.0, -3.0], vec![5.0, -2.0]),
            ("1e2", vec![100.0], vec![1.0]),
            ("-2.5:1e1", vec![0.0], vec![11.0]),
            ("20:10", vec![], vec![15.0]),
        ] {
            let range = range(text);
            assert!(inside.iter().all(|x| range.contains(*x)), "{text}");
            assert!(!outside.iter().any(|x| range.contains(*x)), "{text}");
        }
        let codes = range("163A:166B");
        for (number, code, expected) in [
            (163.0, "", false),
            (163.0, "A", true),
            (164.0, "Z", true),
            (166.0, "", true),
            (166.0, "B", true),
            (166.0, "C", false),
        ] {
            assert_eq!(codes.contains_with_code(number, code), expected, "{number}{code}");
        }
        assert!(range("163").contains_with_code(163.0, "") && !range("163").contains_with_code(163.0, "A"));
        let selection = "resid x".parse().expect("a selection");
        for bad in ["x", "1:", ":2", "1:x", "--1", ""] {
            Range::of(&Value::Word(bad.into()), "resid", &selection).map(drop).expect_err(bad);
        }
    }

    #[test]
    fn names_have_the_wildcards_of_a_shell() {
        let is = |text: &str, name: &str| pattern(&Value::Word(text.into())).matches(name);
        assert!(is("C*", "CA") && is("C*", "C") && !is("C*", "HC") && is("?A", "CA") && is("[CN]?", "NA"));
        assert!(is("O5'", "O5'") && is("C**", "CB") && is("[C", "[C") && is("**", "any") && !is("ca", "CA"));
    }
}
