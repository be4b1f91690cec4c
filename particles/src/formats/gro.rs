//! GROMACS coordinates: a title, a count, a line of fixed columns for every atom, and the box; frame after frame
//! (manual.gromacs.org/current/reference-manual/file-formats.html#gro). Lengths are nanometres in the file and are
//! multiplied by ten to ångström. Velocities keep the file's unit, nm/ps.

use crate::format::{FormatRow, Has, Open, Sign};
use crate::formats::pdb::overruns;
use crate::input::Input;
use crate::lines::{Lines, Words};
use crate::particles::atom_property::{AtomProperty, NameTable};
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::frame_time::FrameTime;
use crate::particles::infer::{AtomNames, Inference};
use crate::particles::molecule::{Copies, Model};
use crate::particles::request::Request;
use crate::particles::rows::surplus;
use crate::signs::numbers;
use crate::source::Source;
use halfline_ground::Cell;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::quote;
use std::ops::Range;

pub(crate) const GRO: FormatRow = FormatRow {
    name: "gro",
    about: "GROMACS coordinates",
    signs: &[Sign::Structure(is_gro)],
    has: &[Has::Molecules, Has::Serials],
    open: Open::Frames(|source, request, _| Ok(Box::new(Gro::new(source, request)))),
    ..FormatRow::PLAIN
};

/// The reader.
pub(crate) struct Gro {
    lines: Lines<Input>,
    request: Request,
    /// Whether the way elements were found was reported.
    is_noted: bool,
    /// The time and the step in the title of the current frame.
    when: FrameTime,
}

/// The columns of an atom besides its position; a frame may have no velocities.
const HAS: [AtomProperty; 7] = {
    use AtomProperty::{Name, Residue, Resname, Serial, Vx, Vy, Vz};
    [Name, Resname, Residue, Serial, Vx, Vy, Vz]
};

/// The columns before the coordinates, from 0.
const RESIDUE: Range<usize> = 0..5;
const RESIDUE_NAME: Range<usize> = 5..10;
const NAME: Range<usize> = 10..15;
const SERIAL: Range<usize> = 15..20;
const X: usize = 20;

/// The remedy for a file that ends within a frame.
const MEND: &str = "give as many atoms as the count says, and the box";

/// Ångström per nanometre.
const NANOMETRE: f64 = 10.0;

impl Gro {
    pub(crate) fn new(source: Source, request: Request) -> Self {
        let lines = Lines::new(source.reader, &source.path).of_columns();
        Self { lines, request, is_noted: false, when: FrameTime::default() }
    }

    /// The number of atoms of the next frame; `None` at the end of the file.
    fn count(&mut self) -> Result<Option<u64>> {
        // A title may be empty; blank lines after the last frame are not titles.
        let mut titled = false;
        while self.lines.advance()? {
            let text = self.lines.text().trim();
            if titled && !text.is_empty() {
                let mend = "add a title, and the number of atoms on the line after it";
                return self.lines.count("count", mend).map(Some);
            }
            if !titled {
                self.when = FrameTime::of(behind(text, "t="), behind(text, "step="));
            }
            titled = true;
        }
        Ok(None)
    }

    fn field(&self, columns: Range<usize>) -> &[u8] {
        let line = self.lines.text().as_bytes();
        line.get(columns.start..columns.end.min(line.len())).unwrap_or_default()
    }

    fn number(&self, columns: Range<usize>) -> Option<f64> {
        std::str::from_utf8(self.field(columns)).ok()?.trim().parse().ok()
    }

    /// The width of a coordinate: the distance between decimal points.
    fn width(&self) -> Result<usize> {
        let rest = self.field(X..usize::MAX);
        let mut points = (0..rest.len()).filter(|k| rest[*k] == b'.');
        let [first, second] = [points.next(), points.next()];
        first.zip(second).map(|(first, second)| second - first).ok_or_else(|| {
            let problem = "no two numbers with a decimal point follow column 20";
            self.lines.fail(X.min(self.lines.text().len()), "x", problem, "write coordinates in the format %8.3f")
        })
    }

