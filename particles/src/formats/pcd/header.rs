//! The header of a point cloud: its fields and the number of points.

use crate::input::Input;
use crate::lines::Lines;
use crate::npy::header::Scalar;
use crate::particles::layout::Layout;
use crate::particles::meaning::{FieldKind, NamedField, meanings};
use crate::particles::records::Record;
use crate::particles::request::Request;
use crate::particles::role::Role;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::check_ids;
use halfline_ground::quote::quote;

/// The encoding of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PcdEncoding {
    Ascii,
    Binary,
    Compressed,
}

/// A field of a point.
pub(super) struct PcdField {
    pub(super) scalar: Scalar,
    /// Numbers per point.
    pub(super) count: usize,
    pub(super) kind: PcdKind,
}

/// The content of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PcdKind {
    /// Bytes without meaning.
    Padding,
    /// A colour in one number, 0xRRGGBB, perhaps as the bits of a float.
    Color,
    Numbers,
}

/// The header.
pub(super) struct PcdHeader {
    pub(super) encoding: PcdEncoding,
    pub(super) fields: Vec<PcdField>,
    pub(super) points: u64,
    /// The columns; a colour has three.
    pub(super) layout: Layout,
    /// The fields of a point of a binary file.
    pub(super) record: Record,
}

impl PcdField {
    /// Bytes per point.
    pub(super) fn size(&self) -> usize {
        self.scalar.size() * self.count
    }
}

/// The most lines and fields, and the most numbers of a field.
const MOST_LINES: u64 = 1024;
const MOST: usize = 4096;

/// The lines that give a word for each field.
const LISTS: [&str; 4] = ["FIELDS", "SIZE", "TYPE", "COUNT"];

const MEND: &str = "write it as in the description of the format";

/// Reads the header, up to the line `DATA`.
pub(super) fn header(lines: &mut Lines<Input>, request: &Request) -> Result<PcdHeader> {
    let mut lists: [(Vec<String>, Place); 4] = Default::default();
    let mut sizes: [Option<u64>; 3] = [None; 3];
    for _ in 0..MOST_LINES {
        if !lines.advance()? {
            let problem = "the file ends within its header";
            return Err(lines.fail(0, "header", problem, "end the header with the line DATA"));
        }
        let mut words = lines.text().split_whitespace();
        let Some(key) = words.next().filter(|key| !key.starts_with('#')) else { continue };
        let fail = |problem: String| lines.fail(0, "header", problem, MEND);
        // Older files call the fields columns.
        let key = if key == "COLUMNS" { "FIELDS" } else { key };
        if let Some(list) = LISTS.iter().position(|name| *name == key) {
            let words: Vec<String> = words.take(MOST + 1).map(str::to_owned).collect();
            if words.len() > MOST {
                return Err(fail(format!("more than {MOST} fields")));
            }
            lists[list] = (words, lines.place(0).named(key));
        } else if let Some(size) = ["WIDTH", "HEIGHT", "POINTS"].iter().position(|name| *name == key) {
            let number = words.next().and_then(|word| word.parse().ok());
            sizes[size] = Some(number.ok_or_else(|| fail(format!("{} has no whole number", quote(lines.text()))))?);
        } else if key == "DATA" {
            let encoding = match words.next() {
                Some("ascii") => PcdEncoding::Ascii,
                Some("binary") => PcdEncoding::Binary,
                Some("binary_compressed") => PcdEncoding::Compressed,
                _ => {
                    let mend = "the encodings are ascii, binary and binary_compressed";
                    let problem = format!("{} has no known encoding", quote(lines.text()));
                    return Err(lines.fail(0, "header", problem, mend));
                }
            };
            let [width, height, points] = sizes;
            let product = || width?.checked_mul(height.unwrap_or(1));
            let points = points.or_else(product).ok_or_else(|| fail("the number of points is missing".into()))?;
            check_ids(points)?;
            let (fields, layout) = fields(&lists, &lines.file(), request)?;
            let mut record = Record::default();
            for field in &fields {
                match field.kind {
                    PcdKind::Padding => record.add_padding(field.size()),
                    PcdKind::Color => record.add_color(field.scalar),
                    PcdKind::Numbers => record.add_numbers(field.count, field.scalar),
                }
            }
            return Ok(PcdHeader { encoding, fields, points, layout, record });
        } else if !["VERSION", "VIEWPOINT"].contains(&key) {
            return Err(fail(format!("{} is not a header line", quote(lines.text()))));
        }
    }
    let problem = format!("the header has more than {MOST_LINES} lines");
    Err(lines.fail(0, "header", problem, "end the header with the line DATA"))
}

/// The fields and their columns.
fn fields(lists: &[(Vec<String>, Place); 4], file: &Place, request: &Request) -> Result<(Vec<PcdField>, Layout)> {
    let [(names, place), (sizes, _), (types, _), (counts, _)] = lists;
    let mut layout = Layout::whole(request);
    let mut fields = Vec::new();
    for (list, name) in lists.iter().zip(LISTS) {
        // Without the line COUNT each field has one number.
        if list.0.len() != names.len() && !(name == "COUNT" && list.0.is_empty()) {
            let problem = format!("{} fields have {} words after {name}", names.len(), list.0.len());
            let place = if list.1.line.is_some() { list.1.clone() } else { file.clone().named("header") };
            return Err(Error::scene(place, problem, "give a word for each field"));
        }
    }
    for (k, name) in names.iter().enumerate() {
        let scalar = Scalar::of_numpy(&format!("<{}{}", types[k].to_ascii_lowercase(), sizes[k])).ok_or_else(|| {
            let problem = format!("the type {} of size {}", quote(&types[k]), quote(&sizes[k]));
            Error::scene(place.clone().named(format!("TYPE of {name}")), problem, "the types are I, U and F")
        })?;
        let count = counts.get(k).map_or(Ok(1), |count| count.parse::<usize>());
        let count = count.ok().filter(|count| *count <= MOST).ok_or_else(|| {
            let mend = "use a number up to 4096";
            Error::scene(place.clone().named(format!("COUNT of {name}")), format!("{}", quote(&counts[k])), mend)
        })?;
        let kind = if name == "_" { PcdKind::Padding } else { PcdKind::Numbers };
        fields.push(PcdField { scalar, count, kind });
    }
    let named = |(k, field): (usize, &PcdField)| match field.kind {
        PcdKind::Padding => NamedField { name: "_", count: 0, kind: FieldKind::Other("padding".into()) },
        _ => NamedField { name: &names[k], count: field.count, kind: FieldKind::Binary(field.scalar) },
    };
    let meanings = meanings(&fields.iter().enumerate().map(named).collect::<Vec<_>>());
    if let Some(packed) = meanings.packed {
        fields[packed].kind = PcdKind::Color;
    }
    layout.add_fields(meanings).map_err(|problem| Error::scene(place.clone(), problem, MEND))?;
    match (0..3).find(|axis| !layout.contains(Role::Position(*axis))) {
        None => Ok((fields, layout)),
        Some(axis) => {
            let problem = format!("a point has no {}", ["x", "y", "z"][axis]);
            Err(Error::scene(file.clone().named("FIELDS"), problem, "give the points the fields x, y and z"))
        }
    }
}
