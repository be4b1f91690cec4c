//! XYZ and extended XYZ: a count, a comment, and a line for every atom; frame after frame. The comment of extended XYZ
//! declares the columns (`Properties=species:S:1:pos:R:3:forces:R:3`) and the cell (`Lattice="..."`, and `Origin="..."` of OVITO for the
//! corner that it begins at); described at github.com/libAtoms/extxyz and docs.ovito.org/reference/file_formats/input/xyz.html.

use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::{Lines, Words};
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::frame_time::FrameTime;
use crate::particles::layout::Layout;
use crate::particles::meaning::{FieldKind, NamedField, meanings};
use crate::particles::periodic::images::open_edges;
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::particles::rows::{rows, surplus};
use crate::particles::vectors::component;
use crate::signs::numbers;
use crate::source::Source;
use halfline_ground::Cell;
use halfline_ground::error::Result;
use halfline_ground::quote::quote;
use halfline_ground::quote::setting::{COLUMNS, FORMAT};

pub(crate) const XYZ: FormatRow = FormatRow {
    name: "xyz",
    about: "XYZ and extended XYZ",
    endings: &["extxyz"],
    signs: &[Sign::Lines(is_xyz)],
    has: &[Has::Molecules, Has::Blocks, Has::AnyColumns, Has::Ids],
    open: Open::Frames(|source, request, _| Ok(Box::new(Xyz::new(source, request)))),
    ..FormatRow::PLAIN
};

/// The reader.
pub(crate) struct Xyz {
    lines: Lines<Input>,
    request: Request,
}

impl Xyz {
    pub(crate) fn new(source: Source, request: Request) -> Self {
        Self { lines: Lines::new(source.reader, &source.path), request }
    }

    /// The number of atoms of the next frame; `None` at the end of the file.
    fn count(&mut self) -> Result<Option<u64>> {
        loop {
            if !self.lines.advance()? {
                return Ok(None);
            }
            let text = self.lines.text().trim();
            if !text.is_empty() {
                return self.lines.count("count", mend_count(text)).map(Some);
            }
        }
    }

    /// Checks that no more atoms follow than `count`; then the first line of the next frame, if there is one, is the
    /// current one.
    fn check_end(&mut self, count: u64, layout: &Layout, particles: &mut Particles) -> Result<()> {
        loop {
            if !self.lines.advance()? {
                return Ok(());
            }
            if !self.lines.text().trim().is_empty() {
                break;
            }
        }
        let is_row = |lines: &Lines<Input>| layout.fits(Words::of(lines), lines);
        if is_row(&self.lines) {
            return surplus(&mut self.lines, count, "atoms", is_row);
        }
        self.lines.give_back();
        let text = self.lines.text().trim();
        if text.parse::<u64>().is_err() {
            let [place, text] = [self.lines.place(0).to_string(), quote(text).to_string()];
            particles.skipped.assumed.push(format!("{place}: {text} after the {count} atoms does not begin a frame"));
        }
        Ok(())
    }

