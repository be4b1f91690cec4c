//! Colour maps of files: JSON of ParaView and of matplotlib's colours, or a table with a colour in each row.

use halfline::error::{Error, Place, Result};
use halfline::frame::color_map::ColorMap;
use halfline::quote::quote;
use halfline_particles::color::hex;
use halfline_particles::input::without_mark;
use halfline_particles::lines::not_utf8;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The most bytes of such a file.
const MOST_BYTES: u64 = 1 << 20;

/// Colours of a map whose positions are not at equal steps.
const STEPS: u32 = 255;

const MEND: &str = "give a colour in each row: three numbers from 0 to 1 or from 0 to 255, or #rrggbb; or JSON with a list of \
                    them, or with ParaView's RGBPoints";

/// The colour map of this name, or of the file of this name. A name with a dot or a slash names a file.
///
/// # Errors
/// [`Error::Settings`] for an unknown name, [`Error::Scene`] for a file that has no colours, [`Error::Io`].
pub fn color_map(name: &str) -> Result<ColorMap> {
    if !name.contains(['.', '/', '\\']) {
        return name.parse();
    }
    let (file, is_reversed) = match name.strip_suffix("_r") {
        Some(file) if !Path::new(name).exists() => (Path::new(file), true),
        _ => (Path::new(name), false),
    };
    let about = fs::metadata(file).map_err(|error| Error::read(file, error))?;
    let place = || Place::file(file.display().to_string());
    if !about.is_file() {
        return Err(Error::scene(place(), "a colour map is read from a file alone", MEND));
    }
    let size = about.len();
    if size > MOST_BYTES {
        return Err(Error::scene(place(), format!("{size} bytes are too many for a colour map"), MEND));
    }
    let bytes = fs::read(file).map_err(|error| Error::read(file, error))?;
    let text = String::from_utf8(without_mark(&bytes, &place())?.to_vec()).map_err(|e| not_utf8(place(), 0, e))?;
    let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let colors = match text.trim_start().starts_with(['[', '{']) {
        true => of_json(&text).map_err(|problem| Error::scene(place(), problem, MEND))?,
        false => of_rows(&text).map_err(|(line, problem)| Error::scene(place().at(line, 1), problem, MEND))?,
    };
    let map = ColorMap::of_colors(&stem, colors)?;
    if is_reversed { map.reversed() } else { Ok(map) }
}

/// A colour as a file has it.
enum FileColor {
    /// As `#rrggbb`.
    Bytes([u8; 3]),
    /// Three numbers.
    Numbers([f64; 3]),
}

impl FileColor {
    /// The colour of three numbers, or of four with an alpha that is left out.
    fn of_numbers(numbers: Option<Vec<f64>>) -> Option<Self> {
        match numbers.as_deref()? {
            [red, green, blue] | [red, green, blue, _] => Some(Self::Numbers([*red, *green, *blue])),
            _ => None,
        }
    }

    /// The colour of `#rrggbb`.
    fn of_text(text: &str) -> Option<Self> {
        let [_, rgb @ ..] = hex(text.trim_matches('"').strip_prefix('#')?)?.to_be_bytes();
        Some(Self::Bytes(rgb))
    }
}

/// The colours of a file, whose numbers count from 0 to 1 where all are at most 1; `None` for a number beyond 0 and 255.
fn colors(rows: &[FileColor]) -> Option<Vec<[u8; 3]>> {
    let numbers =
        || rows.iter().filter_map(|row| if let FileColor::Numbers(row) = row { Some(row) } else { None }).flatten();
    let scale = if numbers().all(|x| *x <= 1.0) { 255.0 } else { 1.0 };
    let color = |row: &FileColor| match row {
        FileColor::Bytes(row) => *row,
        FileColor::Numbers(row) => row.map(|x| (x * scale).round() as u8),
    };
    numbers().all(|x| (0.0..=255.0).contains(x)).then(|| rows.iter().map(color).collect())
}

