//! The fields of a line of a table.

use crate::read::lines::{Lines, Word};
use halfline::error::Result;
use std::io::BufRead;

/// Whether a line is neither blank nor a comment.
pub(crate) fn has_content(line: &str) -> bool {
    let text = line.trim_start();
    !text.is_empty() && !text.starts_with('#')
}

/// The delimiter of a line.
pub(crate) fn delimiter(line: &str) -> u8 {
    [b'\t', b';', b','].into_iter().find(|delimiter| line.as_bytes().contains(delimiter)).unwrap_or(b' ')
}

/// The fields of the current line from a byte on, without padding and quotes.
pub(crate) fn fields<R: BufRead>(
    lines: &Lines<R>,
    start: usize,
    delimiter: u8,
) -> impl Iterator<Item = Word<'_, R>> + Clone {
    let text = lines.text().as_bytes();
    let blank = move |byte: &u8| byte.is_ascii_whitespace() && (*byte != delimiter || delimiter == b' ');
    let ends = move |byte: &u8| if delimiter == b' ' { byte.is_ascii_whitespace() } else { *byte == delimiter };
    let mut start = Some(start);
    std::iter::from_fn(move || {
        let raw = start?;
        let at = raw + text[raw..].iter().take_while(|byte| blank(byte)).count();
        if delimiter == b' ' && at == text.len() {
            return None;
        }
        let quoted = quoted(&text[at..]).filter(|length| {
            let after = text[at + length..].iter().find(|byte| !blank(byte) || ends(byte));
            after.is_none_or(ends)
        });
        let from = at + quoted.unwrap_or(0);
        let end = from + text[from..].iter().position(ends).unwrap_or(text.len() - from);
        start = (end < text.len()).then_some(end + 1);
        let (mut first, mut last) = match quoted {
            Some(length) => (at + 1, at + length - 1),
            None => (at, end),
        };
        while first < last && text[first].is_ascii_whitespace() {
            first += 1;
        }
        while first < last && text[last - 1].is_ascii_whitespace() {
            last -= 1;
        }
        let mut word = lines.word(first, last);
        word.at = at;
        Some(word)
    })
}

/// The length of the quoted text that begins here; a doubled quote is a quote.
fn quoted(text: &[u8]) -> Option<usize> {
    let mut at = 1;
    if text.first() != Some(&b'"') {
        return None;
    }
    loop {
        at += text[at..].iter().position(|byte| *byte == b'"')? + 1;
        if text.get(at) != Some(&b'"') {
            return Some(at);
        }
        at += 1;
    }
}

/// Moves to the next line with content.
pub(super) fn next<R: BufRead>(lines: &mut Lines<R>) -> Result<bool> {
    while lines.advance()? {
        if has_content(lines.text()) {
            return Ok(true);
        }
    }
    Ok(false)
}
