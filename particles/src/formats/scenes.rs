//! Scene files, which another crate reads: the native one, TOML, and Haines' Neutral File Format. They are recognised here.

use crate::format::FormatRow;
use crate::format::Sign::Lines;
use crate::signs::content_lines;

pub(crate) const NATIVE: FormatRow = FormatRow { name: "toml", about: "the native scene file", ..FormatRow::PLAIN };

pub(crate) const NFF: FormatRow =
    FormatRow { name: "nff", about: "Haines' Neutral File Format", signs: &[Lines(is_nff)], ..FormatRow::PLAIN };

/// Whether lines have the tables of a scene file.
pub(crate) fn is_native(lines: &[&str]) -> bool {
    let tables = ["[camera]", "[image]", "[[sphere]]", "[[spheres]]"];
    content_lines(lines).any(|line| tables.contains(&line.split('#').next().unwrap_or_default().trim_end()))
}

/// Text without another format's signature and without a known name is taken as a scene file, unless it cannot be TOML.
pub(crate) fn native(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    // `[table]`, or a key, perhaps of several words with dots between them, and its value.
    let key = |text: &str| {
        !text.trim().is_empty() && text.trim().chars().all(|c| c.is_alphanumeric() || "_-.\"'".contains(c))
    };
    let plain = |line: &str| line.starts_with('[') || line.split_once('=').is_some_and(|(name, _)| key(name));
    content_lines(&lines).next().is_none_or(plain)
}

/// The words that begin a statement of NFF.
pub const NFF_DIRECTIVES: [&str; 8] = ["v", "b", "l", "f", "s", "c", "p", "pp"];

pub(crate) fn is_nff(lines: &[&str]) -> bool {
    content_lines(lines).next().is_some_and(|line| {
        let mut words = line.split_whitespace().take_while(|word| !word.starts_with('#'));
        let Some(directive) = words.next().filter(|word| NFF_DIRECTIVES.contains(word)) else { return false };
        let numbers: Vec<&str> = words.collect();
        // `v` with numbers is a vertex of OBJ.
        (directive != "v" || numbers.is_empty()) && numbers.iter().all(|word| word.parse::<f64>().is_ok())
    })
}
