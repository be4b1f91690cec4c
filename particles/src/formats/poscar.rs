//! POSCAR and CONTCAR of VASP: a comment, a scale, three vectors of the cell, the species and their counts, and the
//! positions in order of the species (vasp.at/wiki/POSCAR). VASP 4 has no line of species; there the words of the comment
//! are taken where all are symbols. Lengths are ångström. Velocities are skipped.

use crate::elements::atomic_number;
use crate::format::{FormatRow, Open, Sign};
use crate::input::Input;
use crate::lines::{Lines, Word, Words};
use crate::particles::frame::{Column, Particles};
use crate::particles::layout::is_requested;
use crate::particles::request::Request;
use crate::particles::rows::surplus;
use crate::signs::numbers;
use crate::source::Source;
use halfline_ground::Cell;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::check_ids;
use halfline_ground::quote::{quote, unquoted};

pub(crate) const POSCAR: FormatRow = FormatRow {
    name: "poscar",
    about: "POSCAR and CONTCAR of VASP",
    endings: &["contcar", "vasp"],
    signs: &[Sign::Structure(is_poscar)],
    open: Open::Frame(read).optional(),
    ..FormatRow::PLAIN
};

/// The column of species.
const SPECIES: &str = "species";

/// The most species, and the most bytes of their names.
const MOST: usize = 1024;
const LONGEST: usize = 64;

/// The header: everything before the positions.
struct PoscarHeader {
    edges: [[f64; 3]; 3],
    /// The factors of Cartesian positions.
    scale: [f64; 3],
    /// The species with their counts; empty names are not known.
    species: Vec<(String, u64)>,
    /// Whether positions are fractions of the cell.
    direct: bool,
}

/// Reads the positions.
///
/// # Errors
/// [`Error::Scene`] with the place in the file, [`Error::Io`], [`Error::Limits`].
pub(crate) fn read(source: Source, request: &Request) -> Result<Particles> {
    let mut lines = Lines::new(source.reader, &source.path);
    let header = header(&mut lines)?;
    let mut particles = Particles { has: vec![SPECIES.into()], ..Particles::default() };
    // A species that occurs again has the label of the first.
    let (mut labels, mut places) = (Vec::new(), Vec::new());
    for (k, (name, _)) in header.species.iter().enumerate() {
        let label = if name.is_empty() { format!("{}", k + 1) } else { name.clone() };
        let place = labels.iter().position(|known| *known == label).unwrap_or(labels.len());
        places.push(place as f64);
        if place == labels.len() {
            labels.push(label);
        }
    }
    if is_requested(&request.columns, SPECIES) {
        particles.columns.push(Column { name: SPECIES.into(), values: Vec::new() });
        particles.labels.insert(SPECIES.into(), labels);
    }
    let known = header.species.iter().any(|(name, _)| !name.is_empty());
    for ((name, count), place) in header.species.iter().zip(places) {
        let number = atomic_number(symbol(name));
        for _ in 0..*count {
            need(&mut lines, "position")?;
            particles.grow(1, 0)?;
            particles.positions.push(position(&lines, &header)?);
            if known {
                particles.elements.push(number);
            }
            if let Some(column) = particles.columns.first_mut() {
                column.values.push(place);
            }
            lines.found();
        }
        if known && number == 0 && *count > 0 {
            particles.add_unknown(name, *count);
        }
    }
    // Velocities follow a blank line.
    let is_row = |lines: &Lines<Input>| words(lines).take(3).filter(|word| word.finite("x").is_ok()).count() == 3;
    if lines.advance()? && is_row(&lines) {
        let count = header.species.iter().map(|(_, count)| count).sum();
        return surplus(&mut lines, count, "atoms", is_row);
    }
    if !known && !particles.positions.is_empty() {
        let warning = "the file names no species, so there are no elements; write their symbols before the counts";
        particles.skipped.assumed.push(warning.into());
    }
    particles.cell = Some(Cell { origin: [0.0; 3], edges: header.edges });
    Ok(particles)
}

/// The symbol of a species: `Fe` of `Fe_pv` and of `Fe/0123abc`.
fn symbol(name: &str) -> &str {
    name.split(['_', '/']).next().unwrap_or_default()
}

