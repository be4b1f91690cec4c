//! LAMMPS dump: a sequence of `ITEM:` sections; the section of atoms ends a frame. Columns, scaled coordinates and the
//! bounding box of a tilted cell are described at docs.lammps.org/dump.html and docs.lammps.org/Howto_triclinic.html.

use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::{Lines, Words};
use crate::particles::colors::ColorType;
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::frame_time::FrameTime;
use crate::particles::layout::Layout;
use crate::particles::meaning::{FieldKind, Meanings, NamedField, meanings};
use crate::particles::mixed::is_text;
use crate::particles::periodic::images::open_edges;
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::particles::rows::{rows, surplus};
use crate::source::Source;
use halfline_ground::Cell;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::quote;
use std::io::BufRead;

pub(crate) const DUMP: FormatRow = FormatRow {
    name: "dump",
    about: "LAMMPS dump",
    endings: &["lammpstrj"],
    signs: &[Sign::Signature(|lines| lines.first().is_some_and(|line| line.starts_with("ITEM:")))],
    has: &[Has::Blocks, Has::AnyColumns, Has::Ids],
    open: Open::Frames(|source, request, _| Ok(Box::new(Dump::new(source, request)))),
    ..FormatRow::PLAIN
};

/// The reader.
pub(crate) struct Dump {
    lines: Lines<Input>,
    request: Request,
}

/// The sections before a frame's atoms; the line with their columns is the current one.
struct DumpHeader {
    count: u64,
    cell: Option<Cell>,
    open_edges: [bool; 3],
    when: FrameTime,
}

/// Names of coordinates in order of preference: plain, unwrapped, and as fractions of the cell's edges.
const AXES: [([&str; 3], bool); 4] =
    [(["x", "y", "z"], false), (["xu", "yu", "zu"], false), (["xs", "ys", "zs"], true), (["xsu", "ysu", "zsu"], true)];

/// The remedy for a file that ends within a frame.
const MEND: &str = "give as many atoms as the frame says";

impl Dump {
    pub(crate) fn new(source: Source, request: Request) -> Self {
        Self { lines: Lines::new(source.reader, &source.path), request }
    }

    fn head(&mut self) -> Result<Option<DumpHeader>> {
        let (mut count, mut cell, mut open) = (None, None, [false; 3]);
        let (mut begun, mut foreign) = (false, false);
        let (mut time, mut step) = (None, None);
        loop {
            if !self.lines.advance()? {
                return if begun { Err(self.lines.cut("ITEM", MEND)) } else { Ok(None) };
            }
            let text = self.lines.text().trim();
            let Some(item) = text.strip_prefix("ITEM:").map(str::trim) else {
                if foreign || text.is_empty() {
                    continue;
                }
                let problem = format!("{} is not an ITEM", quote(text));
                return Err(self.lines.fail(0, "ITEM", problem, "give as many atoms as NUMBER OF ATOMS says"));
            };
            (begun, foreign) = (true, false);
            if item == "TIMESTEP" {
                self.lines.need("TIMESTEP", MEND)?;
                step = self.lines.text().trim().parse().ok();
            } else if item == "TIME" {
                self.lines.need("TIME", MEND)?;
                time = self.lines.text().trim().parse().ok();
            } else if item == "NUMBER OF ATOMS" {
                self.lines.need("NUMBER OF ATOMS", MEND)?;
                count = Some(self.lines.count("NUMBER OF ATOMS", "use a whole number")?);
            } else if let Some(kind) = item.strip_prefix("BOX BOUNDS") {
                let kind = kind.to_owned();
                open = open_edges(kind.split_whitespace());
                cell = Some(self.cell(&kind)?);
            } else if item.split_whitespace().next() == Some("ATOMS") {
                let count = count.ok_or_else(|| {
                    self.lines.fail(
                        0,
                        "ITEM",
                        "the number of atoms is not known",
                        "add ITEM: NUMBER OF ATOMS before the atoms",
                    )
                })?;
                return Ok(Some(DumpHeader { count, cell, open_edges: open, when: FrameTime::of(time, step) }));
            } else {
                // UNITS and other sections.
                foreign = true;
            }
        }
    }