    /// The columns and the frame without atoms of the comment line: its cell and its time.
    fn layout(&self) -> Result<(Layout, Particles)> {
        let (mut at, mut properties, mut cell) = (0, "species:S:1:pos:R:3", None);
        let (mut time, mut step, mut open, mut origin) = (None, None, [false; 3], [0.0; 3]);
        for (place, key, value) in pairs(self.lines.text()) {
            match &key.to_ascii_lowercase()[..] {
                "properties" => (at, properties) = (place, value),
                "time" => time = value.trim().parse().ok(),
                "step" => step = value.trim().parse().ok(),
                "lattice" => cell = Some(self.vectors(place, "Lattice", value)?),
                // Others write where their data are from.
                "origin" if words(value).any(|word| word.parse::<f64>().is_ok()) => {
                    [origin] = self.vectors(place, "Origin", value)?;
                }
                "pbc" => open = open_edges(words(value)),
                _ => {}
            }
        }
        let wrong = |problem: String| {
            self.lines.fail(at, "Properties", problem, "write name:type:columns triples such as species:S:1:pos:R:3")
        };
        let (mut parts, mut all) = (properties.split(':'), 0);
        let mut declared = Vec::new();
        while let Some(name) = parts.next() {
            let (Some(kind @ ("S" | "R" | "I" | "L")), Some(count)) = (parts.next(), parts.next()) else {
                return Err(wrong(format!("{} needs a type S, R, I or L and a number of columns", quote(name))));
            };
            let count: usize =
                count.parse().map_err(|_| wrong(format!("{} is not a number of columns", quote(count))))?;
            all += count.min(MOST + 1);
            if all > MOST {
                return Err(wrong(format!("more than {MOST} columns")));
            }
            let written = match kind {
                "R" | "I" => FieldKind::Text,
                _ => FieldKind::Other("text".into()),
            };
            declared.push((NamedField { name, count, kind: written }, kind));
        }
        let (fields, kinds): (Vec<NamedField<'_>>, Vec<&str>) = declared.into_iter().unzip();
        let mut meanings = meanings(&fields);
        for ((field, kind), columns) in fields.iter().zip(kinds).zip(&mut meanings.fields) {
            atoms(field, kind, columns);
        }
        let mut layout = Layout::new(&self.request);
        layout.add_fields(meanings).map_err(wrong)?;
        if !(0..3).all(|axis| layout.contains(Role::Position(axis))) {
            return Err(wrong("the property pos with three columns is missing".into()));
        }
        let cell = cell.map(|edges| Cell { origin, edges });
        let frame = Particles { cell, open_edges: open, when: FrameTime::of(time, step), ..layout.begin() };
        Ok((layout, frame))
    }

    /// The vectors of a value.
    fn vectors<const N: usize>(&self, at: usize, key: &str, text: &str) -> Result<[[f64; 3]; N]> {
        let numbers: Vec<f64> = words(text).take(3 * N + 1).map_while(|word| word.parse().ok()).collect();
        let (vectors, rest) = numbers.as_chunks::<3>();
        match <[[f64; 3]; N]>::try_from(vectors) {
            Ok(vectors) if rest.is_empty() && numbers.iter().all(|x| x.is_finite()) => Ok(vectors),
            _ => {
                let problem = format!("{} is not {}", quote(text), if N == 1 { "a place" } else { "a cell" });
                let mend = if N == 1 {
                    "use three finite numbers"
                } else {
                    "use three vectors of finite numbers, nine in all"
                };
                Err(self.lines.fail(at, key, problem, mend))
            }
        }
    }
}

/// The words of an array: ASE writes blanks between them, others commas, brackets as in JSON, or both.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || ",[]".contains(c)).filter(|word| !word.is_empty())
}

/// The remedy for a file that ends within a frame.
const MEND: &str = "give as many lines as the count says";

/// The most columns of all properties.
const MOST: usize = 4096;

/// Corrects the columns of a property that names elements or has text.
fn atoms(field: &NamedField<'_>, kind: &str, columns: &mut Vec<(String, Role)>) {
    let name = field.name.to_lowercase();
    let role = match (&name[..], kind, field.count) {
        ("species" | "element" | "symbol", "S", 1) => Role::Symbol,
        // Beside `x` and `y` it is the coordinate.
        ("z", "I" | "R", 1) if matches!(columns[..], [(_, Role::Position(_))]) => return,
        ("z" | "numbers" | "atomic_numbers", "I" | "R", 1) => Role::Number,
        (_, "S" | "L", _) => Role::Text,
        _ => return,
    };
    // The coordinate has the name `z`.
    let name = if role == Role::Number && name == "z" { "atomic_number" } else { field.name };
    let named = |k: usize| if field.count == 1 { name.to_owned() } else { component(name, k) };
    *columns = (0..field.count).map(|k| (named(k), role)).collect();
}

/// The remedy for a line that is no number of atoms. Points without a count can be read as a table.
fn mend_count(line: &str) -> String {
    let words = line.split(|c: char| c.is_whitespace() || ",;".contains(c)).filter(|word| !word.is_empty());
    match words.map(|word| word.parse::<f64>().is_ok()).collect::<Vec<_>>()[..] {
        [true, true, true] | [true, true, true, true] => format!("points without a count are read with {FORMAT} pts"),
        [true, true, true, ..] => format!("points without a count are a table: use {FORMAT} csv {COLUMNS} x=1,y=2,z=3"),
        [false, true, true, true, ..] => format!(
            "begin each frame with its number of atoms and a comment, or use {FORMAT} csv {COLUMNS} element=1,x=2,y=3,z=4"
        ),
        _ => "begin each frame with its number of atoms".to_owned(),
    }
}

