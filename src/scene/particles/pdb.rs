//! Protein Data Bank files: fixed columns, one record a line (wwPDB format 3.3,
//! wwpdb.org/documentation/file-format-content/format33/v3.3.html), and what older and other programs write: short lines,
//! no element columns, serial numbers in hybrid-36 (cci.lbl.gov/hybrid_36), models that END alone divides.

mod biomt;

use super::molecule::{Choice, Kind, Model, Names, cell, more_models, not_assembled};
use super::{Altloc, Cell, Frames, Particles, assembly, guess};
use crate::error::{Error, Result};
use crate::scene::ReadOptions;
use crate::scene::lines::Lines;
use crate::scene::source::Source;
use biomt::Biomt;
use std::io::BufRead;
use std::ops::Range;

/// The reader.
pub(super) struct Pdb {
    lines: Lines<Box<dyn BufRead + Send>>,
    choice: Choice,
    /// Whether the current line is still to be looked at.
    held: bool,
    /// The number of the last model, and whether the one that was asked for is behind.
    number: i64,
    done: bool,
    /// The numbers of models that were passed over.
    passed: Vec<i64>,
    /// As many models as NUMMDL says.
    announced: Option<u64>,
    cell: Option<Cell>,
    biomt: Biomt,
    chains: Names,
    said: Vec<String>,
}

/// What a line is.
enum Record {
    Atom,
    Model,
    /// The end of a model, or of the file.
    End,
    Other,
}

/// The columns of an atom's numbers, from 0.
const SERIAL: Range<usize> = 6..11;
const NAME: Range<usize> = 12..16;
const LOCATION: Range<usize> = 16..17;
const RESIDUE_NAME: Range<usize> = 17..20;
const CHAIN: Range<usize> = 21..22;
const RESIDUE: Range<usize> = 22..26;
/// Chain, number and insertion code.
const RESIDUE_ID: Range<usize> = 21..27;
const X: usize = 30;
const COORDINATE: usize = 8;
const OCCUPANCY: Range<usize> = 54..60;
const BFACTOR: Range<usize> = 60..66;
const SYMBOL: Range<usize> = 76..78;

const HAS: [Kind; 6] = [Kind::Bfactor, Kind::Occupancy, Kind::Residue, Kind::Chain, Kind::Model, Kind::Serial];

/// Models that an error lists.
const LISTED: usize = 16;

impl Pdb {
    pub(super) fn new(source: Source, options: &ReadOptions) -> Self {
        Self {
            lines: Lines::new(source.reader, &source.path).of_any_bytes(),
            choice: Choice::of(options),
            held: false,
            number: 0,
            done: false,
            passed: Vec::new(),
            announced: None,
            cell: None,
            biomt: Biomt::default(),
            chains: Names::default(),
            said: Vec::new(),
        }
    }

    fn advance(&mut self) -> Result<bool> {
        Ok(std::mem::take(&mut self.held) || self.lines.advance()?)
    }

    /// Moves to the beginning of the next model and tells its number.
    fn seek(&mut self) -> Result<Option<i64>> {
        while self.advance()? {
            match record(self.line()) {
                Record::Model => {
                    let written = text(field(self.line(), 10..14)).parse();
                    return Ok(Some(written.unwrap_or(self.number + 1)));
                }
                Record::Atom => {
                    self.held = true;
                    return Ok(Some(self.number + 1));
                }
                Record::End => {}
                Record::Other => self.header()?,
            }
        }
        Ok(None)
    }

    /// Reads the model that begins here into `model`, or passes over it.
    fn body(&mut self, mut model: Option<&mut Model>) -> Result<()> {
        while self.advance()? {
            match (record(self.line()), &mut model) {
                (Record::Atom, Some(model)) => {
                    Self::atom(&self.lines, &self.choice, &mut self.chains, self.number, model)?;
                }
                (Record::Atom, None) => {}
                (Record::End, _) => break,
                (Record::Model, _) => {
                    self.held = true;
                    break;
                }
                (Record::Other, _) => self.header()?,
            }
        }
        Ok(())
    }

    fn line(&self) -> &[u8] {
        self.lines.text().as_bytes()
    }