    /// The three lines of the box.
    fn cell(&mut self, kind: &str) -> Result<Cell> {
        let general = kind.split_whitespace().next() == Some("abc");
        let tilted = !general && kind.split_whitespace().any(|word| word == "xy");
        let a = self.bounds(2 + usize::from(tilted) + 2 * usize::from(general))?;
        let b = self.bounds(2 + usize::from(tilted) + 2 * usize::from(general))?;
        let c = self.bounds(2 + usize::from(tilted) + 2 * usize::from(general))?;
        if general {
            let edge = |v: [f64; 4]| [v[0], v[1], v[2]];
            return Ok(Cell { origin: [a[3], b[3], c[3]], edges: [edge(a), edge(b), edge(c)] });
        }
        let (xy, xz, yz) = (a[2], b[2], c[2]);
        // These are the bounds of the box around the tilted cell.
        let low = [a[0] - [xy, xz, xy + xz].into_iter().fold(0.0, f64::min), b[0] - yz.min(0.0), c[0]];
        let high = [a[1] - [xy, xz, xy + xz].into_iter().fold(0.0, f64::max), b[1] - yz.max(0.0), c[1]];
        let side = |k: usize| high[k] - low[k];
        Ok(Cell { origin: low, edges: [[side(0), 0.0, 0.0], [xy, side(1), 0.0], [xz, yz, side(2)]] })
    }

    fn bounds(&mut self, count: usize) -> Result<[f64; 4]> {
        self.lines.need("BOX BOUNDS", MEND)?;
        let mut words = Words::of(&self.lines);
        let mut bounds = [0.0; 4];
        for bound in &mut bounds[..count] {
            let Some(word) = words.next() else {
                return Err(self.lines.ends("BOX BOUNDS", format!("expected {count} numbers"), "give all of them"));
            };
            *bound = word.finite("BOX BOUNDS")?;
        }
        Ok(bounds)
    }

    /// The columns named by the current line, and whether coordinates are fractions of the cell's edges. The first of
    /// `count` atoms, whose line is then the current one, shows which columns are text.
    fn layout(&mut self, count: u64) -> Result<(Layout, bool)> {
        let names = || Words::of(&self.lines).skip(2);
        let at = names().next().map_or(self.lines.text().len(), |word| word.at);
        let fail = |problem: String, mend| Err(self.lines.fail(at, "ITEM: ATOMS", problem, mend));
        let has = |name: &str| names().any(|word| word.text == name);
        let Some((axes, scaled)) = AXES.into_iter().find(|(axes, _)| axes.iter().all(|axis| has(axis))) else {
            return fail("no three columns are coordinates".into(), "dump x y z, xu yu zu, xs ys zs or xsu ysu zsu");
        };
        let fields: Vec<NamedField<'_>> =
            names().map(|word| NamedField { name: word.text, count: 1, kind: FieldKind::Text }).collect();
        let Meanings { fields, warnings, .. } = meanings(&fields);
        let role = |name: &str, role: Role| match (name, role) {
            ("element", _) => Role::Symbol,
            // The label of a type may look like a number.
            ("typelabel", _) => Role::Text,
            (name, Role::Position(_) | Role::Other) => {
                axes.iter().position(|axis| *axis == name).map_or(Role::Other, Role::Position)
            }
            (_, role) => role,
        };
        let mut columns: Vec<_> =
            fields.concat().into_iter().map(|(name, found)| (name.clone(), role(&name, found))).collect();
        let place = self.lines.place(at).named("ITEM: ATOMS");
        if count > 0 {
            self.lines.need("atom", MEND)?;
            for (word, (_, role)) in Words::of(&self.lines).zip(&mut columns) {
                if *role == Role::Other && is_text(word.text) {
                    *role = Role::Text;
                }
            }
        }
        let mut layout = Layout::new(&self.request);
        layout.note(ColorType::Real, warnings);
        for (name, role) in &columns {
            let twice = |problem: String| Error::scene(place.clone(), problem, "use each column name once");
            layout.add(name, *role).map_err(twice)?;
        }
        Ok((layout, scaled))
    }

    /// Checks that no more atoms follow than `count`; then the next line that is not blank is the current one.
    fn check_end(&mut self, count: u64, layout: &Layout) -> Result<()> {
        while self.lines.advance()? {
            if self.lines.text().trim().is_empty() {
                continue;
            }
            let is_row = |lines: &Lines<Input>| layout.fits(Words::of(lines), lines);
            if is_row(&self.lines) {
                return surplus(&mut self.lines, count, "atoms", is_row);
            }
            self.lines.give_back();
            break;
        }
        Ok(())
    }
}

