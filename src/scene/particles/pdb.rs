//! Protein Data Bank files: fixed columns, one record a line (wwPDB format 3.3,
//! wwpdb.org/documentation/file-format-content/format33/v3.3.html), and what older and other programs write: short lines,
//! no element columns, serial numbers in hybrid-36 (cci.lbl.gov/hybrid_36), models that END alone divides. So are PDBQT and PQR
//! files, whose atoms have other columns at their end.

mod biomt;
mod columns;
mod dialects;

use super::infer::{Inference, Named};
use super::molecule::{Choice, Copies, Kind, Model, Names, Passed, cell, more_models, not_assembled};
use super::{Altloc, Cell, Frames, Particles, assembly};
use crate::error::{Error, Result};
use crate::scene::ReadOptions;
use crate::scene::input::Input;
use crate::scene::lines::Lines;
use crate::scene::source::{Format, Source};
use biomt::Biomt;
use columns::{
    BFACTOR, CHAIN, CHARGE, COORDINATE, LOCATION, NAME, OCCUPANCY, RESIDUE, RESIDUE_ID, RESIDUE_NAME, Record, SERIAL,
    SYMBOL, TYPE, X, coordinate, field, hybrid36, number, record, text,
};
use std::ops::Range;

/// The reader.
pub(super) struct Pdb {
    lines: Lines<Input>,
    dialect: Format,
    choice: Choice,
    /// Whether the current line is still to be looked at.
    held: bool,
    /// The number of the last model, and whether the one that was asked for is behind.
    number: i64,
    done: bool,
    /// The numbers of models that were passed over.
    passed: Passed,
    /// As many models as NUMMDL says.
    announced: Option<u64>,
    cell: Option<Cell>,
    biomt: Biomt,
    chains: Names,
    /// What was met before the atoms.
    said: Vec<String>,
    /// Whether it was said that assemblies are not built.
    told: bool,
}

/// The columns of an atom by format: those of PDB, and in PDBQT a charge behind them.
const HAS: [Kind; 7] =
    [Kind::Bfactor, Kind::Occupancy, Kind::Residue, Kind::Chain, Kind::Model, Kind::Serial, Kind::Charge];
const HAS_PQR: [Kind; 4] = [Kind::Charge, Kind::Residue, Kind::Chain, Kind::Serial];

/// The columns of a file in this format.
fn has(dialect: Format) -> &'static [Kind] {
    match dialect {
        Format::Pqr => &HAS_PQR,
        Format::Pdbqt => &HAS,
        _ => &HAS[..6],
    }
}

impl Pdb {
    pub(super) fn new(source: Source, options: &ReadOptions) -> Self {
        Self {
            lines: Lines::new(source.reader, &source.path).of_any_bytes(),
            dialect: source.format,
            choice: Choice::of(options),
            held: false,
            number: 0,
            done: false,
            passed: Passed::default(),
            announced: None,
            cell: None,
            biomt: Biomt::default(),
            chains: Names::default(),
            said: Vec::new(),
            told: false,
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
                    self.lines.found();
                    let names = self.choice.assembly.is_some() || self.choice.wants(Kind::Chain);
                    let chains = names.then_some(&mut self.chains);
                    match self.dialect {
                        Format::Pqr => dialects::pqr(&self.lines, chains, model)?,
                        dialect => Self::atom(&self.lines, &self.choice, dialect, chains, self.number, model)?,
                    }
                }
                (Record::Atom, None) => self.lines.found(),
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
            let matters = self.choice.assembly.is_some() || matches!(taken, Err(Error::Limits { .. }));
            return if matters { taken } else { Ok(()) };
        }
        if line.starts_with(b"CRYST1") {
            let number = |columns: Range<usize>| number(field(line, columns)).unwrap_or(f64::NAN);
            let lengths = [number(6..15), number(15..24), number(24..33)];
            let angles = [number(33..40), number(40..47), number(47..54)];
            if self.said.is_empty() && lengths.iter().chain(&angles).any(|number| number.is_nan()) {
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
        lines: &Lines<Input>,
        choice: &Choice,
        dialect: Format,
        chains: Option<&mut Names>,
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
        if !model.admits(location, compared, site)? {
            return Ok(());
        }
        let mut position = [0.0; 3];
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let at = X + k * COORDINATE;
            position[k] = coordinate(lines, at..at + COORDINATE, axis)?;
        }
        let atom = Named {
            // Older files have digits there, or nothing.
            symbol: match dialect {
                Format::Pdbqt => dialects::symbol(field(line, TYPE)),
                _ => field(line, SYMBOL),
            },
            name: field(line, NAME),
            residue: field(line, RESIDUE_NAME).trim_ascii(),
            site: field(line, RESIDUE_ID),
        };
        let chain = chains.map_or(Ok(0), |chains| match field(line, CHAIN) {
            [] => chains.number(b" "),
            name => chains.number(name),
        })?;
        model.push(&atom, position, chain, |kind| match kind {
            Kind::Bfactor => number(field(line, BFACTOR)).unwrap_or(f64::NAN),
            Kind::Occupancy => occupancy(),
            Kind::Residue => hybrid36(field(line, RESIDUE)),
            Kind::Serial => hybrid36(field(line, SERIAL)),
            Kind::Chain => f64::from(chain),
            Kind::Model => model_number as f64,
            Kind::Charge => number(field(line, CHARGE)).unwrap_or(f64::NAN),
            Kind::Asym | Kind::Entity | Kind::Copy => 0.0,
        })
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
        if self.choice.assembly.is_none() && !std::mem::replace(&mut self.told, true) {
            particles.skipped.assumed.extend(not_assembled(self.biomt.told()));
        }
        Ok(())
    }
}

impl Frames for Pdb {
    fn next(&mut self) -> Result<Option<Particles>> {
        while !self.done {
            let Some(number) = self.seek()? else {
                self.done = true;
                return self
                    .choice
                    .model
                    .map_or(Ok(None), |wanted| Err(self.passed.no_model(wanted, &self.lines.file())));
            };
            self.number = number;
            if self.choice.model.is_some_and(|wanted| wanted != number) {
                self.passed.push(number);
                self.body(None)?;
                continue;
            }
            self.done = self.choice.model.is_some();
            let mut model = Model::new(&self.choice, has(self.dialect), Inference::new(self.dialect != Format::Pqr));
            self.body(Some(&mut model))?;
            let file = self.lines.file();
            let assembly = match &self.choice.assembly {
                Some(id) => Some(assembly::find(self.biomt.assemblies(&self.lines)?, id, &file)?),
                None => None,
            };
            let copies = assembly.map_or(Copies::None, Copies::Assembly);
            let mut particles = model.finish(copies, &self.chains.list, &file)?;
            // An assembly is not what the crystal repeats.
            particles.cell = self.cell.filter(|_| assembly.is_none());
            if self.choice.wants(Kind::Chain) {
                particles.labels.insert(Kind::Chain.name().into(), self.chains.labels());
            }
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

#[cfg(test)]
mod tests;
