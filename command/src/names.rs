//! Names of files for several pictures, with a place for the number.

use halfline::error::{Error, Result};
use std::path::{Path, PathBuf};

/// A name around its place for the number, as in ffmpeg: `%d`, or `%04d` with at least that many digits; `%%` beside it is a
/// percent sign. Of several places the last one counts. Letters behind it make a word, as in `50%dense`, and no place.
struct Pattern {
    before: String,
    after: String,
    width: usize,
}

impl Pattern {
    /// `None` for a name without a place.
    fn of(path: &Path) -> Option<Self> {
        let (mut found, mut text, mut rest) = (None::<(String, &str)>, String::new(), path.to_str()?);
        while let Some((plain, more)) = rest.split_once('%') {
            text += plain;
            let digits = more.find(|c: char| !c.is_ascii_digit()).unwrap_or(more.len());
            let place = more[digits..].strip_prefix('d').filter(|after| !after.starts_with(char::is_alphabetic));
            rest = match (more.strip_prefix('%'), place) {
                (Some(after), _) => {
                    text.push('%');
                    after
                }
                (None, Some(after)) => {
                    if let Some((before, digits)) = found {
                        text = format!("{before}%{digits}d{text}");
                    }
                    found = Some((std::mem::take(&mut text), &more[..digits]));
                    after
                }
                (None, None) => {
                    text.push('%');
                    more
                }
            };
        }
        let (before, digits) = found?;
        Some(Self { before, after: text + rest, width: digits.parse().unwrap_or(0).min(32) })
    }
}

/// `path` with the number in its place; unchanged where there is none.
pub(super) fn numbered(path: &Path, number: u64) -> PathBuf {
    match Pattern::of(path) {
        Some(Pattern { before, after, width }) => PathBuf::from(format!("{before}{number:0width$}{after}")),
        None => path.to_path_buf(),
    }
}

/// The number that turns `path` into `file`, if there is one.
pub(super) fn number_in(path: &Path, file: &Path) -> Option<u64> {
    let Pattern { before, after, .. } = Pattern::of(path)?;
    let digits = file.to_str()?.strip_prefix(&before)?.strip_suffix(&after)?;
    digits.parse().ok().filter(|number| numbered(path, *number) == file)
}

/// Returns an error for a name without a place for the number when there are several pictures.
pub(super) fn check_pattern(path: &Path) -> Result<()> {
    if Pattern::of(path).is_some() || path == Path::new("-") {
        return Ok(());
    }
    let name = path.display();
    if path.to_str().is_none() {
        let problem = format!("{name} is not UTF-8, so that several pictures cannot be numbered in it");
        return Err(Error::settings(problem, "use a name in UTF-8"));
    }
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
        assert_eq!(name("50%dense.png"), "50%dense.png");
        assert_eq!(name("50%dense.%03d.png"), "50%dense.007.png");
        assert_eq!(name("50%%dense.%d.png"), "50%dense.7.png");
        assert_eq!(name("a%2d%3dä%%%d%"), "a%2d%3dä%7%");
        assert_eq!(
            (name("plain.png"), name("100%%.png"), name("%")),
            ("plain.png".into(), "100%%.png".into(), "%".into())
        );
        assert_eq!(name("%99999999999999999999d"), "7");
        let number = |pattern: &str, file: &str| number_in(Path::new(pattern), Path::new(file));
        assert_eq!((number("a.%04d.png", "a.0007.png"), number("a.%04d.png", "a.7.png")), (Some(7), None));
        assert_eq!((number("a%d", "a+7"), number("a%d", "a"), number("a", "a")), (None, None, None));
        assert_eq!(number("%%d%d", "%d12"), Some(12));
        check_pattern(Path::new("x.png")).expect_err("no place");
        check_pattern(Path::new("x%%d.png")).expect_err("a percent sign");
        check_pattern(Path::new("50%dense.png")).expect_err("a word");
        check_pattern(Path::new("x%d.png")).expect("a place");
    }
}
