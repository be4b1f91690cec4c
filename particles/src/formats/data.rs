//! LAMMPS data: a header, and sections. Atoms is read, Masses gives elements, and Velocities are columns; described at
//! docs.lammps.org/read_data.html.

mod header;
pub(crate) mod style;

use crate::elements::element;
use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::{Lines, Word, Words};
use crate::particles::frame::{Column, Particles};
use crate::particles::layout::{Layout, is_requested};
use crate::particles::masses;
use crate::particles::request::Request;
use crate::particles::role::Role;
use crate::particles::rows::surplus;
use crate::source::Source;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::{Ledger, check, check_ids, reserve};
use halfline_ground::quote::setting::ATOM_STYLE;
use halfline_ground::quote::{quote, unquoted};
use header::{DataHeader, body};
use std::collections::HashMap;
use style::AtomStyle;

pub(crate) const DATA: FormatRow = FormatRow {
    name: "data",
    about: "LAMMPS data",
    endings: &["lammps"],
    signs: &[Sign::Structure(is_sections), Sign::Lines(is_data)],
    has: &[Has::AnyColumns, Has::AtomStyles],
    open: Open::Frame(read).optional(),
    ..FormatRow::PLAIN
};

/// Reads the sections with atoms, their masses and velocities.
///
/// # Errors
/// [`Error::Scene`] with line and column, [`Error::Io`], [`Error::Limits`].
pub(crate) fn read(source: Source, request: &Request) -> Result<Particles> {
    LammpsData { lines: Lines::new(source.reader, &source.path), request }.read()
}

/// The lines of a LAMMPS data file, and the request that says what is kept of them.
struct LammpsData<'a> {
    lines: Lines<Input>,
    request: &'a Request,
}

/// The meaning of a column of a style.
fn role(name: &str) -> Role {
    match name {
        "x" => Role::Position(0),
        "y" => Role::Position(1),
        "z" => Role::Position(2),
        "diameter" => Role::Diameter,
        _ => Role::Other,
    }
}

/// Lines that begin a section; lines between known sections are skipped.
const SECTIONS: [&str; 3] = ["Atoms", "Masses", "Velocities"];

/// The columns of the section Velocities.
const VELOCITIES: [&str; 3] = ["vx", "vy", "vz"];

/// Bytes per type (besides its name) and per atom number in a map and a list, while the map grows.
const TYPE: usize = 128;
const PLACE: u64 = 80;

/// The content of the sections besides the particles.
#[derive(Default)]
struct SectionData {
    /// Types by name or number in order of first occurrence, and the mass of each.
    types: HashMap<String, usize>,
    masses: Vec<f64>,
    /// The type of every atom.
    of: Vec<u32>,
    /// The number of every atom, where velocities refer to it.
    ids: Vec<i64>,
    atoms: bool,
}

