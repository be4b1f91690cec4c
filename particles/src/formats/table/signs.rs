//! Signs of tables of numbers, with names of columns and without.

use super::fields::declared_delimiter;
use super::names::axes;
use crate::formats::scenes::is_native;
use crate::lines::comment;
use crate::signs::table_rows;

/// A header that names the coordinates; it may be a comment or follow comments. A scene file may have such a comment.
pub(crate) fn is_csv(lines: &[&str]) -> bool {
    if is_native(lines) {
        return false;
    }
    let mut before = true;
    let first = |line: &&&str| std::mem::replace(&mut before, line.trim().is_empty() || comment(line.trim()) > 0);
    let is_declared = lines.first().is_some_and(|line| declared_delimiter(line).is_some());
    lines.iter().skip(usize::from(is_declared)).take_while(first).any(|line| {
        let header = line.trim()[comment(line.trim())..].trim();
        let names = |delimiters: &[char]| -> Vec<String> {
            header.split(delimiters).map(|name| name.trim().trim_matches('"').to_owned()).collect()
        };
        // `x (km)` is one name where commas separate, and two where spaces do.
        [&[',', ';', '\t', '|'][..], &[' ']].iter().any(|delimiters| axes(&names(delimiters)).is_some())
    })
}

/// Lines of 3, 4, 6 or 7 numbers, as many in each, perhaps behind their number; not atoms with their atomic numbers.
pub(crate) fn is_points(lines: &[&str]) -> bool {
    let rows: Vec<Vec<&str>> = table_rows(lines).skip(usize::from(counts(lines))).collect();
    let is_row = |row: &Vec<&str>| row.len() == rows[0].len() && row.iter().all(|word| word.parse::<f64>().is_ok());
    let is_atom = |row: &Vec<&str>| row.len() == 4 && matches!(row[0].parse(), Ok(1..=118_u32));
    rows.first().is_some_and(|row| matches!(row.len(), 3 | 4 | 6 | 7))
        && rows.iter().all(|row| is_row(row) || row.len() == 1 && row[0].parse::<u64>().is_ok())
        && !(rows.iter().all(is_atom) && rows.iter().any(|row| row[3].parse::<i64>().is_err()))
}

/// Points behind their number, with colours: no other format has such lines.
pub(crate) fn is_scan(lines: &[&str]) -> bool {
    counts(lines) && is_points(lines) && table_rows(lines).nth(1).is_some_and(|row| row.len() >= 6)
}

/// Whether the first line with content is a whole number alone.
pub(crate) fn counts(lines: &[&str]) -> bool {
    table_rows(lines).next().is_some_and(|row| row.len() == 1 && row[0].parse::<u64>().is_ok())
}