/// The numbers of a list of JSON.
fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

/// The colours of a table: three numbers in each row, or four with an alpha that is left out. A first row without numbers is a
/// header.
fn of_rows(text: &str) -> std::result::Result<Vec<[u8; 3]>, (u64, String)> {
    let mut rows = Vec::new();
    let mut first = true;
    for (line, text) in (1..).zip(text.lines()) {
        let text = text.trim();
        if text.is_empty() || text.starts_with("//") || text.starts_with('#') && FileColor::of_text(text).is_none() {
            continue;
        }
        let words = text.split([',', ';', ' ', '\t']).filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
        match FileColor::of_numbers(numbers).or_else(|| FileColor::of_text(text)) {
            Some(row) => rows.push(row),
            None if first => {}
            None => return Err((line, format!("{} is not a colour", quote(text)))),
        }
        first = false;
    }
    colors(&rows).ok_or_else(|| (1, "a number is not between 0 and 255".to_owned()))
}

/// The colours of JSON: a list of lists of numbers or of `#rrggbb`, or ParaView's `RGBPoints`.
fn of_json(text: &str) -> std::result::Result<Vec<[u8; 3]>, String> {
    let value: Value = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let outer = value.get(0).filter(|first| first.is_object()).unwrap_or(&value);
    if let Some(points) = outer.get("RGBPoints") {
        return numbers(points).as_deref().and_then(of_points).ok_or_else(|| {
            "RGBPoints is not a list of positions that grow, each with three numbers from 0 to 1".to_owned()
        });
    }
    let list = outer.get("colors").unwrap_or(outer).as_array().ok_or("there is no list of colours")?;
    let row = |(n, value): (usize, &Value)| {
        let color = FileColor::of_numbers(numbers(value)).or_else(|| value.as_str().and_then(FileColor::of_text));
        color.ok_or_else(|| format!("item {n} of the list is not a colour"))
    };
    let rows: Vec<FileColor> = list.iter().enumerate().map(row).collect::<std::result::Result<_, _>>()?;
    colors(&rows).ok_or_else(|| "a number is not between 0 and 255".to_owned())
}

