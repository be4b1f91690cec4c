//! Quotes text of files in messages: words, column names, paths. Control characters never reach the terminal, and long
//! texts are shortened. The names of settings, which each front end writes in its own way.

pub mod setting;

use std::borrow::Cow;
use std::fmt::{self, Display, Formatter, Write};

/// Characters of a quoted word; a longer word is cut there and ends in `...`.
pub const LONGEST: usize = 40;

/// The most names that a message lists; it counts the others.
const LISTED: usize = 16;

/// Text of a file between backticks: at most [`LONGEST`] characters, with control characters escaped and invalid UTF-8
/// replaced.
pub fn quote<T: AsRef<[u8]> + ?Sized>(text: &T) -> Quote<'_> {
    Quote { text: text.as_ref(), longest: LONGEST, mark: "`" }
}

/// As [`quote`] without the backticks, for names in a list.
pub fn unquoted<T: AsRef<[u8]> + ?Sized>(text: &T) -> Quote<'_> {
    Quote { mark: "", ..quote(text) }
}

/// As [`unquoted`], but of at most `longest` characters.
pub fn shortened(text: &str, longest: usize) -> Quote<'_> {
    Quote { text: text.as_bytes(), longest, mark: "" }
}

/// Names separated by commas: the first `LISTED` of them, and the number of the others.
pub fn list<T: AsRef<[u8]>>(names: impl IntoIterator<Item = T>) -> String {
    let mut names = names.into_iter();
    let mut shown: Vec<String> = names.by_ref().take(LISTED).map(|name| unquoted(&name).to_string()).collect();
    match names.count() {
        0 => {}
        more => shown.push(format!("{more} more")),
    }
    shown.join(", ")
}

/// A number for a message, with `digits` significant digits: `0.4985` or `12`, with an exponent only below 0.001 and from
/// a million on.
pub fn number(x: f64, digits: usize) -> String {
    let rounded = format!("{x:.*e}", digits.saturating_sub(1));
    let exponent = rounded.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    match exponent {
        _ if x == 0.0 => "0".into(),
        Some(exponent @ -3..6) => {
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            // Rounded first, so that digits before the point are significant too.
            rounded.parse::<f64>().map_or(rounded, |x| format!("{x:.decimals$}"))
        }
        _ => rounded,
    }
}

/// A number of things: `1 sphere`, `2 spheres`, `2 patches`.
pub fn count(n: u64, noun: &str) -> String {
    match n {
        1 => format!("1 {noun}"),
        _ if noun.ends_with("ch") => format!("{n} {noun}es"),
        _ => format!("{n} {noun}s"),
    }
}

/// The opening mark of a [`setting`]'s name. Its second character has no width, and [`quote`] escapes it in text of
/// files.
const OPEN: &str = "`\u{2060}";

/// The message with a front end's word in place of each [`setting`], its backticks included: an option, a keyword.
#[must_use]
pub fn reworded(message: &str, word: impl Fn(&str) -> String) -> String {
    let mut parts = message.split(OPEN);
    let mut words = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (name, rest) = named(part).map_or((OPEN.to_owned(), part), |(name, rest)| (word(name), rest));
        words += &name;
        words += rest;
    }
    words
}

/// The name of a setting, and the text behind it, from the text behind the opening mark.
fn named(text: &str) -> Option<(&str, &str)> {
    let is_name = |name: &str| !name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_');
    text.split_once('`').filter(|(name, _)| is_name(name))
}

/// A message with every control character escaped, except line feeds; the marks of settings stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_safe = |(at, c): (usize, char)| {
        let marks = || text[..at + c.len_utf8()].ends_with(OPEN) && named(&text[at + c.len_utf8()..]).is_some();
        c == '\n' || !is_control(c) || marks()
    };
    if text.char_indices().all(is_safe) {
        return Cow::Borrowed(text);
    }
    let mut escaped = String::with_capacity(text.len() + 16);
    for (at, c) in text.char_indices() {
        if is_safe((at, c)) { escaped.push(c) } else { escaped.extend(c.escape_default()) }
    }
    Cow::Owned(escaped)
}

/// Whether a terminal interprets the character: control characters (C0, DEL, C1), and those that change the direction
/// of text (Unicode 15, Bidi_Control); and the mark of a setting.
fn is_control(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2060}' | '\u{61c}' | '\u{200e}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Quoted text for a message.
#[derive(Debug, Clone, Copy)]
pub struct Quote<'a> {
    text: &'a [u8],
    longest: usize,
    mark: &'static str,
}

