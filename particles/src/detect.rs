//! Detects the format of a scene file by its beginning and its name.

use super::foreign;
use super::format::Format;
use super::format::{Sign, ending};
use super::formats::scenes::{is_native, native};
use super::formats::table::signs::is_points;
use super::formats::xyz::{is_atoms, is_xyz};
use super::signs::content_lines;
use halfline_ground::quote::setting::{COLUMNS, FORMAT};
use std::path::Path;

#[cfg(test)]
mod tests;

/// A format, and the warning where the name or the content of the file says another.
pub(super) type Recognised = (Format, Option<String>);

/// The format of a file with this beginning and name, or the problem and its remedy. The name decides where the beginning can be of
/// its format: titles and comments may look like any other format. Else the structure of a format whose first line is a title does,
/// then a signature, which one format alone has, and then what else the content shows. Where it is not recognised, the name decides. A
/// format that is not supported is recognised by content that no supported format has.
pub(super) fn recognise(start: &[u8], name: &Path) -> Result<Recognised, (String, String)> {
    let text = String::from_utf8_lossy(start);
    let lines: Vec<&str> = text.lines().take(64).collect();
    let foreign = |foreign: &foreign::Foreign| {
        (format!("this is {}, which is not supported", foreign.what), foreign.mend.to_owned())
    };
    let named = of_name(name).map(|named| if is_cloud(named, &text) { Format::PTS } else { named });
    // Tinker's files have the extension of XYZ and a similar beginning.
    match (of_content(start, named), foreign::of_content(start, &lines)) {
        (None, Some(found)) if !is_native(&lines) => return Err(foreign(found)),
        (Some(format), Some(found)) if format == Format::XYZ && !is_atoms(&lines) => return Err(foreign(found)),
        (Some(format), _) => return Ok((format, named.and_then(|named| contradiction(format, named, &text)))),
        (None, _) => {}
    }
    if let Some(format) = named {
        return Ok((format, None));
    }
    if let Some(found) = foreign::of_name(name) {
        return Err(foreign(found));
    }
    if native(start) {
        return Ok((Format::NATIVE, None));
    }
    let names: Vec<_> = Format::ALL.iter().map(|format| format.name()).collect();
    // The number of points may be before them.
    let is_row =
        |row: &str| row.split([',', ';', '\t', ' ']).filter(|word| word.trim().parse::<f64>().is_ok()).count() >= 3;
    let table = content_lines(&lines).filter(|line| !line.starts_with("//")).take(2).any(is_row);
    let columns = format!("{COLUMNS} x=1,y=2,z=3");
    let table = if table {
        format!("name the columns of a table with {columns} (or {FORMAT} csv {columns}), or ")
    } else {
        String::new()
    };
    let mend = format!("{table}set it with {FORMAT}: {}", names.join(", "));
    Err(("the format cannot be detected from content or name".to_owned(), mend))
}

/// The warning about a file that is read as `format` and whose name says `named`, another one, or about content that may be of
/// another; else `None`.
fn contradiction(format: Format, named: Format, text: &str) -> Option<String> {
    let (read, other) = (format.name(), named.name());
    if format != named {
        return Some(format!(
            "the name of the file says {other}, but its content is {read} and read as such; {FORMAT} sets another"
        ));
    }
    (format.0.doubt)(&text.lines().collect::<Vec<_>>())
}

/// Whether a file with this beginning has a format that is recognised but not supported.
pub(super) fn is_foreign(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    foreign::of_content(start, &text.lines().take(64).collect::<Vec<_>>()).is_some()
}

/// Detects the format by the beginning of a file, which may have the format `named`.
fn of_content(start: &[u8], named: Option<Format>) -> Option<Format> {
    let found = |is_of: &dyn Fn(&Sign) -> bool| Format::ALL.into_iter().find(|format| format.0.signs.iter().any(is_of));
    if let Some(format) = found(&|sign| matches!(sign, Sign::Bytes(is_of) if is_of(start))) {
        return Some(format);
    }
    let text = String::from_utf8_lossy(start);
    let mut lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    // The last line may be cut.
    if lines.len() > 1 && !start.ends_with(b"\n") {
        lines.pop();
    }
    let is_native = || content_lines(&lines).next().is_some() && native(start);
    let by_name = |named: &Format| if *named == Format::NATIVE { is_native() } else { named.0.fits(&lines) };
    named
        .filter(by_name)
        .or_else(|| found(&|sign| matches!(sign, Sign::Structure(is_of) if is_of(&lines))))
        .or_else(|| found(&|sign| matches!(sign, Sign::Signature(is_of) if is_of(&lines))))
        .or_else(|| found(&|sign| matches!(sign, Sign::Lines(is_of) if is_of(&lines))))
}

/// Whether a file that is called XYZ has points in place of atoms.
fn is_cloud(named: Format, text: &str) -> bool {
    let lines: Vec<&str> = text.lines().take(64).collect();
    // The last line may be cut.
    let whole = if lines.len() > 1 { &lines[..lines.len() - 1] } else { &lines };
    named == Format::XYZ && !is_xyz(whole) && is_points(whole)
}

/// Detects the format by a file name without the extension of its compression.
pub fn of_name(path: &Path) -> Option<Format> {
    let ending = ending(path);
    let known = Format::ALL.into_iter().find(|format| format.endings().any(|known| known == ending));
    // VASP gives its files these names, without an extension.
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_uppercase();
    known.or_else(|| ["POSCAR", "CONTCAR"].iter().any(|vasp| name.starts_with(vasp)).then_some(Format::POSCAR))
}