/// The `key=value` pairs of a comment, with values optionally in quotes or brackets, each with the byte at which its
/// value begins.
fn pairs(text: &str) -> Vec<(usize, &str, &str)> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(equals) = text[at..].find('=').map(|k| at + k) {
        let key = text[at..equals].trim_end().rsplit(char::is_whitespace).next().unwrap_or_default();
        let value = equals + 1 + (text[equals + 1..].len() - text[equals + 1..].trim_start().len());
        let (close, open) = match text[value..].chars().next() {
            Some('"') => ('"', 1),
            Some('\'') => ('\'', 1),
            Some('{') => ('}', 1),
            Some('[') => (']', 1),
            _ => (' ', 0),
        };
        let start = value + open;
        // Arrays may be nested.
        let mut depth = 1;
        let ends = |c: char| match close {
            ' ' => c.is_whitespace(),
            ']' => {
                depth += i32::from(c == '[') - i32::from(c == ']');
                depth == 0
            }
            _ => c == close,
        };
        let end = text[start..].find(ends).map_or(text.len(), |k| start + k);
        found.push((start, key.trim_matches('"'), &text[start..end]));
        at = (end + open).min(text.len());
    }
    found
}

impl ParticleFrames for Xyz {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(count) = self.count()? else { return Ok(None) };
        self.lines.need("comment", MEND)?;
        let (layout, mut particles) = self.layout()?;
        let row = |line: &Lines<&[u8]>, found: &mut _| layout.row(&mut Words::of(line), line, found);
        if rows(&mut self.lines, count, &layout, &mut particles, row)? < count {
            return Err(self.lines.cut("atom", MEND));
        }
        self.check_end(count, &layout, &mut particles)?;
        particles.settle_texts()?;
        Ok(Some(particles))
    }

    fn skip(&mut self) -> Result<bool> {
        let Some(count) = self.count()? else { return Ok(false) };
        self.lines.need("comment", MEND)?;
        let columns = self.layout().map_or(0, |(layout, ..)| layout.len());
        if !self.lines.pass_rows(count, columns)? { Err(self.lines.cut("atom", MEND)) } else { Ok(true) }
    }
}

/// A count, a comment, and lines of a word or a number and three numbers. Points behind their number, as scanners write them,
/// have no comment.
pub(crate) fn is_xyz(lines: &[&str]) -> bool {
    let Some(count) = lines.first().and_then(|line| line.trim().parse::<u64>().ok()) else { return false };
    let width = |line: &str| Some(numbers(line)).filter(|n| *n >= 3 && *n == line.split_whitespace().count());
    let is_whole = |row: &str| row.split_whitespace().next().is_some_and(|word| word.parse::<u32>().is_ok());
    // The comment has as many numbers as a row that begins with a coordinate.
    let mut rows = lines.iter().skip(2).take(usize::try_from(count).unwrap_or(usize::MAX).saturating_sub(1));
    let comment = lines.get(1).and_then(|line| width(line));
    if comment.is_some() && rows.any(|row| width(row) == comment && !is_whole(row)) {
        return false;
    }
    match lines.get(2) {
        None => count == 0,
        Some(atom) => atom.split_whitespace().count() >= 4 || lines[1].contains("Properties="),
    }
}

