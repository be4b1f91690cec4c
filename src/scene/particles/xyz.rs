//! XYZ and extended XYZ: a count, a comment, and a line for every atom; frame after frame. The comment of extended XYZ
//! says what the columns are (`Properties=species:S:1:pos:R:3:forces:R:3`) and what the cell is (`Lattice="..."`);
//! described at github.com/libAtoms/extxyz.

use super::{Cell, Column, Frames, Particles};
use crate::error::{Error, Result};
use crate::scene::ReadOptions;
use crate::scene::lines::{Lines, Words};
use crate::scene::source::Source;
use crate::scene::style::elements::{atomic_number, element};
use std::io::BufRead;

/// The reader.
pub(super) struct Xyz {
    lines: Lines<Box<dyn BufRead + Send>>,
    wanted: Vec<String>,
}

/// What a column of an atom's line is.
#[derive(Debug, Clone, PartialEq)]
enum Use {
    /// A symbol or an atomic number.
    Species,
    Number,
    Position(usize),
    Radius,
    /// Of the wanted columns, the one of this number.
    Wanted(usize),
    Ignored,
}

/// A frame's columns in the order of the file.
struct Layout {
    uses: Vec<Use>,
    has: Vec<String>,
}

impl Xyz {
    pub(super) fn new(source: Source, options: &ReadOptions) -> Self {
        Self { lines: Lines::new(source.reader, &source.path), wanted: options.style.columns().to_vec() }
    }

    /// The number of atoms that the next frame announces; `None` at the end of the file.
    fn count(&mut self) -> Result<Option<u64>> {
        loop {
            if !self.lines.advance()? {
                return Ok(None);
            }
            let text = self.lines.text().trim();
            if text.is_empty() {
                continue;
            }
            return text.parse().map(Some).map_err(|_| {
                let problem = format!("`{text}` is no number of atoms");
                self.fail(0, "count", problem, "begin a frame with the number of its atoms")
            });
        }
    }

    /// The next line, which must be there.
    fn need(&mut self, what: &str) -> Result<()> {
        if self.lines.advance()? {
            return Ok(());
        }
        let end = self.lines.text().len();
        Err(self.fail(end, what, "the file ends within a frame", "give as many lines as the frame announces"))
    }

    fn fail(&self, byte: usize, field: &str, problem: impl Into<String>, mend: &str) -> Error {
        Error::scene(self.lines.place(byte).named(field), problem, mend)
    }

    /// The columns and the cell that the comment line tells of.
    fn layout(&self, particles: &mut Particles) -> Result<Layout> {
        let mut properties = "species:S:1:pos:R:3";
        for (at, key, value) in pairs(self.lines.text()) {
            match &key.to_ascii_lowercase()[..] {
                "properties" => properties = value,
                "lattice" => particles.cell = Some(self.lattice(at, value)?),
                _ => {}
            }
        }
        let at = self.lines.text().find(properties).unwrap_or(0);
        let wrong = |problem: String| {
            self.fail(at, "Properties", problem, "write name:type:columns triples such as species:S:1:pos:R:3")
        };
        let parts: Vec<&str> = properties.split(':').collect();
        let mut layout = Layout { uses: Vec::new(), has: Vec::new() };
        for triple in parts.chunks(3) {
            let [name, kind @ ("S" | "R" | "I" | "L"), count] = triple else {
                return Err(wrong(format!("`{}` is no name, type and number of columns", triple.join(":"))));
            };
            let count: usize = count.parse().map_err(|_| wrong(format!("`{count}` is no number of columns")))?;
            if layout.uses.len() + count > MOST_COLUMNS {
                return Err(wrong(format!("more than {MOST_COLUMNS} columns")));
            }
            for k in 0..count {
                layout.add(&name.to_ascii_lowercase(), kind, (count > 1).then_some(k), &self.wanted);
            }
        }
        match (0..3).find(|k| !layout.uses.contains(&Use::Position(*k))) {
            None => Ok(layout),
            Some(_) => Err(wrong("there is no pos of three columns".into())),
        }
    }