impl ParticleFrames for Dump {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(DumpHeader { count, cell, open_edges, when }) = self.head()? else { return Ok(None) };
        let item = self.lines.place(0).named("ITEM: ATOMS");
        let (layout, scaled) = self.layout(count)?;
        let mut particles = Particles { cell, open_edges, when, ..layout.begin() };
        let scaling = match cell {
            Some(cell) if scaled => Some(cell),
            None if scaled => {
                let mend = "add ITEM: BOX BOUNDS before the atoms";
                return Err(Error::scene(item, "the coordinates are fractions of a cell that is not given", mend));
            }
            _ => None,
        };
        if count > 0 {
            atom(&self.lines, &layout, scaling, &mut particles)?;
            self.lines.found();
            let row = |line: &Lines<&[u8]>, found: &mut _| atom(line, &layout, scaling, found);
            if rows(&mut self.lines, count - 1, &layout, &mut particles, row)? < count - 1 {
                return Err(self.lines.cut("atom", MEND));
            }
        }
        self.check_end(count, &layout)?;
        particles.settle_texts()?;
        Ok(Some(particles))
    }

    fn skip(&mut self) -> Result<bool> {
        let Some(DumpHeader { count, .. }) = self.head()? else { return Ok(false) };
        let columns = Words::of(&self.lines).count().saturating_sub(2);
        if !self.lines.pass_rows(count, columns)? { Err(self.lines.cut("atom", MEND)) } else { Ok(true) }
    }
}