/// The same with the words of extended XYZ, or with three numbers behind the first word of each atom: no other format.
pub(crate) fn is_atoms(lines: &[&str]) -> bool {
    let count = lines.first().and_then(|line| line.trim().parse::<usize>().ok()).unwrap_or(0);
    let comment = lines.get(1).map(|line| line.to_ascii_lowercase()).unwrap_or_default();
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    let is_atom = |line: &&str| line.split_whitespace().skip(1).take(3).filter(|word| is_number(word)).count() == 3;
    // The last line may be cut.
    let rows = lines.len().saturating_sub(3).max(1).min(count);
    comment.contains("properties=") || comment.contains("lattice=") || lines.iter().skip(2).take(rows).all(is_atom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::frame::Column;
    use crate::particles::frame::all;

    fn read(text: &str, columns: &[&str]) -> Result<Vec<Particles>> {
        all(Xyz::new(Source::of_text(text), Request::of(columns)))
    }

    #[test]
    fn frames_follow_each_other() {
        let frames = read("2\nwater\nO 0 0 0\nH1 1 0 -1e-1\n\n1\n\n26 5 6 7 extra\n", &[]).expect("frames");
        assert_eq!(frames.len(), 2);
        assert_eq!((&frames[0].elements[..], frames[0].positions[1]), (&[8, 1][..], [1.0, 0.0, -0.1]));
        assert_eq!((&frames[1].elements[..], frames[1].positions[0]), (&[26][..], [5.0, 6.0, 7.0]));
    }

    #[test]
    fn the_comment_names_the_columns() {
        let text = "1\nLattice=\"1 0 0 0 2 0 0 0 3\" Properties=pos:R:3:species:S:1:v:R:2:radius:R:1 pbc='T T F'\n1 2 3 Xx 4 5 0.5\n";
        let frame = read(text, &["V_y", "nothing"]).expect("a frame").remove(0);
        assert_eq!((frame.positions[0], frame.radii[0], frame.elements[0]), ([1.0, 2.0, 3.0], 0.5, 0));
        assert_eq!(frame.columns, [Column { name: "v_y".into(), values: vec![5.0] }]);
        assert_eq!((frame.cell.expect("a cell").edges[1], frame.open_edges), ([0.0, 2.0, 0.0], [false, false, true]));
        assert_eq!(frame.unknown.get("Xx"), Some(&1));
        assert_eq!(frame.when, FrameTime::default());
        let text = "1\nTime=0.25 step=40 Properties=pos:R:3\n1 2 3\n";
        assert_eq!(read(text, &[]).expect("a frame")[0].when, FrameTime { time: Some(0.25), step: Some(40) });
        assert_eq!(frame.has[3..], ["species", "v_x", "v_y", "radius"]);
    }

    #[test]
    fn z_is_a_coordinate_with_x_and_y_and_else_an_atomic_number() {
        for kind in ["I", "R"] {
            let frame =
                read(&format!("1\nProperties=x:R:1:y:R:1:z:{kind}:1\n1 2 3\n"), &[]).expect("a frame").remove(0);
            assert_eq!((frame.positions[0], frame.elements.len()), ([1.0, 2.0, 3.0], 0));
            let frame =
                read(&format!("1\nProperties=Z:{kind}:1:pos:R:3\n26 1 2 3\n"), &["z"]).expect("a frame").remove(0);
            assert_eq!((frame.positions[0], &frame.elements[..]), ([1.0, 2.0, 3.0], &[26][..]));
            assert_eq!((&frame.columns[0].values[..], frame.has[0].as_str()), (&[3.0][..], "atomic_number"));
            let error = read(&format!("1\nProperties=z:{kind}:1\n3\n"), &[]).map(drop).expect_err("no x and y");
            assert!(error.to_string().contains("pos with three columns is missing"), "{error}");
        }
    }

    #[test]
    fn a_cell_is_read_however_its_numbers_are_separated() {
        for lattice in [
            "\"1 2 3 4 5 6 7 8 9\"",
            "\"1, 2, 3 4, 5, 6 7, 8, 9\"",
            "[[1,2,3],[4, 5, 6],[7,8,9]]",
            "{1 2 3 4 5 6 7 8 9}",
        ] {
            let text = format!("1\nLattice={lattice} Properties=pos:R:3:species:S:1\n1 2 3 O\n");
            let frame = read(&text, &[]).expect("a frame").remove(0);
            assert_eq!(
                frame.cell.expect("a cell").edges,
                [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]],
                "{lattice}"
            );
            assert_eq!((frame.positions[0], frame.elements[0]), ([1.0, 2.0, 3.0], 8));
        }
    }

    #[test]
    fn a_cell_begins_at_its_origin() {
        let of = |comment: &str| read(&format!("1\n{comment}\nC -4 6 1\n"), &[]).map(|frames| frames[0].cell);
        let lattice = "Lattice=\"10 0 0 0 10 0 0 0 10\"";
        for (origin, expected) in [
            ("Origin=\"-5 -5.5 1e1\"", [-5.0, -5.5, 10.0]),
            ("origin=[-5, -5.5, 10]", [-5.0, -5.5, 10.0]),
            ("ORIGIN={-5 -5.5 10}", [-5.0, -5.5, 10.0]),
            ("Origin=\"the relaxed slab\"", [0.0; 3]),
            ("", [0.0; 3]),
        ] {
            for comment in [format!("{lattice} {origin}"), format!("{origin} {lattice} pbc=\"T T F\"")] {
                assert_eq!(of(&comment).expect("a frame").expect("a cell").origin, expected, "{comment}");
            }
        }
        assert_eq!(of("Origin=\"1 2 3\"").expect("a frame"), None, "an origin alone is no cell");
        for wrong in ["\"1 2\"", "\"1 2 3 4\"", "\"1 2 inf\"", "\"1 2 x\"", "7"] {
            let error = of(&format!("{lattice} Origin={wrong}")).expect_err(wrong).to_string();
            assert!(error.contains(":2:") && error.contains("Origin: ") && error.contains("is not a place"), "{error}");
        }
        let mut frame = read(&format!("1\n{lattice} Origin=\"-5 -5 -5\"\nC -4 6 1\n"), &[]).expect("a frame").remove(0);
        crate::particles::periodic::apply(crate::particles::periodic::Periodic::Wrap, &mut frame).expect("a cell");
        assert_eq!(frame.positions, [[-4.0, -4.0, 1.0]]);
    }

    #[test]
    fn trailing_lines_that_are_not_a_frame_are_reported() {
        let mut xyz = Xyz::new(Source::of_text("1\n\nO 0 0 0\n\nVEC 1\n"), Request::default());
        let frame = xyz.next().expect("read").expect("a frame");
        assert_eq!(frame.skipped.assumed, ["text:5:1: `VEC 1` after the 1 atoms does not begin a frame"]);
        xyz.next().map(drop).expect_err("the rest is not a frame");
    }

    #[test]
    fn the_length_of_a_vector_is_a_column() {
        let text = "2\nProperties=pos:R:3:vel:R:3\n0 0 0 2 -3 6\n1 1 1 0 -4 0\n";
        let frame = read(text, &["vel", "z"]).expect("a frame").remove(0);
        let column = |name: &str| &frame.columns.iter().find(|c| c.name == name).expect("a column").values;
        assert_eq!((&column("vel")[..], &column("z")[..]), (&[7.0, 4.0][..], &[0.0, 1.0][..]));
    }

    #[test]
    fn errors_are_reported_with_line_and_column() {
        for (text, place) in [
            ("two\n\n", ":1:1: count"),
            ("2\n\nO 0 0 0\n", "file ends"),
            ("1\n\nO 0 0 0\nO 1 0 0\n\nO 2 0 0\n", ":4:1: count: expected 1 atoms, found 2"),
            ("0\n\nO 0 0 0\n", ":3:1: count: expected 0 atoms, found 1"),
            ("99999999999\n\nO 0 0 0\n", "99999999999 spheres are more"),
            ("1\n\nO 0 zero 0\n", ":3:5: y"),
            ("1\n\nO 0 inf 0\n", ":3:5: y"),
            ("1\n\nO 0 1\n", ":3:6: z"),
            ("1\nProperties=pos:R\nO 0 1\n", ":2:12: Properties"),
            ("1\nProperties=species:S:1\nO\n", "pos with three columns is missing"),
            ("1\nProperties=pos:R:3:radius:R:1:radius:R:1\n0 0 0 1 1\n", "occurs twice"),
            ("1\nProperties=pos:R:99999999999999\n0 0 0 1 1\n", "columns"),
            (
                &format!("1\nProperties=pos:R:3{}\n", ":a:R:4000".repeat(90_000)),
                ":2:12: Properties: more than 4096 columns",
            ),
            ("1\nLattice=\"1 2\"\nO 0 0 0\n", ":2:10: Lattice"),
            ("1\nProperties=pos:R:3:radius:R:1\n0 0 0 -1\n", ":3:7: radius"),
        ] {
            let error = read(text, &[]).map(drop).expect_err(text).to_string();
            assert!(error.contains(place), "{error}");
        }
    }
}