    fn lattice(&self, at: usize, text: &str) -> Result<Cell> {
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        match numbers[..] {
            [a, b, c, d, e, f, g, h, i] if numbers.iter().all(|x| x.is_finite()) => {
                Ok(Cell { origin: [0.0; 3], edges: [[a, b, c], [d, e, f], [g, h, i]] })
            }
            _ => {
                Err(self.fail(at, "Lattice", format!("`{text}` is no cell"), "give three vectors, nine finite numbers"))
            }
        }
    }

    /// Takes the atom of the current line.
    fn atom(&self, layout: &Layout, particles: &mut Particles) -> Result<()> {
        let mut words = Words::of(&self.lines);
        let mut position = [0.0; 3];
        for kind in &layout.uses {
            let missing = "give a number for every column that the frame announces";
            let Some(word) = words.next() else {
                let end = self.lines.text().len();
                return Err(self.fail(
                    end,
                    "atom",
                    format!("the line ends before all of its {} columns", layout.uses.len()),
                    missing,
                ));
            };
            match *kind {
                Use::Ignored => {}
                Use::Position(k) => position[k] = word.finite(["x", "y", "z"][k])?,
                Use::Radius => particles.radii.push(word.positive("radius")?),
                Use::Wanted(k) => particles.columns[k].values.push(word.number("column")?),
                Use::Number => {
                    particles.elements.push(word.text.parse().ok().filter(|n| element(*n).is_some()).unwrap_or(0))
                }
                Use::Species => {
                    let number = species(word.text);
                    if number == 0 {
                        particles.meet_unknown(word.text);
                    }
                    particles.elements.push(number);
                }
            }
        }
        particles.positions.push(position);
        Ok(())
    }
}

/// More columns than any file has.
const MOST_COLUMNS: usize = 4096;

impl Layout {
    /// One more column: the `k`th of several by this name.
    fn add(&mut self, name: &str, kind: &str, k: Option<usize>, wanted: &[String]) {
        let numbered = k.map_or_else(|| name.to_owned(), |k| format!("{name}_{}", axis(k)));
        if kind != "S" {
            self.has.push(numbered.clone());
        }
        let asked = wanted.iter().position(|w| w.eq_ignore_ascii_case(&numbered)).filter(|_| kind != "S");
        let kind = match (name, k) {
            ("species" | "element" | "symbol", None) if kind == "S" && !self.uses.contains(&Use::Species) => {
                Use::Species
            }
            ("z" | "numbers" | "atomic_numbers", None) if kind == "I" && !self.uses.contains(&Use::Species) => {
                Use::Number
            }
            ("pos" | "positions", Some(k @ 0..3)) => Use::Position(k),
            ("radius" | "radii", None) => Use::Radius,
            _ => asked.map_or(Use::Ignored, Use::Wanted),
        };
        self.uses.push(kind);
    }
}

/// How a column of a vector is called: `forces_x`, and by its number beyond the third.
fn axis(k: usize) -> String {
    ["x", "y", "z"].get(k).map_or_else(|| k.to_string(), |name| (*name).to_owned())
}

/// A symbol, perhaps with a number after it (`C12`), or an atomic number.
fn species(word: &str) -> u8 {
    if let Ok(number) = word.parse::<u8>() {
        return element(number).map_or(0, |_| number);
    }
    let letters = word.trim_end_matches(|c: char| c.is_ascii_digit() || "+-_*'".contains(c));
    atomic_number(letters)
}

/// The `key=value` pairs of a comment, values perhaps in quotes or brackets, each with the byte its value begins at.
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
            _ => (' ', 0),
        };
        let start = value + open;
        let ends = |c: char| if close == ' ' { c.is_whitespace() } else { c == close };
        let end = text[start..].find(ends).map_or(text.len(), |k| start + k);
        found.push((start, key.trim_matches('"'), &text[start..end]));
        at = (end + open).min(text.len());
    }
    found
}

