//! Protein Data Bank files: fixed columns, one record per line (wwPDB format 3.3,
//! wwpdb.org/documentation/file-format-content/format33/v3.3.html), and variants of older files and other programs:
//! short lines, no element columns, serial numbers in hybrid-36 (cci.lbl.gov/hybrid_36), models that are separated by
//! END only. PDBQT and PQR files are read too; their atoms have different last columns.

mod biomt;
mod columns;
mod dialects;
mod signs;

use crate::format::{FormatRow, Has, Open, Sign};
use crate::input::Input;
use crate::lines::Lines;
use crate::particles::assembly;
use crate::particles::atom_property::{AtomProperty, NameTable};
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::infer::{AtomNames, Inference};
use crate::particles::molecule::{Copies, Model, Passed, cell, more_models, not_assembled};
use crate::particles::request::{Altloc, Request};
use crate::source::Source;
use biomt::Biomt;
use signs::{doubt, has_types, is_free, is_pdb, is_pdbqt, is_pqr};

pub(crate) const PDB: FormatRow = FormatRow {
    name: "pdb",
    about: "Protein Data Bank",
    endings: &["ent"],
    signs: &[Sign::Lines(|lines| is_pdb(lines) && !is_pqr(lines) && !is_pdbqt(lines))],
    fits: Some(|lines| is_pdb(lines) && !is_free(lines) && !has_types(lines)),
    has: &[Has::Molecules, Has::Serials, Has::Assemblies, Has::Models, Has::AlternateLocations],
    open: Open::Frames(|source, request, _| Ok(Box::new(Pdb::new(source, request, Dialect::Pdb)))),
    ..FormatRow::PLAIN
};

pub(crate) const PQR: FormatRow = FormatRow {
    name: "pqr",
    about: "PDB with charges and radii, as written by PDB2PQR",
    signs: &[Sign::Lines(|lines| is_pqr(lines) && !is_pdbqt(lines))],
    fits: Some(|lines| is_pdb(lines) && !is_pdbqt(lines)),
    doubt,
    has: &[Has::Molecules, Has::Serials],
    open: Open::Frames(|source, request, _| Ok(Box::new(Pdb::new(source, request, Dialect::Pqr)))),
    ..FormatRow::PLAIN
};

pub(crate) const PDBQT: FormatRow = FormatRow {
    name: "pdbqt",
    about: "PDB with charges and AutoDock's atom types",
    signs: &[Sign::Lines(is_pdbqt)],
    fits: Some(is_pdb),
    has: &[Has::Molecules, Has::Serials, Has::Models, Has::AlternateLocations],
    open: Open::Frames(|source, request, _| Ok(Box::new(Pdb::new(source, request, Dialect::Pdbqt)))),
    ..FormatRow::PLAIN
};

/// The columns of atoms behind their coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dialect {
    Pdb,
    Pqr,
    Pdbqt,
}

pub(super) use columns::overruns;
use columns::{
    BFACTOR, CHAIN, CHARGE, COORDINATE, ICODE, LOCATION, NAME, OCCUPANCY, PdbRecord, RECORD, RESIDUE, RESIDUE_ID,
    RESIDUE_NAME, SEGMENT, SERIAL, SYMBOL, TYPE, X, coordinate, field, hybrid36, number, record, text,
};
use halfline_ground::Cell;
use halfline_ground::error::{Error, Result};
use std::ops::Range;

/// The reader.
pub(crate) struct Pdb {
    lines: Lines<Input>,
    dialect: Dialect,
    request: Request,
    /// The number of the last model, and whether the selected one was read.
    number: i64,
    done: bool,
    /// The numbers of skipped models.
    passed: Passed,
    /// The number of models in NUMMDL.
    announced: Option<u64>,
    cell: Option<Cell>,
    biomt: Biomt,
    names: NameTable,
    /// Warnings from before the atoms.
    early_warnings: Vec<String>,
    /// Whether it was reported that assemblies are not built.
    assembly_noted: bool,
}

