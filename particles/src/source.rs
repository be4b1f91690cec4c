//! The bytes and the path of a file, from which a reader of its format reads.

use super::input::Input;
use std::path::PathBuf;

/// An opened file.
pub struct Source {
    /// Its bytes.
    pub reader: Input,
    /// The path as the user gave it; `-` is standard input.
    pub path: PathBuf,
}

#[cfg(test)]
impl Source {
    /// A source from text, for the readers' tests.
    pub(crate) fn of_text(text: &str) -> Self {
        Self::of_bytes(text.as_bytes())
    }

    /// As [`Source::of_text`].
    pub(crate) fn of_bytes(bytes: &[u8]) -> Self {
        Self { reader: Input::of_bytes(bytes), path: "text".into() }
    }
}