/// The colours at equal steps of points, each a position and three numbers from 0 to 1.
fn of_points(numbers: &[f64]) -> Option<Vec<[u8; 3]>> {
    let (points, rest) = numbers.as_chunks::<4>();
    let is_right = rest.is_empty()
        && points.len() > 1
        && points.iter().all(|[x, rgb @ ..]| x.is_finite() && rgb.iter().all(|c| (0.0..=1.0).contains(c)))
        && points.is_sorted_by(|a, b| a[0] <= b[0]);
    let (low, high) = (points.first()?[0], points.last()?[0]);
    if !is_right || high.partial_cmp(&low) != Some(std::cmp::Ordering::Greater) {
        return None;
    }
    let at = |n: u32| {
        let x = low + (high - low) * (f64::from(n) / f64::from(STEPS));
        let next = points.partition_point(|point| point[0] <= x).clamp(1, points.len() - 1);
        let ([from, a @ ..], [to, b @ ..]) = (points[next - 1], points[next]);
        let part = if to > from { ((x - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        [0, 1, 2].map(|k: usize| (255.0 * (a[k] * (1.0 - part) + b[k] * part)).round() as u8)
    };
    Some((0..=STEPS).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, text: &str) -> std::result::Result<ColorMap, String> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join(name);
        fs::write(&path, text).expect("a file");
        color_map(&path.display().to_string()).map_err(|error| error.to_string())
    }

    #[test]
    fn maps_of_files_have_their_colours() {
        let ends = [[255, 0, 0], [128, 128, 128], [0, 0, 255]];
        for (name, text) in [
            ("a.csv", "r,g,b\n255,0,0\n128,128,128\n0,0,255\n"),
            ("a.txt", "# mine\n1 0 0\n0.502 0.502 0.502\n\n0 0 1\n"),
            ("a.csv", "1.0;0;0;1\n0.502;0.502;0.502;1\n0;0;1;1"),
            ("a.txt", "#ff0000\n#808080\n#0000ff\n"),
            ("a.json", "[[1, 0, 0], [0.502, 0.502, 0.502, 1], [0, 0, 1]]"),
            ("a.json", "{\"colors\": [\"#ff0000\", \"#808080\", \"#0000ff\"]}"),
            ("a.json", "[{\"Name\": \"x\", \"RGBPoints\": [-2, 1, 0, 0, 3, 0.502, 0.502, 0.502, 8, 0, 0, 1]}]"),
        ] {
            let map = of(name, text).expect(text);
            let found = [0.0, 0.5, 1.0].map(|x| map.srgb(x));
            // Points become 256 steps, with no step in the middle.
            let is_near = found.iter().flatten().zip(ends.iter().flatten()).all(|(a, b)| a.abs_diff(*b) <= 1);
            assert!(map.name() == "a" && is_near, "{text}: {found:?}");
        }
        let uneven = of("a.json", "{\"RGBPoints\": [0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1, 4, 1, 1, 1]}").expect("a step");
        assert_eq!([0.2, 0.3, 0.9].map(|x| uneven.srgb(x)[0]), [0, 255, 255]);
    }

    #[test]
    fn dark_bytes_are_no_shares() {
        let map = of("a.txt", "#000000\n#010101\n").expect("two colours");
        assert_eq!(map.srgb(1.0), [1; 3]);
        assert!(color_map("./").map(drop).expect_err("a folder").to_string().contains("from a file alone"));
    }

    #[test]
    fn damaged_files_are_maps_or_errors() {
        for text in [
            "r,g,b\n255,0,0\n128,128,128\n0,0,255\n",
            "#ff0000\n#808080\n",
            "[[1, 0, 0], [0.502, 0.502, 0.502, 1]]",
            "{\"RGBPoints\": [-2, 1, 0, 0, 3, 0.5, 0.5, 0.5, 8, 0, 0, 1]}",
        ] {
            let mut cases: Vec<String> = (0..text.len()).map(|at| text[..at].to_owned()).collect();
            for at in 0..text.len() {
                for other in ["", "-", "9e999", "nan", "#", "\"", "[", "{", ",", "\u{e9}", "0"] {
                    cases.push(format!("{}{other}{}", &text[..at], &text[at + 1..]));
                }
            }
            for case in &cases {
                let found = [of_rows(case).ok(), of_json(case).ok()];
                for colors in found.into_iter().flatten() {
                    let map = ColorMap::of_colors("a", colors);
                    assert!(map.is_err() || map.is_ok_and(|map| map.srgb(0.5) == map.srgb(0.5)), "{case}");
                }
            }
        }
    }

    #[test]
    fn files_without_colours_are_refused_by_their_line() {
        for (name, text, message) in [
            ("a.csv", "1,0,0\n1,x,0\n", "a.csv:2:1: `1,x,0` is not a colour"),
            ("a.csv", "1,0,0\n300,0,0\n", "not between 0 and 255"),
            ("a.csv", "1,0,0\n", "has 1 colour"),
            ("a.csv", "", "has 0 colours"),
            ("a.json", "[[1, 0, 0], 7]", "item 1 of the list"),
            ("a.json", "[", "EOF"),
            ("a.json", "{\"RGBPoints\": [0, 1, 0, 0, 0, 1, 1, 1]}", "positions that grow"),
            ("a.json", "{\"RGBPoints\": [0, 1, 0]}", "positions that grow"),
            ("a.json", "{}", "no list of colours"),
        ] {
            let error = of(name, text).map(drop).expect_err(text);
            assert!(error.contains(message), "{text}: {error}");
        }
        assert!(color_map("no/such.csv").map(drop).expect_err("none").to_string().contains("no/such.csv"));
        color_map("viridi").expect_err("an unknown name");
    }
}