    /// Takes a record that is of the whole file.
    fn header(&mut self) -> Result<()> {
        let line = self.line();
        if line.starts_with(b"REMARK 350") {
            let taken = self.biomt.take(&self.lines);
            // What is wrong with it matters to those who ask for it.
            return if self.choice.assembly.is_some() { taken } else { Ok(()) };
        }
        if line.starts_with(b"CRYST1") {
            let number = |columns: Range<usize>| number(field(line, columns)).unwrap_or(f64::NAN);
            let lengths = [number(6..15), number(15..24), number(24..33)];
            let angles = [number(33..40), number(40..47), number(47..54)];
            if lengths.iter().chain(&angles).any(|number| number.is_nan()) {
                let place = self.lines.place(6);
                self.said.push(format!("{place}: CRYST1 is no cell of six numbers, so that the file has none"));
            }
            self.cell = cell(lengths, angles);
        } else if line.starts_with(b"NUMMDL") {
            self.announced = text(field(line, 10..14)).parse().ok();
        }
        Ok(())
    }

    /// Takes the atom of the current line.
    fn atom(
        lines: &Lines<Box<dyn BufRead + Send>>,
        choice: &Choice,
        chains: &mut Names,
        model_number: i64,
        model: &mut Model,
    ) -> Result<()> {
        let line = lines.text().as_bytes();
        let location = field(line, LOCATION).trim_ascii();
        let occupancy = || number(field(line, OCCUPANCY)).unwrap_or(1.0);
        let compared = if choice.altloc == Altloc::Highest { occupancy() } else { 1.0 };
        let site = |key: &mut Vec<u8>| {
            key.extend(field(line, NAME));
            key.extend(field(line, RESIDUE_ID));
        };
        if !model.admits(location, compared, site) {
            return Ok(());
        }
        let mut position = [0.0; 3];
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let at = X + k * COORDINATE;
            position[k] = coordinate(lines, at..at + COORDINATE, axis)?;
        }
        let symbol = field(line, SYMBOL).trim_ascii();
        let (mut element, mut name) = (guess::of_symbol(symbol), symbol);
        // Older files have other things there, or nothing.
        if !symbol.iter().any(u8::is_ascii_alphabetic) {
            name = field(line, NAME);
            element = guess::of_columns(name, residue(line));
        }
        let chain = if choice.assembly.is_some() || choice.wants(Kind::Chain) {
            chains.number(match field(line, CHAIN) {
                [] => b" ",
                name => name,
            })
        } else {
            0
        };
        model.push(element, name, position, chain, |kind| match kind {
            Kind::Bfactor => number(field(line, BFACTOR)).unwrap_or(f64::NAN),
            Kind::Occupancy => occupancy(),
            Kind::Residue => hybrid36(field(line, RESIDUE)),
            Kind::Serial => hybrid36(field(line, SERIAL)),
            Kind::Chain => f64::from(chain),
            Kind::Model => model_number as f64,
            Kind::Asym | Kind::Entity | Kind::Copy => 0.0,
        });
        Ok(())
    }

    /// What was chosen and what of it is worth saying.
    fn say(&mut self, particles: &mut Particles) -> Result<()> {
        particles.skipped.assumed.append(&mut self.said);
        if self.choice.any_model() {
            let announced = self.announced.filter(|n| *n > 1);
            if announced.is_some() {
                particles.skipped.assumed.push(more_models(announced));
            } else if self.seek()?.is_some() {
                self.held = true;
                particles.skipped.assumed.push(more_models(None));
            }
        }
        if self.choice.assembly.is_none() {
            particles.skipped.assumed.extend(not_assembled(self.biomt.told()));
        }
        Ok(())
    }

    /// The error for a model that the file does not have.
    fn no_model(&self, wanted: i64) -> Error {
        let mut listed: Vec<String> = self.passed.iter().take(LISTED).map(i64::to_string).collect();
        if self.passed.len() > LISTED {
            listed.push(format!("{} more", self.passed.len() - LISTED));
        }
        let mend = if listed.is_empty() { "it has no atoms".into() } else { format!("it has {}", listed.join(", ")) };
        Error::settings(format!("{}: there is no model {wanted}", self.lines.file()), mend)
    }
}

