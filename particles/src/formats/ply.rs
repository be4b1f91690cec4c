//! Points of a Stanford polygon file: the vertices, in text or in binary of either byte order. Faces and other elements
//! are skipped. The header is described in Greg Turk's "The PLY Polygon File Format" (1994). The crate ply-rs-bw (4.0.1)
//! keeps whole elements and has no limit: 200 bytes with a damaged count make it run out of memory.

mod binary;
mod header;
mod splat;
mod text;
mod vertex;

use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::Lines;
use crate::particles::frame::Particles;
use crate::particles::layout::Layout;
use crate::particles::meaning::{NamedField, meanings};
use crate::particles::records::Record;
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::source::Source;
use binary::Binary;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::check_ids;
use halfline_ground::quote::unquoted;
use header::{PlyElement, PlyEncoding, Property, header};
use splat::Splat;
use std::io::BufReader;
use text::{pass, rest_of_text, text};
use vertex::VertexColumns;

pub(crate) const PLY: FormatRow = FormatRow {
    name: "ply",
    about: "points of a Stanford polygon file",
    signs: &[Sign::Signature(|lines| {
        lines.first().is_some_and(|line| line.split('\r').next().is_some_and(|line| line.trim_end() == "ply"))
    })],
    has: &[Has::Blocks, Has::AnyColumns],
    open: Open::Frame(read),
    ..FormatRow::PLAIN
};

/// Reads the vertices.
///
/// # Errors
/// [`Error::Scene`] with the place in the file, [`Error::Io`], [`Error::Limits`].
pub(crate) fn read(source: Source, request: &Request) -> Result<Particles> {
    let Source { mut reader, path, .. } = source;
    // Line ends of old Macintosh: a first byte of binary data may be a line feed, so the first line decides.
    let start = reader.look(5).map_err(|e| Error::read(&path, e))?;
    let ends_in_returns = start.starts_with(b"ply\r") && start.get(4) != Some(&b'\n');
    let lines = Lines::new(reader, &path);
    let mut lines = if ends_in_returns { lines.of_returns() } else { lines };
    let (form, elements) = header(&mut lines)?;
    let Some(place) = elements.iter().position(|element| element.name == "vertex") else {
        let mend = "use a file with points";
        return Err(lines.fail(0, "header", "the element vertex is missing", mend));
    };
    let columns = columns(&elements[place], &lines, request)?;
    let layout = &columns.layout;
    let mut particles = layout.begin();
    for other in elements.iter().filter(|element| element.name != "vertex" && element.count > 0) {
        let kind = match other.name.as_str() {
            "face" => "face",
            "edge" => "edge",
            _ => "other element",
        };
        particles.skipped.skip(kind, request.strict, || lines.file().named(unquoted(&other.name).to_string()))?;
        if let Some((_, count)) = particles.skipped.kinds.iter_mut().find(|(found, _)| *found == kind) {
            *count = count.saturating_add(other.count - 1);
        }
    }
    let (before, vertices, behind) = (&elements[..place], &elements[place], &elements[place + 1..]);
    check_ids(vertices.count)?;
    match form {
        PlyEncoding::Text => {
            for element in before {
                pass(&mut lines, element)?;
            }
            text(&mut lines, vertices, &columns, &mut particles)?;
            rest_of_text(&mut lines, vertices, behind, &mut particles)?;
        }
        PlyEncoding::Binary { .. } => {
            let mut binary = Binary { reader: BufReader::with_capacity(1 << 16, lines.into_reader()), path };
            for element in before {
                binary.pass(element)?;
            }
            binary.vertices(vertices, &columns, &mut particles)?;
            binary.rest(vertices, behind, &mut particles)?;
        }
    }
    particles.tell_left_out();
    Ok(particles)
}