impl Frames for Xyz {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(count) = self.count()? else { return Ok(None) };
        let mut particles = Particles::default();
        self.need("comment")?;
        let layout = self.layout(&mut particles)?;
        particles.has.clone_from(&layout.has);
        particles.columns = self.wanted.iter().map(|name| Column { name: name.clone(), values: Vec::new() }).collect();
        for _ in 0..count {
            self.need("atom")?;
            self.atom(&layout, &mut particles)?;
        }
        particles.columns.retain(|column| {
            column.values.len() as u64 == count && layout.has.contains(&column.name.to_ascii_lowercase())
        });
        Ok(Some(particles))
    }

    fn skip(&mut self) -> Result<bool> {
        let Some(count) = self.count()? else { return Ok(false) };
        self.need("comment")?;
        for _ in 0..count {
            self.need("atom")?;
        }
        Ok(true)
    }
}

/// What the tests of formats share: a place without a file.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::style::{Coloring, Scale, Style};

    fn read(text: &str, columns: &[&str]) -> Result<Vec<Particles>> {
        let columns = columns.iter().map(|name| (*name).to_owned()).collect();
        let scale = Scale { columns, map: Default::default(), range: None, log: false };
        let style = Style { coloring: Coloring::Column(scale), ..Style::default() };
        let mut xyz = Xyz::new(Source::of_text(text), &ReadOptions { style, ..ReadOptions::default() });
        std::iter::from_fn(|| xyz.next().transpose()).collect()
    }

    #[test]
    fn frames_follow_each_other() {
        let frames = read("2\nwater\nO 0 0 0\nH1 1 0 -1e-1\n\n1\n\n26 5 6 7 extra\n", &[]).expect("frames");
        assert_eq!(frames.len(), 2);
        assert_eq!((&frames[0].elements[..], frames[0].positions[1]), (&[8, 1][..], [1.0, 0.0, -0.1]));
        assert_eq!((&frames[1].elements[..], frames[1].positions[0]), (&[26][..], [5.0, 6.0, 7.0]));
    }

    #[test]
    fn the_comment_says_what_the_columns_are() {
        let text = "1\nLattice=\"1 0 0 0 2 0 0 0 3\" Properties=pos:R:3:species:S:1:v:R:2:radius:R:1 pbc='T T F'\n1 2 3 Xx 4 5 0.5\n";
        let frame = read(text, &["V_y", "nothing"]).expect("a frame").remove(0);
        assert_eq!((frame.positions[0], frame.radii[0], frame.elements[0]), ([1.0, 2.0, 3.0], 0.5, 0));
        assert_eq!(frame.columns, [Column { name: "V_y".into(), values: vec![5.0] }]);
        assert_eq!(frame.cell.expect("a cell").edges[1], [0.0, 2.0, 0.0]);
        assert_eq!(frame.unknown.get("Xx"), Some(&1));
        assert_eq!(frame.has[3..], ["v_x", "v_y", "radius"]);
    }

    #[test]
    fn faults_are_told_with_line_and_column() {
        for (text, place) in [
            ("two\n\n", ":1:1: count"),
            ("2\n\nO 0 0 0\n", "file ends"),
            ("1\n\nO 0 zero 0\n", ":3:5: y"),
            ("1\n\nO 0 inf 0\n", ":3:5: y"),
            ("1\n\nO 0 1\n", ":3:6: atom"),
            ("1\nProperties=pos:R\nO 0 1\n", ":2:12: Properties"),
            ("1\nProperties=species:S:1\nO\n", "no pos"),
            ("1\nLattice=\"1 2\"\nO 0 0 0\n", ":2:10: Lattice"),
            ("1\nProperties=pos:R:3:radius:R:1\n0 0 0 -1\n", ":3:7: radius"),
        ] {
            let error = read(text, &[]).map(drop).expect_err(text).to_string();
            assert!(error.contains(place), "{error}");
        }
    }
}