/// Adds the atom of the current line, whose coordinates are fractions of the edges of a cell where there is one.
fn atom<R: BufRead>(lines: &Lines<R>, layout: &Layout, scaling: Option<Cell>, particles: &mut Particles) -> Result<()> {
    let before = particles.positions.len();
    layout.row(&mut Words::of(lines), lines, particles)?;
    // Particles are counted and dropped before the frame ends, so each is placed in its row.
    if let Some(cell) = scaling {
        particles.positions[before..].iter_mut().for_each(|position| *position = cell.place(*position));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::frame::all;

    fn read(text: &str, columns: &[&str]) -> Result<Vec<Particles>> {
        all(Dump::new(Source::of_text(text), Request::of(columns)))
    }

    fn frame(bounds: &str, columns: &str, atoms: &str) -> String {
        let count = atoms.lines().count();
        format!(
            "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS {columns}\n{atoms}\n"
        )
    }

    const CUBE: &str = "pp pp pp\n-1 1\n0 4\n0 8";

    #[test]
    fn frames_follow_each_other_with_their_columns() {
        let first = frame(CUBE, "id type x y z vx radius", "2 1 0 1 2 -5 0.5\n1 2 3 4 5 6e1 1.5");
        let second = frame(CUBE, "xs ys element zs diameter", "0.5 0.25 Fe 1 3");
        let frames = read(&format!("ITEM: UNITS\nlj\nITEM: TIME\n0.5\n{first}\n{second}"), &["VX"]).expect("frames");
        assert_eq!(frames.len(), 2);
        assert_eq!(frames[0].positions, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]], "in the file's order");
        assert_eq!((&frames[0].radii[..], &frames[0].columns[0].values[..]), (&[0.5, 1.5][..], &[-5.0, 60.0][..]));
        assert!(frames[0].elements.is_empty(), "a type is no element");
        assert_eq!(frames[0].has, ["id", "type", "x", "y", "z", "vx", "radius"]);
        assert_eq!((frames[1].positions[0], frames[1].radii[0]), ([0.0, 1.0, 8.0], 1.5));
        assert_eq!((&frames[1].elements[..], frames[1].columns.len()), (&[26][..], 0));
        let when = [Some(0.5), None].map(|time| FrameTime { time, step: Some(7) });
        assert_eq!([frames[0].when, frames[1].when], when);
    }

    #[test]
    fn scaled_coordinates_go_along_the_edges_of_a_tilted_cell() {
        // From docs.lammps.org/Howto_triclinic: xlo_bound = xlo + min(0, xy, xz, xy + xz), and so on.
        let tilted = frame("xy xz yz pp fs pp\n-3 4 -3\n0 7 2\n0 5 1", "xsu ysu zsu", "0.5 0.5 0.5");
        let cell = Cell { origin: [0.0; 3], edges: [[2.0, 0.0, 0.0], [-3.0, 6.0, 0.0], [2.0, 1.0, 5.0]] };
        let read_one = |text: &str| read(text, &[]).expect("a frame").remove(0);
        let found = read_one(&tilted);
        assert_eq!((found.cell, found.positions[0]), (Some(cell), [0.5, 3.5, 2.5]));
        assert_eq!(found.open_edges, [false, true, false]);
        let general = frame("abc origin pp pp pp\n0 2 0 1\n3 0 0 2\n0 0 4 3", "xs ys zs", "0.5 1 0.25");
        let found = read_one(&general);
        assert_eq!((found.cell.expect("a cell").origin, found.positions[0]), ([1.0, 2.0, 3.0], [4.0, 3.0, 4.0]));
        let both = read_one(&frame(CUBE, "xs ys zs xu yu zu", "0 0 0 9 9 9"));
        assert_eq!(both.positions[0], [9.0; 3], "unwrapped before scaled");
    }

    #[test]
    fn columns_of_text_are_names() {
        let named = |found: &Particles, name: &str| {
            let column = found.columns.iter().find(|column| column.name == name).expect(name);
            column.values.iter().map(|value| found.labels[name][*value as usize].clone()).collect::<Vec<_>>()
        };
        let first = frame(CUBE, "id mol typelabel x y z q", "1 wat 1 0 1 2 nan\n2 lig c3 0 1 2 0.5\n3 wat c3 0 1 2 1");
        let second = frame(CUBE, "id mol x y z", "1 7 0.5 0 0\n2 8 1 0 0");
        let frames = read(&format!("{first}{second}"), &["mol", "typelabel", "q"]).expect("frames");
        assert_eq!(
            (named(&frames[0], "mol"), named(&frames[0], "typelabel")),
            (["wat", "lig", "wat"].map(String::from).to_vec(), ["1", "c3", "c3"].map(String::from).to_vec())
        );
        assert_eq!((frames[0].columns[2].values[1], frames[0].labels.len()), (0.5, 2), "numbers stay");
        assert_eq!((&frames[1].columns[0].values[..], frames[1].labels.len()), (&[7.0, 8.0][..], 0));
        // A text below a number makes names of both.
        read(&first, &[]).expect("no column");
        let mixed = read(&frame(CUBE, "mol x y z", "7 0 0 0\nwat 0 0 0"), &["mol"]).expect("names");
        assert_eq!(named(&mixed[0], "mol"), ["7", "wat"]);
        let none = frame(CUBE, "mol x y z", "").replace("ATOMS mol x y z\n\n", "ATOMS mol x y z\n");
        assert!(read(&format!("{none}{second}"), &["mol"]).expect("no atoms").len() == 2);
    }

    #[test]
    fn skipped_frames_are_not_parsed() {
        let text = frame(CUBE, "x y z", "no numbers here\nat all, at") + &frame(CUBE, "x y z", "1 2 3");
        let mut dump = Dump::new(Source::of_text(&text), Request::default());
        assert!(dump.skip().expect("the first"));
        assert_eq!(dump.next().expect("the second").expect("a frame").positions, [[1.0, 2.0, 3.0]]);
        assert!(!dump.skip().expect("the end"));
    }

    #[test]
    fn errors_are_reported_with_line_and_column() {
        let one = |columns: &str, atoms: &str| frame(CUBE, columns, atoms);
        for (text, expected) in [
            (one("x y z", "1 2 b"), ":10:5: z: `b`"),
            (one("x y z", "1 2"), ":10:4: z"),
            (one("x y z x", "1 2 3 4"), ":9:13: ITEM: ATOMS: `x` occurs twice"),
            (one("x y zs", "1 2 3"), "no three columns"),
            (one("x y z radius", "1 2 3 0"), ":10:7: radius: `0` is not positive"),
            (one("x y z", "1 2 3") + "4 5 6\n", ":11:1: count: expected 1 atoms, found 2"),
            (one("x y z", "1 2 3") + "no row\n", ":11:1: ITEM: `no row` is not an ITEM"),
            (one("x y z", "1 2 3").replace("\n1\n", "\n2\n"), "the file ends within a frame"),
            (one("x y z", "1 2 3").replace("\n1\n", "\n-1\n"), ":4:1: NUMBER OF ATOMS"),
            (one("x y z", "1 2 3").replace("0 4", "0"), ":7:2: BOX BOUNDS"),
            ("ITEM: ATOMS x y z\n1 2 3\n".into(), "the number of atoms is not known"),
            ("ITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS xs ys zs\n1 2 3\n".into(), "a cell that is not given"),
            ("ITEM: TIMESTEP\n".into(), "ends within"),
        ] {
            let error = read(&text, &[]).map(drop).expect_err(&text).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
