//! Names of files for several pictures, with a place for the number.

use halfline::error::{Error, Result};
use std::path::{Path, PathBuf};

/// `path` with the number in place of `%d`, or of `%04d` with at least that many digits; unchanged where there is no
/// such place.
pub(super) fn numbered(path: &Path, number: u64) -> PathBuf {
    let Some((place, width)) = path.to_str().and_then(pattern) else { return path.to_path_buf() };
    let text = path.to_string_lossy();
    PathBuf::from(format!("{}{number:0width$}{}", &text[..place.0], &text[place.1..]))
}

/// The number that turns `path` into `file`, if there is one.
pub(super) fn number_in(path: &Path, file: &Path) -> Option<u64> {
    let ((start, end), _) = path.to_str().and_then(pattern)?;
    let text = path.to_str()?;
    let digits = file.to_str()?.strip_prefix(&text[..start])?.strip_suffix(&text[end..])?;
    digits.parse().ok().filter(|number| numbered(path, *number) == file)
}

/// The position of the pattern and its digits.
fn pattern(text: &str) -> Option<((usize, usize), usize)> {
    text.match_indices('%').find_map(|(at, _)| {
        let digits = text[at + 1..].find(|c: char| !c.is_ascii_digit())?;
        let width = &text[at + 1..at + 1 + digits];
        let end = at + 1 + digits;
        text[end..].starts_with('d').then(|| ((at, end + 1), width.parse().unwrap_or(0).min(32)))
    })
}

/// Returns an error for a name without a place for the number when there are several pictures.
pub(super) fn check_pattern(path: &Path) -> Result<()> {
    if path.to_str().and_then(pattern).is_some() || path == Path::new("-") {
        return Ok(());
    }
    let name = path.display();
    let (stem, ending) = (path.file_stem().unwrap_or_default(), path.extension().unwrap_or_default());
    let mend = format!("use a name with a place for the number: {}.%04d.{}", stem.display(), ending.display());
    Err(Error::settings(format!("several pictures cannot have the same name {name}"), mend))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_into_names() {
        let name = |text: &str| numbered(Path::new(text), 7).display().to_string();
        assert_eq!(name("a.%04d.png"), "a.0007.png");
        assert_eq!(name("100%-%d.png"), "100%-7.png");
        assert_eq!(name("plain.png"), "plain.png");
        assert_eq!(name("%99999999999999999999d"), "7");
        let number = |pattern: &str, file: &str| number_in(Path::new(pattern), Path::new(file));
        assert_eq!((number("a.%04d.png", "a.0007.png"), number("a.%04d.png", "a.7.png")), (Some(7), None));
        assert_eq!((number("a%d", "a+7"), number("a%d", "a"), number("a", "a")), (None, None, None));
        check_pattern(Path::new("x.png")).expect_err("no place");
        check_pattern(Path::new("x%d.png")).expect("a place");
    }
}
