//! Texts: their content, and what is said of those that cannot be read.

use halfline_ground::error::{Error, Place, Result};

/// The most lines in a row that are blank or comments, so that a file without content is not read for minutes.
pub(super) const IDLE: u64 = 1 << 20;

/// Whether a line is neither blank nor a comment.
pub fn has_content(line: &str) -> bool {
    let text = line.trim_start();
    !text.is_empty() && comment(text) == 0
}

/// The length of the mark of a comment at the beginning of a text: `#`, or `//` as CloudCompare writes it.
pub fn comment(text: &str) -> usize {
    let mark = if text.starts_with("//") { '/' } else { '#' };
    text.len() - text.trim_start_matches(mark).len()
}

/// The remedy for a text that is not a finite number: the number respelled where the text has a Fortran exponent or a
/// decimal comma, else `otherwise`.
pub fn mend_number(text: &str, otherwise: &str) -> String {
    let spelled = |spelling: String| Some(spelling).filter(|text| text.parse::<f64>().is_ok_and(f64::is_finite));
    if let Some(number) = spelled(text.replace(['D', 'd'], "E")).filter(|_| text.parse::<f64>().is_err()) {
        return format!("write the exponent with E, as in {number}");
    }
    if let Some(number) = spelled(text.replacen(',', ".", 1)).filter(|_| text.parse::<f64>().is_err()) {
        return format!("write decimals with a point, as in {number}");
    }
    otherwise.to_owned()
}

pub(super) fn too_idle(place: &Place) -> Error {
    let problem = format!("{place}: {IDLE} lines before it are blank or comments");
    Error::Limits { problem, mend: "remove them, and check that it is a scene or particle file".into() }
}

/// Refuses a text with as many lines in a row that are blank or comments as `Lines` refuses.
pub fn check_idle(text: &str, file: &Place) -> Result<()> {
    let mut idle = 0;
    for (line, number) in text.lines().zip(1..) {
        idle = if has_content(line) { 0 } else { idle + 1 };
        if idle > IDLE {
            return Err(too_idle(&file.clone().at(number, 1)));
        }
    }
    Ok(())
}

/// The error for text after `lines` whole lines that is not UTF-8.
pub fn not_utf8(file: Place, lines: u64, error: std::string::FromUtf8Error) -> Error {
    let valid = error.utf8_error().valid_up_to();
    let bytes = error.as_bytes();
    let before = String::from_utf8_lossy(&bytes[..valid]);
    let mut place = file.at_byte(&before, before.len());
    place.line = place.line.map(|line| lines + line);
    let byte = bytes.get(valid).copied().unwrap_or_default();
    Error::scene(place, not_utf8_text(byte), UTF8)
}

pub(super) fn not_utf8_text(byte: u8) -> String {
    format!("the byte 0x{byte:02x} is not UTF-8 text")
}

pub(super) const UTF8: &str = "save the file as UTF-8";