    /// Parses the atom of the current line.
    fn atom(&self, width: usize, names: &mut NameTable, model: &mut Model) -> Result<()> {
        let [name, residue, site] = [NAME, RESIDUE_NAME, RESIDUE].map(|columns| self.field(columns).trim_ascii());
        let atom = AtomNames { symbol: b"", name, residue, site };
        let mut position = [0.0; 3];
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let at = X + k * width;
            // A coordinate has five digits less than its columns behind the decimal point.
            let overruns = overruns(self.lines.text().as_bytes(), at..at + width, width.saturating_sub(5));
            let found = self.number(at..at + width).filter(|x| x.is_finite() && !overruns);
            position[k] = NANOMETRE
                * found.ok_or_else(|| {
                    let found = self.field(at..at + width);
                    let blanks = found.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
                    let problem = match overruns {
                        true => format!("{} goes on behind its columns", quote(found.trim_ascii())),
                        false => format!("expected a finite number, found {}", quote(found.trim_ascii())),
                    };
                    let byte = (at + blanks % found.len().max(1)).min(self.lines.text().len());
                    self.lines.fail(byte, axis, problem, "use the columns of the first atom of the frame")
                })?;
        }
        let number = |columns| self.number(columns).unwrap_or(f64::NAN);
        let velocity = |k: usize| number(X + (3 + k) * width..X + (4 + k) * width);
        model.push(&atom, position, 0, |kind| {
            Ok(match kind {
                AtomProperty::Name => names.number(kind, name)?,
                AtomProperty::Resname => names.number(kind, residue)?,
                AtomProperty::Residue => number(RESIDUE),
                AtomProperty::Serial => number(SERIAL),
                AtomProperty::Vx => velocity(0),
                AtomProperty::Vy => velocity(1),
                AtomProperty::Vz => velocity(2),
                _ => 0.0,
            })
        })
    }

    /// The error for a box in place of atom `n`, from 0.
    fn early_box(&self, n: u64, count: u64) -> Option<Error> {
        let numbers = Words::of(&self.lines).map(|word| word.text.parse().is_ok_and(f64::is_finite));
        let numbers: Vec<bool> = numbers.take(10).collect();
        let problem = format!("expected {count} atoms, found {n} before the box");
        let is_box = matches!(numbers[..], [true, true, true]) || numbers.len() == 9 && numbers.iter().all(|is| *is);
        is_box.then(|| self.lines.fail(0, "count", problem, "correct the count"))
    }

    /// Checks that the current line is not an atom after the last of `count`.
    fn check_end(&mut self, width: usize, count: u64) -> Result<()> {
        let is_atom = |width: usize| move |lines: &Lines<Input>| is_atom(lines.text().as_bytes(), width);
        let width = if width > 0 { width } else { self.width().unwrap_or(0) };
        if is_atom(width)(&self.lines) { surplus(&mut self.lines, count, "atoms", is_atom(width)) } else { Ok(()) }
    }

    /// The box of the current line: three edges along the axes, or three vectors whose diagonal comes first.
    fn cell(&self) -> Result<Option<Cell>> {
        let mut numbers = Vec::new();
        for word in Words::of(&self.lines) {
            let ends = fields(word.text);
            for (start, end) in ends.iter().zip(&ends[1..]) {
                let edge = self.lines.word(word.at + start, word.at + end).finite("box")? * NANOMETRE;
                if edge.is_infinite() {
                    let problem = "an edge is too long for a number in angstrom";
                    return Err(self.lines.fail(word.at + start, "box", problem, "correct the box"));
                }
                numbers.push(edge);
            }
        }
        let edges = match numbers[..] {
            [x, y, z] => [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]],
            [ax, by, cz, ay, az, bx, bz, cx, cy] => [[ax, ay, az], [bx, by, bz], [cx, cy, cz]],
            _ => {
                let problem = format!("a box has {} numbers", numbers.len());
                return Err(self.lines.fail(0, "box", problem, "use 3 or 9, and check the number of atoms"));
            }
        };
        let some = numbers.iter().any(|x| *x != 0.0);
        Ok(some.then_some(Cell { origin: [0.0; 3], edges }))
    }
}

