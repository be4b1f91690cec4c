//! The header of a polygon file: its elements and their properties.

use crate::input::Input;
use crate::lines::Lines;
use crate::npy::header::Scalar;
use crate::particles::meaning::{FieldKind, NamedField};
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::quote::quote;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PlyEncoding {
    Text,
    Binary { big: bool },
}

pub(super) struct PlyElement {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

pub(super) struct Property {
    pub(super) name: String,
    /// The type of a list's length.
    pub(super) length: Option<Scalar>,
    pub(super) scalar: Scalar,
}

/// The most properties, and the most bytes of a header.
const MOST: usize = 4096;
const LONGEST: usize = 1 << 20;

/// The header, up to its end.
pub(super) fn header(lines: &mut Lines<Input>) -> Result<(PlyEncoding, Vec<PlyElement>)> {
    let (mut form, mut elements) = (None, Vec::<PlyElement>::new());
    let (mut properties, mut bytes) = (0, 0);
    if !lines.advance()? || lines.text().trim() != "ply" {
        return Err(lines.fail(0, "header", "this is not a polygon file", "begin with the line ply"));
    }
    loop {
        if !lines.advance()? {
            let problem = "the file ends within its header";
            return Err(lines.fail(0, "header", problem, "end the header with end_header"));
        }
        bytes += lines.text().len() + 1;
        if bytes > LONGEST {
            let problem = format!("the header has more than {LONGEST} bytes");
            return Err(lines.fail(0, "header", problem, "end the header with end_header"));
        }
        let wrong = |what: &str| {
            let problem = format!("{} {what}", quote(lines.text()));
            lines.fail(0, "header", problem, "write it as in the description of the format")
        };
        let words: Vec<&str> = lines.text().split_whitespace().take(8).collect();
        let scalar = |name: &str| {
            let big = form == Some(PlyEncoding::Binary { big: true });
            Scalar::of_ply(name, big).ok_or_else(|| wrong("has an unknown type"))
        };
        match words[..] {
            ["format", "ascii", _] => form = Some(PlyEncoding::Text),
            ["format", "binary_little_endian", _] => form = Some(PlyEncoding::Binary { big: false }),
            ["format", "binary_big_endian", _] => form = Some(PlyEncoding::Binary { big: true }),
            ["comment" | "obj_info", ..] | [] => {}
            ["element", name, count] if elements.len() < MOST => {
                let count = count.parse().map_err(|_| wrong("needs a whole number of elements"))?;
                if elements.iter().any(|element| element.name == name) {
                    return Err(wrong("occurs twice"));
                }
                elements.push(PlyElement { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref kind @ .., name] if properties < MOST && form.is_some() => {
                let Some(element) = elements.last_mut() else { return Err(wrong("belongs to no element")) };
                let (length, scalar) = match kind {
                    ["list", length, item] => (Some(scalar(length)?).filter(|length| length.is_whole()), scalar(item)?),
                    [kind] => (None, scalar(kind)?),
                    _ => return Err(wrong("is not a property")),
                };
                if length.is_none() && kind.len() == 3 {
                    return Err(wrong("has a length type that is not an integer type"));
                }
                element.properties.push(Property { name: name.to_owned(), length, scalar });
                properties += 1;
            }
            ["end_header"] => break,
            _ => return Err(wrong("is not a header line")),
        }
    }
    match form {
        Some(form) => Ok((form, elements)),
        None => Err(lines.fail(0, "header", "the format line is missing", "add the line `format ascii 1.0`")),
    }
}

/// The warning about a skipped element with fewer entries than declared.
pub(super) fn short_of(file: Place, found: u64, element: &PlyElement) -> String {
    let name = quote(&element.name);
    format!(
        "{file}: the file ends after {found} of {} elements {name}; its number of vertices may be wrong",
        element.count
    )
}

impl Property {
    /// Its name and numbers.
    pub(super) fn field(&self) -> NamedField<'_> {
        let kind = match self.length {
            None => FieldKind::Binary(self.scalar),
            Some(_) => FieldKind::Other("list".into()),
        };
        NamedField { name: &self.name, count: 1, kind }
    }
}

pub(super) fn truncated(file: Place, read: u64, element: &PlyElement) -> Error {
    let problem = format!("the file ends after {read} of {} vertices", element.count);
    Error::scene(file.named("vertex"), problem, "give as many vertices as the header says")
}