impl LammpsData<'_> {
    fn read(&mut self) -> Result<Particles> {
        let (mut particles, mut found) = (Particles::default(), SectionData::default());
        // The first line is free text.
        let reduced = self.lines.advance()? && self.lines.text().contains("units = lj");
        let head = DataHeader::read(&mut self.lines)?;
        let count = head.atoms.ok_or_else(|| {
            self.lines.fail(
                0,
                "header",
                "the number of atoms is not known",
                "add a line such as `12 atoms` to the header",
            )
        })?;
        let mut there = self.is_section();
        while there || self.next_section()? {
            match self.body() {
                "Masses" => self.masses(head.types, &mut found)?,
                "Velocities" if found.atoms => self.velocities(count, &found, &mut particles)?,
                "Velocities" => {
                    let mend = "put the section Atoms before Velocities";
                    return Err(self.lines.fail(0, "Velocities", "the section Velocities comes before Atoms", mend));
                }
                _ if found.atoms => {
                    return Err(self.lines.fail(0, "Atoms", "the section Atoms occurs twice", "remove one of them"));
                }
                _ => particles = self.atoms(count, &head, &mut found)?,
            }
            // The line after the rows was read already.
            there = self.is_section();
        }
        if !found.atoms && count > 0 {
            let problem = format!("the section Atoms is missing, but the header has {count} atoms");
            return Err(Error::scene(self.lines.file().named("Atoms"), problem, "add the section Atoms"));
        }
        particles.cell = head.cell();
        if !reduced {
            name_elements(&found, &mut particles);
        }
        Ok(particles)
    }

    /// The current line without its comment.
    fn body(&self) -> &str {
        body(&self.lines)
    }

    fn is_section(&self) -> bool {
        SECTIONS.contains(&self.body())
    }

    /// Skips to the next known section.
    fn next_section(&mut self) -> Result<bool> {
        while self.lines.advance()? {
            if self.is_section() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Moves to the next line with content; it is an error if the file ends or a known section begins before it.
    fn need(&mut self, section: &str, read: u64, count: u64) -> Result<()> {
        let mut what = "file";
        while self.lines.advance()? {
            if self.is_section() {
                what = "section";
                break;
            }
            if !self.body().is_empty() {
                return Ok(());
            }
        }
        let problem = format!("the {what} ends after {read} of {count} lines of {section}");
        Err(self.lines.ends(section, problem, "give as many lines as the header says"))
    }

    /// Moves to the next line with content, and checks that it is not a row of the section, which has `count` rows.
    fn check_end(&mut self, section: &str, count: u64) -> Result<()> {
        let (what, number) = if section == "Masses" { ("atom types", 1) } else { ("atoms", 0) };
        let is_number = |word: &str| word.parse::<f64>().is_ok();
        let is_row = |lines: &Lines<Input>| Words::of(lines).nth(number).is_some_and(|word| is_number(word.text));
        while self.lines.advance()? {
            if is_row(&self.lines) {
                return surplus(&mut self.lines, count, what, is_row);
            }
            if !self.body().is_empty() {
                break;
            }
        }
        Ok(())
    }

    fn masses(&mut self, count: u64, found: &mut SectionData) -> Result<()> {
        let mut ledger = Ledger::default();
        for read in 0..count {
            self.need("Masses", read, count)?;
            let mut words = Words::of(&self.lines);
            let name = words.next().map_or_else(String::new, |word| word.text.to_owned());
            let Some(mass) = words.next() else {
                let problem = "expected a type and its mass";
                return Err(self.lines.fail(0, "Masses", problem, "give as many masses as there are atom types"));
            };
            let mass = mass.positive("mass")?;
            ledger.add(TYPE + name.len())?;
            found.types.insert(name, found.masses.len());
            found.masses.push(mass);
        }
        self.check_end("Masses", count)
    }

    fn atoms(&mut self, count: u64, head: &DataHeader, found: &mut SectionData) -> Result<Particles> {
        found.atoms = true;
        check_ids(count)?;
        let named = self.lines.text().split_once('#').map(|(_, style)| style.trim().to_owned()).unwrap_or_default();
        if count == 0 {
            self.check_end("Atoms", 0)?;
            return Ok(Particles::default());
        }
        let (line, heading) = (self.lines.place(0), "Atoms");
        self.need(heading, 0, count)?;
        let given = self.request.atom_style.clone().or_else(|| AtomStyle::of_comment(&named));
        let is_given = given.is_some();
        if !is_given && AtomStyle::is_named_by(&named) {
            let problem =
                format!("{} is no known atom style, so the columns of the atoms are not known", quote(&named));
            let mend = format!(
                "set the style with {ATOM_STYLE}, which takes the columns too (`id type q x y z`), or write one of these behind \
                 `Atoms #`: {}",
                AtomStyle::names()
            );
            return Err(Error::scene(line.named(heading), problem, mend));
        }
        let style = given.map_or_else(|| self.guess(head, &named), Ok)?;
        if is_given && !style.is_open() {
            let (own, found) = (style.columns().count(), self.row().count());
            if found != own && found != own + 3 {
                let problem =
                    format!("the style {style} has {own} columns, or {} with image flags, not {found}", own + 3);
                let mend = format!(
                    "write the style that the rows have behind `Atoms #`, or set it with {ATOM_STYLE}; {style} is {}",
                    style.list()
                );
                return Err(self.lines.fail(0, heading, problem, mend));
            }
        }
        let columns = &self.with_flags(&style);
        let mut layout = Layout::whole(self.request);
        for (n, name) in columns.split(' ').enumerate() {
            let twice = |problem| Error::scene(line.clone().named(heading), problem, "use each column name once");
            // Types may have labels.
            let is_label = name == "type" && self.row().nth(n).is_some_and(|word| word.text.parse::<f64>().is_err());
            layout.add(name, if is_label { Role::Text } else { role(name) }).map_err(twice)?;
        }
        let mut particles = layout.begin();
        if !is_given {
            let comment =
                if named.is_empty() { String::new() } else { format!("{} is no atom style, so ", quote(&named)) };
            particles.skipped.assumed.push(format!(
                "{comment}the atoms are read in the style {style} ({columns}), which has their number of columns; {ATOM_STYLE} sets another"
            ));
        }
        let type_at = columns.split(' ').position(|name| name == "type").unwrap_or(1);
        let moving = VELOCITIES.iter().any(|name| is_requested(&self.request.columns, name));
        for read in 0..count {
            if read > 0 {
                self.need(heading, read, count)?;
            }
            // Its type and its number are stored beside it.
            particles.grow(1, size_of::<u32>() + size_of::<i64>())?;
            layout.row(&mut self.row(), &self.lines, &mut particles)?;
            self.remember(type_at, moving, found)?;
            self.lines.found();
        }
        self.check_end(heading, count)?;
        particles.settle_texts()?;
        Ok(particles)
    }

    /// The columns, with the image flags if they are requested and end the current line.
    fn with_flags(&self, style: &AtomStyle) -> String {
        let columns = style.list();
        let requested = is_requested(&self.request.columns, "ix");
        let more = self.row().skip(style.columns().count()).take(4).map(|word| word.text.parse::<i32>().is_ok());
        let flags = requested && !style.is_open() && more.collect::<Vec<_>>() == [true; 3];
        if flags { format!("{columns} ix iy iz") } else { columns.to_owned() }
    }

    /// The words of the current line before its comment.
    fn row(&self) -> impl Iterator<Item = Word<'_, Input>> + Clone {
        Words::of(&self.lines).take_while(|word| !word.text.starts_with('#'))
    }

    /// Stores the type of the current line's atom, and its number if it will be needed.
    fn remember(&self, type_at: usize, moving: bool, found: &mut SectionData) -> Result<()> {
        for (place, word) in self.row().take(type_at + 1).enumerate() {
            if place == 0 && moving {
                reserve(&mut found.ids, 1)?;
                found.ids.push(word.whole("id")?);
            } else if place == type_at {
                reserve(&mut found.of, 1)?;
                found.of.push(match word.text.parse() {
                    Ok(number) => number,
                    // A label of a type that has a mass; other labels are unknown.
                    Err(_) => found.types.get(word.text).map_or(0, |place| *place as u32 + 1),
                });
            }
        }
        Ok(())
    }

    /// Guesses the style from the atom of the current line.
    fn guess(&self, head: &DataHeader, named: &str) -> Result<AtomStyle> {
        let whole: Vec<bool> = self.row().take(16).map(|word| word.text.parse::<i64>().is_ok()).collect();
        // Three whole numbers after the coordinates are image flags of the cell.
        let flags = if whole.len() >= 8 && whole.ends_with(&[true; 3]) { 3 } else { 0 };
        let style = match whole[..whole.len() - flags] {
            [true, true, _, _, _] => "atomic",
            [true, true, true, _, _, _] => "molecular",
            [true, true, false, _, _, _] => "charge",
            [true, true, true, _, _, _, _] if !head.shaped => "full",
            _ => {
                let comment =
                    if named.is_empty() { String::new() } else { format!(", and {} is no atom style", quote(named)) };
                let problem = format!("the style of atoms with {} columns is not known{comment}", whole.len());
                let mend =
                    format!("set it with {ATOM_STYLE}, or write one of these behind `Atoms #`: {}", AtomStyle::names());
                return Err(self.lines.fail(0, "Atoms", problem, mend));
            }
        };
        style.parse()
    }

    fn velocities(&mut self, count: u64, found: &SectionData, particles: &mut Particles) -> Result<()> {
        particles.has.extend(VELOCITIES.map(str::to_owned));
        if found.ids.is_empty() {
            // No velocities are requested, so the section is skipped.
            return self.lines.advance().map(drop);
        }
        let axes: Vec<usize> = (0..3).filter(|k| is_requested(&self.request.columns, VELOCITIES[*k])).collect();
        let atoms = found.ids.len() as u64;
        check(8 * atoms * axes.len() as u64, || format!("the velocities of {atoms} atoms"))?;
        let mut columns = vec![vec![f64::NAN; found.ids.len()]; axes.len()];
        let mut places = HashMap::new();
        for read in 0..count {
            self.need("Velocities", read, count)?;
            let mut words = self.row();
            let id = words.next().map(|word| word.whole("id")).transpose()?.unwrap_or(0);
            let mut atom = Some(read as usize).filter(|atom| found.ids[*atom] == id);
            if atom.is_none() {
                // Only if they are not in the order of the atoms.
                if places.is_empty() {
                    check(PLACE * atoms, || format!("the numbers of {atoms} atoms"))?;
                    places.extend(found.ids.iter().enumerate().map(|(atom, id)| (*id, atom)));
                }
                atom = places.get(&id).copied();
            }
            let Some(atom) = atom else {
                let problem = format!("no atom has the number {id}");
                return Err(self.lines.fail(0, "Velocities", problem, "use the number of an atom"));
            };
            let mut velocity = [f64::NAN; 3];
            for (component, name) in velocity.iter_mut().zip(VELOCITIES) {
                let Some(word) = words.next() else {
                    return Err(self.lines.ends(name, "the line ends before it", "give a number and three components"));
                };
                *component = word.number(name)?;
            }
            for (column, axis) in columns.iter_mut().zip(&axes) {
                column[atom] = velocity[*axis];
            }
        }
        self.check_end("Velocities", count)?;
        let named = axes.iter().zip(columns);
        particles.columns.extend(named.map(|(k, values)| Column { name: VELOCITIES[*k].into(), values }));
        Ok(())
    }
}