/// The number behind a word of a title, as GROMACS writes `t=   1.00000 step= 500`.
fn behind<T: std::str::FromStr>(title: &str, word: &str) -> Option<T> {
    let starts = |at: usize| title[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric());
    let (at, _) = title.match_indices(word).find(|(at, _)| starts(*at))?;
    let ends = |c: char| c.is_whitespace() || c == ',' || c == ';';
    title[at + word.len()..].split(ends).find(|word| !word.is_empty())?.parse().ok()
}

/// The positions of the numbers in a word, and its end. Numbers too long for their columns have no blank between them:
/// each has as many decimals as the last.
fn fields(word: &str) -> Vec<usize> {
    let mut ends = vec![0];
    if let Some(last) = word.rfind('.') {
        let behind = word.len() - last;
        let points = word.match_indices('.').map(|(at, _)| at + behind).filter(|end| *end < word.len());
        ends.extend(points.filter(|end| word.is_char_boundary(*end)));
    }
    ends.push(word.len());
    ends
}

/// Whether a line has the columns of an atom: its number, and three coordinates of this width with a decimal point
/// each.
fn is_atom(line: &[u8], width: usize) -> bool {
    let field = |from: usize, to: usize| line.get(from..to.min(line.len())).unwrap_or_default().trim_ascii();
    let number = |field: &[u8]| std::str::from_utf8(field).is_ok_and(|text| text.parse::<f64>().is_ok());
    let coordinate = |k: usize| field(X + k * width, X + (k + 1) * width);
    let whole = |columns: Range<usize>| {
        let field = field(columns.start, columns.end);
        !field.is_empty() && field.iter().all(u8::is_ascii_digit)
    };
    width > 0
        && whole(RESIDUE)
        && whole(SERIAL)
        && !field(NAME.start, NAME.end).is_empty()
        && (0..3).all(|k| number(coordinate(k)) && coordinate(k).contains(&b'.'))
}

impl ParticleFrames for Gro {
    fn next(&mut self) -> Result<Option<Particles>> {
        let Some(count) = self.count()? else { return Ok(None) };
        let mut model = Model::new(&self.request, &HAS[..4], Inference::new(false));
        let (mut names, mut width) = (NameTable::default(), 0);
        for n in 0..count {
            self.lines.need("atom", MEND)?;
            if n == 0 {
                width = self.width()?;
                let moving = !self.field(X + 3 * width..usize::MAX).trim_ascii().is_empty();
                model = Model::new(&self.request, if moving { &HAS } else { &HAS[..4] }, Inference::new(false));
            }
            if let Err(error) = self.atom(width, &mut names, &mut model) {
                return Err(self.early_box(n, count).unwrap_or(error));
            }
            self.lines.found();
        }
        self.lines.need("box", MEND)?;
        self.check_end(width, count)?;
        let cell = self.cell()?;
        // The line after the box is the next frame's title, not an atom.
        let more = self.lines.advance()?;
        self.check_end(width, count)?;
        if more {
            self.lines.give_back();
        }
        let mut particles = model.finish(Copies::None, &[], &self.lines.file())?;
        (particles.cell, particles.when) = (cell, self.when);
        names.label(&mut particles);
        // All frames would have the same message.
        if std::mem::replace(&mut self.is_noted, true) {
            particles.skipped.assumed.clear();
        }
        Ok(Some(particles))
    }

    fn skip(&mut self) -> Result<bool> {
        let Some(count) = self.count()? else { return Ok(false) };
        for _ in 0..count {
            self.lines.need("atom", MEND)?;
            self.lines.found();
        }
        self.lines.need("box", MEND)?;
        let cell = self.cell();
        if self.lines.is_last()? { cell.map(|_| true) } else { Ok(true) }
    }
}