/// The columns of an atom in PDB; in PDBQT a charge takes the place of the segment.
const HAS: [AtomProperty; 13] = {
    use AtomProperty::{
        Altloc, Bfactor, Chain, Charge, Icode, Model, Name, Occupancy, Record, Residue, Resname, Segid, Serial,
    };
    [Segid, Name, Resname, Altloc, Icode, Record, Bfactor, Occupancy, Residue, Chain, Model, Serial, Charge]
};
const HAS_PQR: [AtomProperty; 8] = {
    use AtomProperty::{Chain, Charge, Icode, Name, Record, Residue, Resname, Serial};
    [Name, Resname, Icode, Record, Charge, Residue, Chain, Serial]
};

/// The columns of a file in this format.
fn has(dialect: Dialect) -> &'static [AtomProperty] {
    match dialect {
        Dialect::Pqr => &HAS_PQR,
        Dialect::Pdbqt => &HAS[1..],
        _ => &HAS[..12],
    }
}

impl Pdb {
    fn new(source: Source, request: Request, dialect: Dialect) -> Self {
        Self {
            lines: Lines::new(source.reader, &source.path).of_columns(),
            dialect,
            request,
            number: 0,
            done: false,
            passed: Passed::default(),
            announced: None,
            cell: None,
            biomt: Biomt::default(),
            names: NameTable::default(),
            early_warnings: Vec::new(),
            assembly_noted: false,
        }
    }

    /// Moves to the beginning of the next model and returns its number.
    fn seek(&mut self) -> Result<Option<i64>> {
        while self.lines.advance()? {
            match record(self.line()) {
                PdbRecord::Model => {
                    let written = text(field(self.line(), 10..14)).parse();
                    return Ok(Some(written.unwrap_or(self.number + 1)));
                }
                PdbRecord::Atom => {
                    self.lines.give_back();
                    return Ok(Some(self.number + 1));
                }
                PdbRecord::End => {}
                PdbRecord::Other => self.header()?,
            }
        }
        Ok(None)
    }

    /// Reads the model that begins here into `model`, or skips it.
    fn body(&mut self, mut model: Option<&mut Model>) -> Result<()> {
        while self.lines.advance()? {
            match (record(self.line()), &mut model) {
                (PdbRecord::Atom, Some(model)) => {
                    self.lines.found();
                    let names = &mut self.names;
                    match self.dialect {
                        Dialect::Pqr => dialects::pqr(&self.lines, names, model)?,
                        dialect => Self::atom(&self.lines, &self.request, dialect, names, self.number, model)?,
                    }
                }
                (PdbRecord::Atom, None) => self.lines.found(),
                (PdbRecord::End, _) => break,
                (PdbRecord::Model, _) => {
                    self.lines.give_back();
                    break;
                }
                (PdbRecord::Other, _) => self.header()?,
            }
        }
        Ok(())
    }

    fn line(&self) -> &[u8] {
        self.lines.text().as_bytes()
    }

    /// Parses a record that applies to the whole file.
    fn header(&mut self) -> Result<()> {
        let line = self.line();
        if line.starts_with(b"REMARK 350") {
            let taken = self.biomt.take(&self.lines);
            // Its errors matter only if an assembly is selected.
            let matters = self.request.assembly.is_some() || matches!(taken, Err(Error::Limits { .. }));
            return if matters { taken } else { Ok(()) };
        }
        if line.starts_with(b"CRYST1") {
            let number = |columns: Range<usize>| number(field(line, columns)).unwrap_or(f64::NAN);
            let lengths = [number(6..15), number(15..24), number(24..33)];
            let angles = [number(33..40), number(40..47), number(47..54)];
            if self.early_warnings.is_empty() && lengths.iter().chain(&angles).any(|number| number.is_nan()) {
                let place = self.lines.place(6);
                self.early_warnings
                    .push(format!("{place}: CRYST1 does not have the six numbers of a cell, so the file has no cell"));
            }
            self.cell = cell(lengths, angles);
        } else if line.starts_with(b"NUMMDL") {
            self.announced = text(field(line, 10..14)).parse().ok();
        }
        Ok(())
    }

