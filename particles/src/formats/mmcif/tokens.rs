//! The words of a CIF file, in text or in BinaryCIF.

use super::binary::BinaryTokens;
use super::text::TextTokens;
use super::token::{Token, Want};
use crate::lines::{Lines, Spot};
use crate::source::Source;
use halfline_ground::error::{Place, Result};
use std::io::BufRead;

/// A file's words.
pub(super) enum Tokens {
    Text(Box<TextTokens>),
    Binary(Box<BinaryTokens>),
}

/// The same for both.
macro_rules! either {
    ($tokens:expr, $found:ident => $result:expr) => {
        match $tokens {
            Tokens::Text($found) => $result,
            Tokens::Binary($found) => $result,
        }
    };
}

impl Tokens {
    /// The words of a file; of BinaryCIF the words of categories with a tag that, in lower case, `is_used` knows.
    pub(super) fn new(mut source: Source, is_used: fn(&str) -> bool) -> Self {
        // An error is returned by the next reading.
        let is_binary = source.reader.fill_buf().is_ok_and(|bytes| bytes.first().is_some_and(|byte| is_map(*byte)));
        match is_binary {
            true => Self::Binary(Box::new(BinaryTokens::new(source, is_used))),
            false => Self::Text(Box::new(TextTokens::new(Lines::new(source.reader, &source.path)))),
        }
    }

    /// Moves to the next word.
    pub(super) fn next(&mut self) -> Result<Token> {
        either!(self, tokens => tokens.next())
    }

    /// Moves to the next word; `want` is the part that is needed. Words of text are words in any case.
    pub(super) fn next_as(&mut self, want: Want) -> Result<Token> {
        match self {
            Self::Text(tokens) => tokens.next(),
            Self::Binary(tokens) => tokens.next_as(want),
        }
    }

    /// The current value, where it was moved to as a number of a binary file.
    pub(super) fn number(&self) -> Option<f64> {
        if let Self::Binary(tokens) = self { tokens.number() } else { None }
    }

    /// Puts the current word back, to be returned again.
    pub(super) fn give_back(&mut self, token: Token) {
        either!(self, tokens => tokens.give_back(token));
    }

    /// The current word; empty at the end.
    pub(super) fn word(&self) -> &[u8] {
        either!(self, tokens => tokens.word())
    }

    /// The current value; empty for `.` and `?`, which mean none.
    pub(super) fn value(&self) -> &[u8] {
        either!(self, tokens => tokens.value())
    }

    /// The current value as text.
    ///
    /// # Errors
    /// [`Error::Scene`](halfline_ground::error::Error::Scene) for a text too long to be a name or a list of names.
    pub(super) fn string(&self) -> Result<String> {
        either!(self, tokens => tokens.string())
    }

    /// The error for a value whose quote is not closed, which others follow in its row.
    ///
    /// # Errors
    /// As [`TextTokens::check_quote`].
    pub(super) fn check_quote(&self) -> Result<()> {
        if let Self::Text(tokens) = self { tokens.check_quote() } else { Ok(()) }
    }

    /// The message about values whose quote is not closed.
    pub(super) fn quote_warning(&mut self) -> Option<String> {
        if let Self::Text(tokens) = self { tokens.quote_warning() } else { None }
    }

    /// Reports that the current line contains an atom.
    pub(super) fn found(&self) {
        if let Self::Text(tokens) = self {
            tokens.found();
        }
    }

    /// The place of the current word.
    pub(super) fn place(&self) -> Place {
        self.spot().of(self.file())
    }

    /// The same, for a later error.
    pub(super) fn spot(&self) -> Spot {
        either!(self, tokens => tokens.spot())
    }

    pub(super) fn file(&self) -> Place {
        either!(self, tokens => tokens.file())
    }
}

/// Whether a byte begins a map of MessagePack; no text begins with it.
fn is_map(byte: u8) -> bool {
    matches!(byte, 0x80..=0x8f | 0xde | 0xdf)
}
