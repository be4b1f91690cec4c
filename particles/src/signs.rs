//! Lines of the beginning of a file, by which a format recognises its own.

use super::lines::comment;

/// Lines with content: neither blank nor a comment.
pub(crate) fn content_lines<'a>(lines: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
    lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty() && !line.starts_with('#'))
}

pub(crate) fn numbers(words: &str) -> usize {
    words.split_whitespace().take_while(|word| word.parse::<f64>().is_ok()).count()
}

/// The fields of lines that are no comments, whatever separates them.
pub(crate) fn table_rows<'a>(lines: &'a [&'a str]) -> impl Iterator<Item = Vec<&'a str>> {
    let rows = lines.iter().map(|line| line.trim()).filter(|line| !line.is_empty() && comment(line) == 0);
    rows.map(|line| line.split([',', ';', '\t', ' ']).filter(|word| !word.is_empty()).collect())
}