    /// Parses the atom of the current line.
    fn atom(
        lines: &Lines<Input>,
        request: &Request,
        dialect: Dialect,
        names: &mut NameTable,
        model_number: i64,
        model: &mut Model,
    ) -> Result<()> {
        let line = lines.text().as_bytes();
        let location = field(line, LOCATION).trim_ascii();
        let occupancy = || number(field(line, OCCUPANCY)).unwrap_or(1.0);
        let compared = if request.altloc == Altloc::Highest { occupancy() } else { 1.0 };
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
        let atom = AtomNames {
            // Older files have digits in these columns, or nothing.
            symbol: match dialect {
                Dialect::Pdbqt => dialects::symbol(field(line, TYPE)),
                _ => field(line, SYMBOL),
            },
            name: field(line, NAME),
            residue: field(line, RESIDUE_NAME).trim_ascii(),
            site: field(line, RESIDUE_ID),
        };
        let chain = match field(line, CHAIN) {
            [] => b" ",
            name => name,
        };
        // An assembly refers to chains.
        let unit = if request.assembly.is_some() { names.number(AtomProperty::Chain, chain)? } else { 0.0 };
        model.push(&atom, position, unit as u32, |kind| {
            let mut name = |text: &[u8]| names.number(kind, text.trim_ascii());
            Ok(match kind {
                AtomProperty::Bfactor => number(field(line, BFACTOR)).unwrap_or(f64::NAN),
                AtomProperty::Occupancy => occupancy(),
                AtomProperty::Residue => hybrid36(field(line, RESIDUE)),
                AtomProperty::Serial => hybrid36(field(line, SERIAL)),
                AtomProperty::Model => model_number as f64,
                AtomProperty::Charge => number(field(line, CHARGE)).unwrap_or(f64::NAN),
                AtomProperty::Chain => names.number(kind, chain)?,
                AtomProperty::Name => name(atom.name)?,
                AtomProperty::Resname => name(atom.residue)?,
                AtomProperty::Segid => name(field(line, SEGMENT))?,
                AtomProperty::Altloc => name(location)?,
                AtomProperty::Icode => name(field(line, ICODE))?,
                AtomProperty::Record => name(field(line, RECORD))?,
                _ => 0.0,
            })
        })
    }

    /// Reports the selected model and what else is relevant.
    fn say(&mut self, particles: &mut Particles) -> Result<()> {
        particles.skipped.assumed.append(&mut self.early_warnings);
        if self.request.any_model() {
            let announced = self.announced.filter(|n| *n > 1);
            if announced.is_some() {
                particles.skipped.assumed.push(more_models(announced));
            } else if self.seek()?.is_some() {
                self.lines.give_back();
                particles.skipped.assumed.push(more_models(None));
            }
        }
        if self.request.assembly.is_none() && !std::mem::replace(&mut self.assembly_noted, true) {
            particles.skipped.assumed.extend(not_assembled(self.biomt.counts()));
        }
        Ok(())
    }
}

impl ParticleFrames for Pdb {
    fn next(&mut self) -> Result<Option<Particles>> {
        while !self.done {
            let Some(number) = self.seek()? else {
                self.done = true;
                return self
                    .request
                    .model
                    .map_or(Ok(None), |number| Err(self.passed.no_model(number, &self.lines.file())));
            };
            self.number = number;
            if self.request.model.is_some_and(|requested| requested != number) {
                self.passed.push(number);
                self.body(None)?;
                continue;
            }
            self.done = self.request.model.is_some();
            let mut model = Model::new(&self.request, has(self.dialect), Inference::new(self.dialect != Dialect::Pqr));
            self.body(Some(&mut model))?;
            let file = self.lines.file();
            let assembly = match &self.request.assembly {
                Some(id) => Some(assembly::find(self.biomt.assemblies(&self.lines)?, id, &file)?),
                None => None,
            };
            let copies = assembly.map_or(Copies::None, Copies::Assembly);
            let mut particles = model.finish(copies, self.names.list(AtomProperty::Chain), &file)?;
            // An assembly is not periodic.
            particles.cell = self.cell.filter(|_| assembly.is_none());
            self.names.label(&mut particles);
            self.say(&mut particles)?;
            return Ok(Some(particles));
        }
        Ok(None)
    }

    fn skip(&mut self) -> Result<bool> {
        if self.request.model.is_some() {
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