fn need(lines: &mut Lines<Input>, field: &str) -> Result<()> {
    if lines.advance()? {
        return Ok(());
    }
    Err(lines.ends(field, "the file ends before it", "give as many positions as the counts say"))
}

/// The words of the current line before its comment, which `!` or `#` begins, perhaps behind a number.
fn words(lines: &Lines<Input>) -> impl Iterator<Item = Word<'_, Input>> {
    let end = lines.text().find(['!', '#']).unwrap_or(lines.text().len());
    Words::of(lines)
        .take_while(move |word| word.at < end)
        .map(move |word| lines.word(word.at, end.min(word.at + word.text.len())))
}

/// Three numbers at the beginning of the current line.
fn three(lines: &Lines<Input>, field: &str) -> Result<[f64; 3]> {
    let (mut numbers, mut found) = ([0.0; 3], words(lines));
    for number in &mut numbers {
        let missing = || lines.ends(field, "the line has fewer than three numbers", "write three");
        *number = found.next().ok_or_else(missing)?.finite(field)?;
    }
    Ok(numbers)
}

fn position(lines: &Lines<Input>, header: &PoscarHeader) -> Result<[f64; 3]> {
    let numbers = three(lines, "position")?;
    if header.direct {
        return Ok(Cell { origin: [0.0; 3], edges: header.edges }.place(numbers));
    }
    Ok([0, 1, 2].map(|k| numbers[k] * header.scale[k]))
}

fn header(lines: &mut Lines<Input>) -> Result<PoscarHeader> {
    need(lines, "comment")?;
    let comment = lines.text().to_owned();
    need(lines, "scale")?;
    let first = words(lines).map_while(|word| word.finite("scale").ok()).take(3).collect::<Vec<_>>();
    let factors = lines.place(0);
    need(lines, "cell")?;
    let mut edges = [three(lines, "cell")?, [0.0; 3], [0.0; 3]];
    for edge in &mut edges[1..] {
        need(lines, "cell")?;
        *edge = three(lines, "cell")?;
    }
    let scale = scale(&first, &edges).ok_or_else(|| {
        let mend = "write one factor, three positive factors, or minus the volume of the cell";
        Error::scene(factors.named("scale"), "the scale is no such number, or the cell has no volume", mend)
    })?;
    edges.iter_mut().for_each(|edge| (0..3).for_each(|k| edge[k] *= scale[k]));
    need(lines, "species")?;
    let named = words(lines).next().is_some_and(|word| word.text.parse::<f64>().is_err());
    let names: Vec<String> = if named { line_of_names(lines)? } else { Vec::new() };
    if named {
        need(lines, "counts")?;
    }
    let counts = counts(lines)?;
    if named && names.len() != counts.len() {
        let problem = format!("{} species have {} counts", names.len(), counts.len());
        return Err(lines.fail(0, "counts", problem, "give a count for each species"));
    }
    let words: Vec<String> = comment.split_whitespace().take(counts.len() + 1).map(str::to_owned).collect();
    let symbols =
        words.len() >= counts.len() && words[..counts.len()].iter().all(|word| atomic_number(symbol(word)) > 0);
    let names = match (named, symbols) {
        (true, _) => names,
        (false, true) => words,
        (false, false) => vec![String::new(); counts.len()],
    };
    check_ids(counts.iter().fold(0, |all, count| all.saturating_add(*count)))?;
    need(lines, "Direct or Cartesian")?;
    if lines.text().trim_start().starts_with(['s', 'S']) {
        need(lines, "Direct or Cartesian")?;
    }
    // VASP looks at the first letter only, and takes everything but these as direct.
    let direct = !lines.text().trim_start().starts_with(['c', 'C', 'k', 'K']);
    if !lines.text().trim_start().starts_with(['c', 'C', 'k', 'K', 'd', 'D']) {
        let problem = format!("{} is neither Direct nor Cartesian", quote(lines.text().trim()));
        return Err(lines.fail(0, "Direct or Cartesian", problem, "write one of the words before the positions"));
    }
    Ok(PoscarHeader { edges, scale, species: names.into_iter().zip(counts).collect(), direct })
}

