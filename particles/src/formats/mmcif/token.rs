//! Kinds of the words of a CIF file, and its numbers.

/// The kind of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Token {
    /// `data_` and a name.
    Block,
    /// `loop_`.
    Loop,
    /// The name of a value, which begins with `_`.
    Tag,
    Value,
    /// `save_`, `global_`, `stop_`, which occur in dictionaries but not in data.
    Other,
    End,
}

/// The part of a value that its reader needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Want {
    Word,
    /// A number; any other value as a word.
    Number,
    Nothing,
}

/// A number, optionally with its uncertainty in brackets: `1.234(5)`.
pub(super) fn number(value: &[u8]) -> Option<f64> {
    let end = value.iter().position(|byte| *byte == b'(').unwrap_or(value.len());
    let text = std::str::from_utf8(&value[..end]).ok()?;
    text.trim_ascii().parse().ok().filter(|x: &f64| x.is_finite())
}