/// Finds elements by the masses of the types, where those look like atomic masses.
fn name_elements(found: &SectionData, particles: &mut Particles) {
    let Some(numbers) = masses::elements(&found.masses) else { return };
    let mut by_type: Vec<(&String, u8)> = found.types.iter().map(|(name, place)| (name, numbers[*place])).collect();
    by_type.sort_by_key(|(name, _)| found.types[*name]);
    let symbol = |number: u8| element(number).map_or("?", |element| element.symbol);
    let assignments: Vec<_> =
        by_type.iter().take(32).map(|(name, number)| format!("{} {}", unquoted(name), symbol(*number))).collect();
    particles
        .skipped
        .assumed
        .push(format!("elements are taken from the masses of the types: {}", assignments.join(", ")));
    // Types are numbered from 1, independent of the order of their masses; labels were given the index of their mass.
    let labels = by_type.iter().any(|(name, _)| name.parse::<u32>().is_err());
    let place = |of: u32| match labels {
        true => (of as usize).checked_sub(1),
        false => found.types.get(&of.to_string()).copied(),
    };
    let most = found.of.iter().copied().max().unwrap_or(0).min(1 << 16);
    let table: Vec<u8> = (0..=most).map(|of| place(of).and_then(|k| numbers.get(k)).copied().unwrap_or(0)).collect();
    particles.elements = found.of.iter().map(|of| table.get(*of as usize).copied().unwrap_or(0)).collect();
}

/// A title, and soon after it `N atoms`.
fn is_data(lines: &[&str]) -> bool {
    lines.iter().skip(1).take(32).any(|line| {
        let mut words = line.split_whitespace();
        words.next().is_some_and(|n| n.parse::<u64>().is_ok()) && words.next() == Some("atoms")
    })
}

/// The same, with another line of the header or a section.
fn is_sections(lines: &[&str]) -> bool {
    let is_known = |line: &&str| {
        let words: Vec<&str> = line.split_whitespace().take(4).collect();
        matches!(
            words[..],
            [_, "atom", "types", ..] | [_, _, "xlo", "xhi"] | [_, _, _, "avec"] | ["Atoms" | "Masses", ..]
        )
    };
    is_data(lines) && lines.iter().skip(1).any(is_known)
}

#[cfg(test)]
mod tests;