impl Display for Quote<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        // A character has at most four bytes, so these bytes hold all that is shown; a character cut in two lies beyond
        // the last shown.
        let bytes = &self.text[..self.text.len().min(4 * (self.longest + 1))];
        let text = String::from_utf8_lossy(bytes);
        let mut characters = text.chars();
        f.write_str(self.mark)?;
        for c in characters.by_ref().take(self.longest) {
            if is_control(c) { c.escape_default().try_for_each(|c| f.write_char(c))? } else { f.write_char(c)? }
        }
        if characters.next().is_some() {
            f.write_str("...")?;
        }
        f.write_str(self.mark)
    }
}

#[cfg(test)]
mod tests {
    use super::setting::{ACCURACY, SKIP_INVALID};
    use super::*;

    #[test]
    fn numbers_have_exponents_only_where_decimals_are_long() {
        for (x, digits, shown) in [
            (0.0, 2, "0"),
            (0.498_52, 4, "0.4985"),
            (0.01, 2, "0.010"),
            (0.000_999_6, 2, "0.0010"),
            (0.000_1, 2, "1.0e-4"),
            (12.34, 2, "12"),
            (-123_456.0, 2, "-120000"),
            (999_960.0, 2, "1.0e6"),
            (f64::INFINITY, 2, "inf"),
            (f64::NAN, 2, "NaN"),
        ] {
            assert_eq!(number(x, digits), shown);
        }
    }

    #[test]
    fn one_thing_is_singular() {
        assert_eq!([0, 1, 2].map(|n| count(n, "sphere")), ["0 spheres", "1 sphere", "2 spheres"]);
        assert_eq!(count(2, "polygonal patch"), "2 polygonal patches");
    }

    #[test]
    fn control_characters_are_escaped_and_long_texts_cut() {
        for (text, shown) in [
            ("plain", "`plain`"),
            ("", "``"),
            ("\u{1b}[31mred\u{7}", "`\\u{1b}[31mred\\u{7}`"),
            ("a\tb\nc\r\0", "`a\\tb\\nc\\r\\u{0}`"),
            ("\u{9b}2J \u{202e}gnp.exe \u{61c}", "`\\u{9b}2J \\u{202e}gnp.exe \\u{61c}`"),
            ("Åström 球", "`Åström 球`"),
        ] {
            assert_eq!(quote(text).to_string(), shown);
        }
        assert_eq!(quote(b"\xff\xfe1").to_string(), "`\u{fffd}\u{fffd}1`");
        let long = "球".repeat(1 << 20);
        assert_eq!(quote(&long).to_string(), format!("`{}...`", "球".repeat(LONGEST)));
        assert_eq!(quote(&long[..3 * LONGEST]).to_string(), format!("`{}`", "球".repeat(LONGEST)));
        // An invalid byte before the cut does not move a character across it.
        let odd = [b"\xff".repeat(3), "球".repeat(100).into_bytes()].concat();
        assert_eq!(unquoted(&odd).to_string(), format!("{}{}...", "\u{fffd}".repeat(3), "球".repeat(LONGEST - 3)));
    }

    #[test]
    fn lists_name_the_first_and_count_the_others() {
        let names: Vec<String> = (0..20).map(|n| n.to_string()).collect();
        assert!(list(&names).ends_with("14, 15, 4 more"), "{}", list(&names));
        assert_eq!(list(["a", "\u{1b}"]), "a, \\u{1b}");
    }

    #[test]
    fn settings_are_reworded_and_texts_of_files_are_not() {
        let message = format!("use {ACCURACY} certified or {SKIP_INVALID}");
        let flags = |text: &str| reworded(text, |name| format!("--{}", name.replace('_', "-")));
        assert_eq!(flags(&message), "use --accuracy certified or --skip-invalid");
        assert_eq!(printable(&message), message);
        assert_eq!(message.replace('\u{2060}', ""), "use `accuracy` certified or `skip_invalid`");
        let forged = quote(ACCURACY).to_string();
        assert_eq!((flags(&forged), printable(&forged)), (forged.clone(), forged.clone().into()), "{forged}");
        for text in ["`\u{2060}", "`\u{2060}a b`", "`\u{2060}``", "\u{2060}x`"] {
            assert_eq!(flags(text), text);
            assert!(!printable(text).contains('\u{2060}'), "{text:?}");
        }
    }

    #[test]
    fn messages_keep_line_breaks_and_lose_escapes() {
        assert!(matches!(printable("two\nlines"), Cow::Borrowed(_)));
        assert_eq!(printable("a\u{1b}]0;title\u{7}\nb"), "a\\u{1b}]0;title\\u{7}\nb");
    }
}
