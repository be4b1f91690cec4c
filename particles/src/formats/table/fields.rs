//! The fields of a line of a table.

use crate::lines::{DELIMITERS, Lines, Word, ends, has_content};
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::quote;
use std::io::BufRead;

/// The delimiter of a line.
pub fn delimiter(line: &str) -> u8 {
    delimiters(line).next().unwrap_or(b' ')
}

/// The delimiters that a line may have, the likely one first: those outside of quotes, and blanks.
pub(super) fn delimiters(line: &str) -> impl Iterator<Item = u8> {
    let (mut found, mut is_quoted) = ([false; DELIMITERS.len()], false);
    for byte in line.bytes() {
        is_quoted ^= byte == b'"';
        if let Some(k) = DELIMITERS.iter().position(|known| *known == byte && !is_quoted) {
            found[k] = true;
        }
    }
    found[DELIMITERS.len() - 1] = true;
    DELIMITERS.into_iter().zip(found).filter_map(|(delimiter, is_there)| is_there.then_some(delimiter))
}

/// The delimiter that a line alone says, as Excel writes it: `sep=;`.
pub fn declared_delimiter(line: &str) -> Option<u8> {
    let line = line.trim_end_matches(['\n', '\r']).trim_matches('"');
    let (key, rest) = line.split_at_checked(4)?;
    match rest.as_bytes() {
        [delimiter] if key.eq_ignore_ascii_case("sep=") && delimiter.is_ascii() => Some(*delimiter),
        _ => None,
    }
}

/// The fields of the current line from a byte on, without padding and quotes.
pub fn fields<R: BufRead>(lines: &Lines<R>, start: usize, delimiter: u8) -> impl Iterator<Item = Word<'_, R>> + Clone {
    let text = lines.text().as_bytes();
    let mut start = Some(start);
    std::iter::from_fn(move || {
        let Field { at, quoted, end } = Field::of(text, start?, delimiter);
        if delimiter == b' ' && at == text.len() {
            return None;
        }
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
        (word.at, word.is_quoted) = (at, quoted.is_some());
        Some(word)
    })
}

/// The index in `names` of each column that the header at byte `start` of the current line names, in any case.
///
/// # Errors
/// [`Error::Scene`] for another name, and for one that occurs twice.
pub fn named_columns<R: BufRead>(
    lines: &Lines<R>,
    (start, delimiter): (usize, u8),
    names: &[&str],
    mend: &str,
) -> Result<Vec<usize>> {
    let fail = |at: usize, problem: String| Error::scene(lines.place(at).named("header"), problem, mend);
    let mut columns = Vec::new();
    for word in fields(lines, start, delimiter) {
        let found = word.content();
        let column = names.iter().position(|name| name.eq_ignore_ascii_case(&found));
        let column = column.ok_or_else(|| fail(word.at, format!("unknown column {}", quote(&*found))))?;
        if columns.contains(&column) {
            return Err(fail(word.at, format!("{} occurs twice", quote(&*found))));
        }
        columns.push(column);
    }
    Ok(columns)
}

/// Gives `put` each number of the current line with the index of its column, one number for each of `columns`.
///
/// # Errors
/// [`Error::Scene`] for fewer numbers, for more, and the errors of `put`.
pub fn each_number<R: BufRead>(
    lines: &Lines<R>,
    delimiter: u8,
    (columns, names): (&[usize], &[&str]),
    mend: &str,
    mut put: impl FnMut(usize, &Word<'_, R>) -> Result<()>,
) -> Result<()> {
    let mut words = fields(lines, 0, delimiter);
    for (found, column) in columns.iter().enumerate() {
        let Some(word) = words.next() else {
            let problem = format!("expected {} numbers, found {found}", columns.len());
            return Err(Error::scene(lines.place(lines.text().len()).named(names[*column]), problem, mend));
        };
        put(*column, &word)?;
    }
    match words.next() {
        None => Ok(()),
        Some(word) => {
            let problem = format!("the row has more than the {} numbers of the others", columns.len());
            Err(Error::scene(lines.place(word.at).named("row"), problem, mend))
        }
    }
}

/// A field of a record: its first byte without padding, the length of its text in quotes, if it is quoted, and its end.
struct Field {
    at: usize,
    quoted: Option<usize>,
    end: usize,
}

impl Field {
    /// The field from a byte on.
    fn of(text: &[u8], raw: usize, delimiter: u8) -> Self {
        let blank = |byte: &u8| byte.is_ascii_whitespace() && (*byte != delimiter || delimiter == b' ');
        let ends = |byte: &u8| ends(*byte, delimiter);
        let at = raw + text[raw..].iter().take_while(|byte| blank(byte)).count();
        let quoted = quoted(&text[at..]).filter(|length| {
            let after = text[at + length..].iter().find(|byte| !blank(byte) || ends(byte));
            after.is_none_or(ends)
        });
        let from = at + quoted.unwrap_or(0);
        let end = from + text[from..].iter().position(ends).unwrap_or(text.len() - from);
        Self { at, quoted, end }
    }
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