impl Frames for Pdb {
    fn next(&mut self) -> Result<Option<Particles>> {
        while !self.done {
            let Some(number) = self.seek()? else {
                self.done = true;
                return self.choice.model.map_or(Ok(None), |wanted| Err(self.no_model(wanted)));
            };
            self.number = number;
            if self.choice.model.is_some_and(|wanted| wanted != number) {
                self.passed.push(number);
                self.body(None)?;
                continue;
            }
            self.done = self.choice.model.is_some();
            let mut model = Model::new(&self.choice, &HAS);
            self.body(Some(&mut model))?;
            let file = self.lines.file();
            let assembly = match &self.choice.assembly {
                Some(id) => Some(assembly::find(self.biomt.assemblies(&self.lines)?, id, &file)?),
                None => None,
            };
            let mut particles = model.finish(assembly, &self.chains.list, &file)?;
            // An assembly is not what the crystal repeats.
            particles.cell = self.cell.filter(|_| assembly.is_none());
            self.say(&mut particles)?;
            return Ok(Some(particles));
        }
        Ok(None)
    }

    fn skip(&mut self) -> Result<bool> {
        if self.choice.model.is_some() {
            return Ok(self.next()?.is_some());
        }
        let Some(number) = self.seek()? else { return Ok(false) };
        self.number = number;
        self.body(None)?;
        Ok(true)
    }
}

fn record(line: &[u8]) -> Record {
    match line {
        [b'A', b'T', b'O', b'M', ..] | [b'H', b'E', b'T', b'A', b'T', b'M', ..] => Record::Atom,
        [b'M', b'O', b'D', b'E', b'L', b' ', ..] | b"MODEL" => Record::Model,
        [b'E', b'N', b'D', b'M', b'D', b'L', ..] => Record::End,
        [b'E', b'N', b'D', rest @ ..] if rest.trim_ascii().is_empty() => Record::End,
        _ => Record::Other,
    }
}

/// The bytes of these columns, as far as the line goes.
fn field(line: &[u8], columns: Range<usize>) -> &[u8] {
    line.get(columns.start..columns.end.min(line.len())).unwrap_or_default()
}

/// The residue, where hydrogens and metals may be meant by the same name; that of a HETATM is none of a polymer's.
fn residue(line: &[u8]) -> &[u8] {
    if line.starts_with(b"ATOM") { field(line, RESIDUE_NAME) } else { b"" }
}

fn text(field: &[u8]) -> &str {
    std::str::from_utf8(field).unwrap_or_default().trim()
}

fn number(field: &[u8]) -> Option<f64> {
    text(field).parse().ok()
}

fn coordinate<R: BufRead>(lines: &Lines<R>, columns: Range<usize>, axis: &str) -> Result<f64> {
    let found = field(lines.text().as_bytes(), columns.clone());
    number(found).filter(|x| x.is_finite()).ok_or_else(|| {
        let blanks = found.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        let at = (columns.start + blanks % found.len().max(1)).min(lines.text().len());
        let problem = match found.trim_ascii() {
            [] => format!("columns {} to {} are empty", columns.start + 1, columns.end),
            word => format!("`{}` is no finite number", String::from_utf8_lossy(word)),
        };
        let mend = format!("write {axis} in columns {} to {}, such as -12.345", columns.start + 1, columns.end);
        Error::scene(lines.place(at).named(axis), problem, mend)
    })
}

/// A whole number, in hybrid-36 where decimal digits did not suffice: `A0000` follows 99999, and `a0000` `ZZZZZ`
/// (Grosse-Kunstleve, cci.lbl.gov/hybrid_36). NaN for anything else.
fn hybrid36(field: &[u8]) -> f64 {
    let digits = text(field);
    if let Ok(number) = digits.parse::<i64>() {
        return number as f64;
    }
    let width = digits.len() as u32;
    let (upper, lower) =
        (|c: u8| c.is_ascii_digit() || c.is_ascii_uppercase(), |c: u8| c.is_ascii_digit() || c.is_ascii_lowercase());
    let begins = digits.bytes().next().is_some_and(|c| c.is_ascii_alphabetic());
    let whole = field.len() == digits.len() && (1..=5).contains(&width);
    let value = i64::from_str_radix(digits, 36).ok().filter(|_| begins && whole);
    let Some(value) = value else { return f64::NAN };
    let (tens, power) = (10_i64.pow(width), 36_i64.pow(width - 1));
    if digits.bytes().all(upper) {
        (value - 10 * power + tens) as f64
    } else if digits.bytes().all(lower) {
        (value + 16 * power + tens) as f64
    } else {
        f64::NAN
    }
}

#[cfg(test)]
mod tests;