/// The columns of these vertices.
fn columns(vertex: &PlyElement, lines: &Lines<Input>, request: &Request) -> Result<VertexColumns> {
    let wrong = |problem: String| {
        let mend = match vertex.properties.iter().any(|property| property.name == splat::PACKED) {
            true => "save them as PLY without compression, for example with SuperSplat or splat-transform",
            false => "give the vertices the properties x, y and z, each once",
        };
        Error::scene(lines.file().named("vertex"), problem, mend)
    };
    let fields: Vec<NamedField<'_>> = vertex.properties.iter().map(Property::field).collect();
    let meanings = meanings(&fields);
    let names: Vec<String> = meanings.fields.iter().flatten().map(|(name, _)| name.clone()).collect();
    let (mut layout, packed) = (Layout::new(request), meanings.packed);
    layout.add_fields(meanings).map_err(wrong)?;
    let splat = Splat::of(&names, &mut layout).map_err(wrong)?;
    let mut record = Record::default();
    for (k, property) in vertex.properties.iter().enumerate().filter(|(_, property)| property.length.is_none()) {
        match packed == Some(k) {
            true => record.add_color(property.scalar),
            false => record.add_numbers(1, property.scalar),
        }
    }
    match (0..3).find(|k| !layout.contains(Role::Position(*k))) {
        None => Ok(VertexColumns { layout, packed, record, splat }),
        Some(k) => Err(wrong(format!("a vertex has no {}", ["x", "y", "z"][k]))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: &str = "comment by hand\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 2\n\
        property float x\nproperty double y\nproperty short z\nproperty uchar red\nproperty uchar green\n\
        property uchar blue\nproperty list uchar float more\nproperty int t\nelement edge 7\nproperty int a\nend_header\n";

    fn header(format: &str) -> String {
        format!("ply\nformat {format} 1.0\n{BODY}")
    }

    fn binary(big: bool) -> Vec<u8> {
        let mut bytes = header(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes();
        let mut put = |little: &[u8]| {
            if big { bytes.extend(little.iter().rev()) } else { bytes.extend(little) }
        };
        put(&[3]);
        [0i32, 1, 1].iter().for_each(|i| put(&i.to_le_bytes()));
        for (x, z, red, more, t) in [(1.5f32, -2i16, 255, 0, 9), (3.0, 4, 0, 2, -9i32)] {
            put(&x.to_le_bytes());
            put(&0.1f64.to_le_bytes());
            put(&z.to_le_bytes());
            [red, 0, 128].iter().for_each(|c: &u8| put(&[*c]));
            put(&[more]);
            (0..more).for_each(|_| put(&7f32.to_le_bytes()));
            put(&t.to_le_bytes());
        }
        bytes
    }

    fn read_bytes(bytes: &[u8], strict: bool) -> Result<Particles> {
        super::read(Source::of_bytes(bytes), &Request { strict, ..Request::of(&["t"]) }).map(Particles::linearized)
    }

    #[test]
    fn the_three_encodings_hold_the_same_scene() {
        let text = header("ascii") + "3 0 1 1\n1.5 0.1 -2 255 0 128 0 9\n3 0.1 4 0 0 128 2 7 7 -9\n";
        for bytes in [text.into_bytes(), binary(false), binary(true)] {
            let found = read_bytes(&bytes, false).expect("points");
            assert_eq!(found.positions, [[1.5, 0.1, -2.0], [3.0, 0.1, 4.0]]);
            assert_eq!(found.columns[0].values, [9.0, -9.0]);
            // IEC 61966-2-1 of 128/255.
            assert!(found.colors[0][0] == 1.0 && (found.colors[1][2] - 0.2158605).abs() < 1e-6);
            assert_eq!(found.skipped.kinds, [("face", 1), ("edge", 7)]);
            assert!(
                read_bytes(&bytes, true).expect_err("strict").to_string().contains("expected a sphere, found a face")
            );
            let short = &bytes[..bytes.len() - 9];
            assert!(read_bytes(short, false).is_err(), "cut short");
        }
        let cut = read_bytes(&binary(false)[..binary(false).len() - 9], false).map(drop).expect_err("cut short");
        assert!(cut.to_string().contains("the file ends after 1 of 2 vertices"), "{cut}");
    }

    #[test]
    fn bytes_behind_the_vertices_are_checked() {
        let floats = |n: usize| (0..n).flat_map(|k| (k as f32).to_le_bytes());
        let file = |elements: &str, bytes: &[u8]| {
            let xyz = "property float x\nproperty float y\nproperty float z\n";
            let header = format!("ply\nformat binary_little_endian 1.0\nelement vertex 2\n{xyz}{elements}end_header\n");
            [header.as_bytes(), bytes].concat()
        };
        let two: Vec<u8> = floats(6).collect();
        assert!(read_bytes(&file("", &two), true).expect("two").skipped.assumed.is_empty());
        assert!(read_bytes(&file("", &[&two[..], b"\n"].concat()), true).expect("padding").skipped.assumed.is_empty());
        let four: Vec<u8> = floats(12).collect();
        let error = read_bytes(&file("", &four), true).map(drop).expect_err("four").to_string();
        assert!(
            error.contains("expected 2 vertices, but 24 bytes follow the last element, the size of 2 more"),
            "{error}"
        );
        // A third vertex is read from the first face, so the face is surplus.
        let faces = "element face 1\nproperty list uchar int vertex_indices\n";
        let face = [&[3][..], &[0; 12]].concat();
        let right = read_bytes(&file(faces, &[&two[..], &face].concat()), false).expect("a face");
        assert!(right.skipped.assumed.is_empty());
        let three: Vec<u8> = floats(9).chain(face).collect();
        let warnings = read_bytes(&file(faces, &three), false).expect("faces are left out").skipped.assumed;
        assert!(warnings.len() == 1 && warnings[0].contains("the number of vertices may be wrong"), "{warnings:?}");
        let warnings = read_bytes(&file(faces, &two), false).expect("faces are left out").skipped.assumed;
        assert!(warnings.len() == 1 && warnings[0].contains("after 0 of 1 elements `face`"), "{warnings:?}");
    }

    #[test]
    fn errors_are_reported() {
        let points = |properties: &str, rows: &str| {
            format!("ply\nformat ascii 1.0\nelement vertex 1\n{properties}end_header\n{rows}")
        };
        let xyz = "property float x\nproperty float y\nproperty float z\n";
        for (text, message) in [
            (points(xyz, "1 2\n"), ":8:4: z"),
            (points(xyz, "1 b 2\n"), ":8:3: y: `b`"),
            (points(xyz, "1 2 3\n4 5 6\n\n7 8 9\n"), ":9:1: count: expected 1 vertices, found 2"),
            (points(xyz, "3 0 1 2\n"), ":8:7: vertex: `2` is one number more than the 3 properties"),
            (points(xyz, "1 2 3\n").replace("vertex 1", "vertex 9999999999"), "more than 32-bit ids"),
            (points(&format!("{xyz}{}", "comment far too long\n".repeat(60_000)), ""), "more than 1048576 bytes"),
            (points(xyz, ""), "after 0 of 1 vertices"),
            (points("property float x\n", "1\n"), "no y"),
            (points("property half x\n", "1\n"), ":4:1: header"),
            (points(&format!("{xyz}property float x\n"), ""), "occurs twice"),
            (points(&format!("{xyz}property float radius\n"), "1 2 3 0\n"), ":9:7: radius"),
            (points(&format!("{xyz}property list float int i\n"), ""), "not an integer type"),
            ("ply\nformat ascii 1.0\nend_header\n".into(), "the element vertex is missing"),
            ("ply\nelement vertex 1\n".into(), "within its header"),
            ("ply\nwhat\n".into(), ":2:1: header: `what`"),
        ] {
            let error = super::read(Source::of_text(&text), &Request::of(&[])).map(drop).expect_err(&text).to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