/// The factors of the axes: one for all, one for each, or the one that gives a volume.
fn scale(numbers: &[f64], edges: &[[f64; 3]; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = edges.map(glam::DVec3::from_array);
    let volume = a.dot(b.cross(c)).abs();
    let scale = match *numbers {
        [x, y, z] => [x, y, z],
        [x] if x < 0.0 => [(-x / volume).cbrt(); 3],
        [x, ..] => [x; 3],
        [] => return None,
    };
    scale.iter().all(|x| *x > 0.0 && x.is_finite()).then_some(scale)
}

fn line_of_names(lines: &Lines<Input>) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for word in words(lines) {
        if names.len() == MOST || word.text.len() > LONGEST {
            let problem = format!("more than {MOST} species, or a name of more than {LONGEST} bytes");
            return Err(lines.fail(word.at, "species", problem, "write the symbol of each species once"));
        }
        names.push(unquoted(word.text).to_string());
    }
    Ok(names)
}

fn counts(lines: &Lines<Input>) -> Result<Vec<u64>> {
    let mut counts = Vec::new();
    for word in words(lines) {
        match word.text.parse() {
            Ok(count) if counts.len() < MOST => counts.push(count),
            // Other text may follow.
            _ if !counts.is_empty() => break,
            _ => {
                let problem = format!("{} is not a number of atoms", quote(word.text));
                return Err(lines.fail(word.at, "counts", problem, "write the number of atoms of each species"));
            }
        }
    }
    if counts.is_empty() {
        return Err(lines.fail(0, "counts", "the line is blank", "write the number of atoms of each species"));
    }
    Ok(counts)
}