/// A title, a count, and atoms with their number in columns 16 to 20, before coordinates with a decimal point.
fn is_gro(lines: &[&str]) -> bool {
    let [_, count, atom, ..] = lines else { return false };
    let whole = |text: Option<&str>| text.is_some_and(|text| text.trim().parse::<i64>().is_ok());
    whole(Some(count))
        && whole(atom.get(..5))
        && whole(atom.get(15..20))
        && atom.get(20..).is_some_and(|rest| numbers(rest) >= 3 && rest.contains('.'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::frame::Column;

    fn gro(text: &str, columns: &[&str]) -> Gro {
        Gro::new(Source::of_text(text), Request::of(columns))
    }

    fn read(text: &str, columns: &[&str]) -> Result<Vec<Particles>> {
        let mut gro = gro(text, columns);
        std::iter::from_fn(|| gro.next().transpose()).collect()
    }

    /// The first atoms of the manual's example; and a frame with five decimals and another box.
    const TWO: &str = "\
MD of 2 waters, t= 0.0
    3
    1WATER  OW1    1   0.126   1.624   1.679  0.1227 -0.0580  0.0434
    1WATER  HW2    2   0.190   1.661   1.747  0.8085  0.3191 -0.7791
    1WATER  HW3    3-100.177-200.568-300.613 -0.9045 -2.6469  1.3180
   1.82060   1.82060   1.82060

 1
12345CA      CA99999   0.12600   1.62400   1.67900
 1 2 3 0 0 0.25 0 0.5 0.75
";

    #[test]
    fn titles_have_a_time_and_a_step() {
        for (title, time, step) in [
            ("MD of 2 waters, t= 0.0", Some(0.0), None),
            ("Protein in water t=  12.50000 step= 6250", Some(12.5), Some(6250)),
            ("offset=3 t=1e3,step=-1", Some(1000.0), Some(-1)),
            ("at t= start", None, None),
            ("water", None, None),
            ("t=nan", None, None),
        ] {
            let frame = read(&format!("{title}\n0\n1 1 1\n"), &[]).expect("a frame").remove(0);
            assert_eq!(frame.when, FrameTime { time, step }, "{title}");
        }
    }

    #[test]
    fn frames_are_read_in_angstrom_by_the_width_that_decimals_give() {
        let frames = read(TWO, &["VX", "vz", "residue", "serial"]).expect("two frames");
        let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= b.abs() * f64::EPSILON);
        // One rounding for the decimal number, one for the multiplication by ten.
        assert!(close(frames[0].positions[0], [1.26, 16.24, 16.79]), "{:?}", frames[0].positions);
        assert!(close(frames[0].positions[2], [-1001.77, -2005.68, -3006.13]), "{:?}", frames[0].positions);
        assert_eq!(frames[0].elements, [8, 1, 1]);
        assert_eq!(frames[0].columns[0], Column { name: "vx".into(), values: vec![0.1227, 0.8085, -0.9045] });
        assert_eq!(frames[0].columns[1].values[2], 1.318);
        assert!(frames[0].skipped.assumed[0].starts_with("the file gives no element for 3 of 3 atoms"));
        assert!((frames[0].cell.expect("a box").edges[1][1] - 18.206).abs() < 1e-14);
        assert_eq!(frames.len(), 2);
        assert!(close(frames[1].positions[0], [1.26, 16.24, 16.79]) && frames[1].elements == [20]);
        let names: Vec<&str> = frames[1].columns.iter().map(|column| &column.name[..]).collect();
        assert_eq!((names, frames[1].columns[1].values[0]), (vec!["residue", "serial"], 99999.0));
        let edges = [[10.0, 0.0, 0.0], [2.5, 20.0, 0.0], [5.0, 7.5, 30.0]];
        assert_eq!(frames[1].cell.expect("a box").edges, edges);
        let mut passed = gro(TWO, &[]);
        assert!(passed.skip().expect("one"));
        assert_eq!(passed.next().expect("read").expect("the second").elements, [20]);
        assert!(!passed.skip().expect("the end"));
    }

    #[test]
    fn a_box_needs_no_blanks_between_its_numbers() {
        let edges = |line: &str| {
            let text = TWO.replacen("   1.82060   1.82060   1.82060", line, 1);
            read(&text, &[]).map(|frames| frames[0].cell.expect("a box").edges)
        };
        let cube = |a, b, c| [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]];
        assert_eq!(edges("40000.0000040000.0000050000.00000").expect("a box"), cube(4e5, 4e5, 5e5));
        assert_eq!(edges(" 4.0 50000.0000060000.00000").expect("a box"), cube(40.0, 5e5, 6e5));
        assert_eq!(edges("1.252.503.75").expect("a box"), cube(12.5, 25.0, 37.5));
        let tilted =
            edges("1.00000 20000.0000030000.00000 0.0 0.0 1.0 0.00000-10000.00000-20000.00000").expect("a box");
        assert_eq!(tilted[2], [-1e5, -2e5, 3e5]);
        let error = edges("40000.0000040000.0000x50000.00000").expect_err("no number").to_string();
        assert!(error.contains("text:6:12: box: `40000.0000x` is not a number"), "{error}");
    }

    #[test]
    fn virtual_sites_are_left_out_with_their_columns() {
        let four = TWO.replace("    3\n", "    4\n").replace("  HW2 ", "  MW  ").replace(
            "    1WATER  HW3",
            "    1WATER  HW2    4   0.100   0.200   0.300  1.0000  2.0000  3.0000\n    1WATER  HW3",
        );
        let four = four.replace("WATER", "SOL  ");
        let frames = read(&four, &["serial", "vx"]).expect("two frames");
        assert_eq!(frames[0].elements, [8, 1, 1]);
        assert_eq!(frames[0].columns[0].values, [1.0, 4.0, 3.0]);
        assert_eq!(frames[0].columns[1].values, [0.1227, 1.0, -0.9045]);
        assert_eq!(frames[0].positions.len(), 3);
        assert!(frames[0].skipped.assumed.contains(&"1 virtual site left out (1 `MW`)".into()));
    }

    #[test]
    fn errors_are_reported_with_line_and_column() {
        for (old, new, place) in [
            ("    3\n", "three\n", "text:2:1: count"),
            ("    3\n", "9999999999999\n", "9999999999999 spheres are more than 32-bit ids"),
            ("    3\n", "    4\n", "text:6:1: count: expected 4 atoms, found 3 before the box"),
            ("    3\n", "    2\n", "text:5:1: count: expected 2 atoms, found 3"),
            ("    3\n", "    0\n", "text:3:1: count: expected 0 atoms, found 3"),
            ("   1.624   1.679  0.1", "   1.six   1.679  0.1", "text:3:32: y: expected a finite number, found `1.six`"),
            ("   0.126   1.624   1.679  0.1227 -0.0580  0.0434", "   0.126   1.624", "text:3:37: z"),
            ("   0.126   1.624   1.679  0.1227 -0.0580  0.0434", "", "text:3:21: x: no two numbers"),
            (
                "   0.190   1.661   1.747",
                "10000.190 1.661   1.747",
                "text:4:21: x: `10000.19` goes on behind its columns",
            ),
            (
                "   0.190   1.661   1.747",
                "   0.190   1.66110000.747",
                "text:4:37: z: `10000.74` goes on behind its columns",
            ),
            ("  0.190", "    inf", "text:4:26: x: expected a finite number, found `inf`"),
            ("   1.82060   1.82060   1.82060", "   1.82060   1.82060", "text:6:1: box: a box has 2 numbers"),
            ("   1.82060   1.82060   1.82060", " 1 -1e308 1", "text:6:4: box: an edge is too long"),
            (" 1 2 3 0 0 0.25 0 0.5 0.75\n", "", "ends within a frame"),
            ("WATER  OW1    1   0.126", "W\u{fc}TER \u{20ac}W1    1   0.126", "text:3:"),
        ] {
            let error = read(&TWO.replacen(old, new, 1), &[]).map(drop).expect_err(new).to_string();
            assert!(error.contains(place), "{error}");
        }
    }
}