/// A comment, a scale, three vectors, optionally a line of species, and whole numbers.
fn is_poscar(lines: &[&str]) -> bool {
    let lines: Vec<&str> = lines.iter().take(7).map(|line| line.split(['!', '#']).next().unwrap_or_default()).collect();
    let [_, scale, a, b, c, first, second] = &lines[..] else { return false };
    let vector = |line: &&str| numbers(line) == 3;
    let counts = |line: &str| line.split_whitespace().next().is_some_and(|word| word.parse::<u32>().is_ok());
    let species = first.trim_start().starts_with(|c: char| c.is_ascii_alphabetic());
    // The sixth or the seventh line has a word, unless all are rows of a table, perhaps under its header.
    let table = lines[1..7].iter().all(|line| numbers(line) >= 3 && numbers(line) == line.split_whitespace().count());
    !table
        && [1, 3].contains(&numbers(scale))
        && [a, b, c].into_iter().all(vector)
        && (counts(first) || species && counts(second))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CELL: &str = "2.0 0 0\n1.0 3.0 0.0\n0 0 4\n";

    #[test]
    fn comments_stand_behind_every_line() {
        let plain =
            "salt\n1.5\n2 0 0\n0 2 0\n0 0 2\nNa Cl\n1 1\nSelective dynamics\nDirect\n0 0 0 T T F\n.5 .5 .5 T T T\n";
        let expected = read(plain).expect("a file");
        for comment in ["! a", " ! 1 2 3", "!", "# b", " # 4 Cl", "!! c"] {
            let behind: String = plain.lines().map(|line| format!("{line}{comment}\n")).collect();
            let found = read(&behind).unwrap_or_else(|error| panic!("{comment}: {error}"));
            assert_eq!((&found.positions, &found.elements), (&expected.positions, &expected.elements), "{comment}");
            let start = crate::detect::recognise(behind.as_bytes(), std::path::Path::new("a"));
            assert_eq!(start.map(|(format, _)| format), Ok(crate::format::Format::POSCAR), "{behind}");
        }
        let error = read(&plain.replace(".5 .5 .5 T T T", ".5 .5 ! .5")).map(drop).expect_err("two").to_string();
        assert!(error.contains("position: the line has fewer than three numbers"), "{error}");
    }

    fn read(text: &str) -> Result<Particles> {
        super::read(Source::of_text(text), &Request::of(&["species"]))
    }

    #[test]
    fn positions_are_direct_or_cartesian_and_scaled() {
        let direct =
            read(&format!("salt\n 2.0\n{CELL}Na Cl_pv\n1 2\nDirect\n0 0 0\n.5 .5 .5 T T F\n0 0.25 -1 Cl\n\n0 0 1\n"));
        let direct = direct.expect("a crystal");
        assert_eq!(direct.positions, [[0.0; 3], [3.0, 3.0, 4.0], [0.5, 1.5, -8.0]]);
        assert_eq!((&direct.elements[..], &direct.columns[0].values[..]), (&[11, 17, 17][..], &[0.0, 1.0, 1.0][..]));
        assert_eq!(direct.labels["species"], ["Na", "Cl_pv"]);
        assert_eq!(direct.cell.expect("a cell").edges, [[4.0, 0.0, 0.0], [2.0, 6.0, 0.0], [0.0, 0.0, 8.0]]);
        // The volume is 24, so the factor of 192 is 2.
        let volume = read(&format!("Na Cl\n -192\n{CELL}1 2\nSelective dynamics\nkartesian\n0 0 0\n1 2 3\n4 5 6\n"));
        let volume = volume.expect("a crystal");
        // A cube root.
        assert!((volume.positions[2][2] - 12.0).abs() < 1e-14 && volume.elements == [11, 17, 17], "{volume:?}");
        let axes = read(&format!("by hand\n1 2 3\n{CELL}3\nC\n0 0 0\n1 2 3\n4 5 6\n")).expect("a crystal");
        assert_eq!((axes.positions[2], axes.elements.len()), ([4.0, 10.0, 18.0], 0));
        assert_eq!(axes.cell.expect("a cell").edges[1], [1.0, 6.0, 0.0]);
        assert!(axes.skipped.assumed[0].contains("names no species"), "{:?}", axes.skipped);
        let unknown = read(&format!("x\n1\n{CELL}Q O\n1 1\nD\n0 0 0\n0 0 0\n")).expect("a crystal");
        assert_eq!((&unknown.elements[..], unknown.unknown["Q"]), (&[0, 8][..], 1));
        let again = read(&format!("x\n1\n{CELL}Fe O Fe\n1 1 2\nD\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n")).expect("a crystal");
        assert_eq!(
            (&again.labels["species"][..], &again.columns[0].values[..], &again.elements[..]),
            (&["Fe".to_owned(), "O".to_owned()][..], &[0.0, 1.0, 0.0, 0.0][..], &[26, 8, 26, 26][..])
        );
    }

    #[test]
    fn errors_are_reported() {
        let body = "Na\n1\nD\n0 0 0\n";
        for (text, message) in [
            (String::new(), "comment: the file ends"),
            (format!("x\nno\n{CELL}{body}"), ":2:1: scale"),
            (format!("x\n1 -1 1\n{CELL}{body}"), ":2:1: scale"),
            (format!("x\n-1\n0 0 0\n0 0 0\n0 0 0\n{body}"), "the cell has no volume"),
            (format!("x\n1\n1 0\n{body}"), ":3:4: cell"),
            (format!("x\n1\n{CELL}Na Cl\n1\nD\n"), ":7:1: counts: 2 species have 1 counts"),
            (format!("x\n1\n{CELL}Na\nx\n"), ":7:1: counts: `x`"),
            (format!("x\n1\n{CELL}Na\n1\nx\n"), ":8:1: Direct or Cartesian"),
            (format!("x\n1\n{CELL}Na\n2\nD\n0 0 0\n"), "position: the file ends"),
            (format!("x\n1\n{CELL}Na\n1\nD\n0 b 0\n"), ":9:3: position: `b`"),
            (format!("x\n1\n{CELL}Na\n1\nD\n0 0 0\n1 1 1\n"), "expected 1 atoms, found 2"),
            (format!("x\n1\n{CELL}Na\n9999999999\nD\n"), "32-bit ids"),
        ] {
            let error = read(&text).map(drop).expect_err(message).to_string();
            assert!(error.contains(message), "{message}: {error}");
        }
    }
}
