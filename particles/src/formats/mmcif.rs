//! Macromolecular CIF, in text and in BinaryCIF: the loop of `_atom_site` with its columns in any order, model after model (PDBx/mmCIF
//! dictionary, mmcif.wwpdb.org). Small-molecule CIF, with positions as fractions of the cell, is read too, and its
//! symmetry fills the cell. Of a file without such atoms, the first chemical component with positions is read, as the
//! dictionaries of the PDB and of CCP4 write them (`_chem_comp_atom`).

mod binary;
mod operators;
mod row;
mod signs;
mod symmetry;
mod text;
mod token;
mod tokens;

use crate::format::{FormatRow, Has, Open, Sign};
use crate::particles::atom_property::{AtomProperty, NameTable};
use crate::particles::frame::{ParticleFrames, Particles};
use crate::particles::infer::Inference;
use crate::particles::molecule::{Copies, Model, Passed, more_models, not_assembled};
use crate::particles::request::Request;
use crate::source::Source;
use halfline_ground::Cell;
use halfline_ground::error::{Error, Place, Result};
use halfline_ground::memory::Ledger;
use operators::{OperatorItem, Operators};
use row::{AtomColumns, AtomRow};
use signs::{is_binary_cif, is_mmcif};
use std::collections::{HashMap, VecDeque};
use token::Token;
use tokens::Tokens;

pub(crate) const CIF: FormatRow = FormatRow {
    name: "cif",
    about: "macromolecular CIF, in text or binary",
    endings: &["mmcif", "bcif"],
    signs: &[Sign::Bytes(is_binary_cif), Sign::Structure(is_mmcif)],
    has: &[Has::Molecules, Has::Serials, Has::Assemblies, Has::Models, Has::AlternateLocations, Has::Symmetry],
    open: Open::Frames(|source, request, _| Ok(Box::new(Mmcif::new(source, request)))).optional(),
    ..FormatRow::PLAIN
};

/// The reader.
pub(crate) struct Mmcif {
    tokens: Tokens,
    request: Request,
    operators: Operators,
    layout: AtomColumns,
    row: AtomRow,
    names: NameTable,
    state: State,
    /// The models of the block, once its atoms were read, by their numbers in the order of their first atoms; those that are not
    /// selected have none.
    models: VecDeque<(i64, Option<Model>)>,
    /// The number of the last model that was taken.
    taken: i64,
    /// The numbers of skipped models.
    passed: Passed,
    /// Whether it was reported that assemblies are not built.
    has_reported: bool,
    /// Whether another data block follows the one with the atoms.
    blocks: bool,
    /// The columns and the atoms of the first component.
    component: Option<(AtomColumns, Vec<AtomRow>)>,
    ledger: Ledger,
    /// Its rows, where the file has no other atoms.
    rows: Option<std::vec::IntoIter<AtomRow>>,
}

/// The reader's state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Before the atoms.
    Before,
    /// Within the atoms: the row holds an atom.
    AtomRow,
    /// After the atoms, in the same block.
    Behind,
    End,
}

impl Mmcif {
    pub(crate) fn new(source: Source, request: Request) -> Self {
        Self {
            tokens: Tokens::new(source, |tag| {
                AtomColumns::is_atom(tag) || AtomColumns::is_component(tag) || OperatorItem::of(tag).is_some()
            }),
            request,
            operators: Operators::default(),
            layout: AtomColumns::default(),
            row: AtomRow::default(),
            names: NameTable::default(),
            state: State::Before,
            models: VecDeque::new(),
            taken: 0,
            passed: Passed::default(),
            has_reported: false,
            blocks: false,
            component: None,
            ledger: Ledger::default(),
            rows: None,
        }
    }

    /// Moves to the first atom of the first block that has atoms.
    fn seek(&mut self) -> Result<()> {
        loop {
            match self.tokens.next()? {
                Token::End => {
                    if let Some((layout, rows)) = self.component.take() {
                        (self.layout, self.rows) = (layout, Some(rows.into_iter()));
                        return self.row().map(drop);
                    }
                    let problem = "the file has no atoms (no values of _atom_site with Cartn_x, Cartn_y, Cartn_z)";
                    return Err(Error::scene(self.tokens.file(), problem, "use a file with coordinates"));
                }
                Token::Block => self.operators = Operators::default(),
                token => {
                    if self.item(token)? {
                        return Ok(());
                    }
                }
            }
        }
    }

    /// Reads the rest of the block after the atoms.
    fn rest(&mut self) -> Result<()> {
        while self.state == State::Behind {
            match self.tokens.next()? {
                token @ (Token::End | Token::Block) => {
                    let more = token == Token::Block || self.rows.is_some() && self.blocks;
                    (self.state, self.blocks) = (State::End, more);
                }
                token => {
                    self.item(token)?;
                }
            }
        }
        Ok(())
    }

    /// Parses a value or a loop; returns true if it contains atoms, with the first of them in the row.
    fn item(&mut self, token: Token) -> Result<bool> {
        match token {
            Token::Loop => self.a_loop(),
            Token::Tag => {
                let tag = self.tag();
                if self.state == State::Before && (AtomColumns::is_atom(&tag) || AtomColumns::is_component(&tag)) {
                    return self.single(&tag);
                }
                let item = OperatorItem::of(&tag);
                match self.tokens.next()? {
                    Token::Value => {}
                    // A tag without a value is ignored.
                    other => {
                        self.tokens.give_back(other);
                        return Ok(false);
                    }
                }
                if let Some(item) = item {
                    self.operators.begin(item, true, self.tokens.spot())?;
                    self.operators.take(item, &self.tokens)?;
                }
                Ok(false)
            }
            _ => Ok(false),
        }
    }

    /// The current word as a tag in lower case, cut to the length of the longest known tag.
    fn tag(&self) -> String {
        let word = self.tokens.word();
        String::from_utf8_lossy(&word[..word.len().min(LONGEST_TAG)]).to_ascii_lowercase()
    }

    /// Parses a loop: its tags, then either the first row of atoms or all rows of a known category.
    fn a_loop(&mut self) -> Result<bool> {
        let mut tags = Vec::new();
        let after = loop {
            match self.tokens.next()? {
                Token::Tag if tags.len() < MOST_COLUMNS => tags.push(self.tag()),
                Token::Tag => {
                    let problem = format!("the loop has more than {MOST_COLUMNS} columns");
                    return Err(Error::scene(self.tokens.place(), problem, "use fewer columns"));
                }
                token => break token,
            }
        };
        self.tokens.give_back(after);
        let is_component = tags.first().is_some_and(|tag| AtomColumns::is_component(tag));
        if self.state == State::Before && (is_component || tags.first().is_some_and(|tag| AtomColumns::is_atom(tag))) {
            let layout = AtomColumns::of(&tags, &self.request);
            // Loops of dictionaries, or of other data about atoms, are ignored.
            if layout.is_placed() && is_component {
                let mut rows = Vec::new();
                while self.row.read(&mut self.tokens, &layout, &mut self.names)? {
                    self.ledger.add(2 * size_of::<AtomRow>())?;
                    rows.push(self.row.clone());
                }
                return self.keep(layout, rows).map(|()| false);
            }
            if layout.is_placed() {
                self.layout = layout;
                return self.row();
            }
        }
        let items: Vec<Option<OperatorItem>> = tags.iter().map(|tag| OperatorItem::of(tag)).collect();
        let first = items.iter().flatten().next().copied();
        loop {
            for (k, item) in items.iter().enumerate() {
                match self.tokens.next()? {
                    Token::Value => {}
                    token => {
                        self.tokens.give_back(token);
                        return Ok(false);
                    }
                }
                if let (Some(first), 0) = (first, k) {
                    self.operators.begin(first, false, self.tokens.spot())?;
                }
                if first.is_some() && k + 1 < items.len() {
                    self.tokens.check_quote()?;
                }
                if let Some(item) = item {
                    self.operators.take(*item, &self.tokens)?;
                }
            }
            if items.is_empty() {
                return Ok(false);
            }
        }
    }

    /// Keeps the atoms of the first component, for a file without other atoms. Its idealised positions are taken where the first
    /// atom has no other.
    fn keep(&mut self, mut layout: AtomColumns, rows: Vec<AtomRow>) -> Result<()> {
        if self.component.is_some() {
            self.blocks = true;
        } else if let Some(first) = rows.first() {
            self.tokens.found();
            if !first.is_placed(&layout, || self.tokens.file())? {
                layout.idealise();
            }
            self.component = Some((layout, rows));
        }
        Ok(())
    }

    /// Reads the next row of atoms; false where there is none.
    fn row(&mut self) -> Result<bool> {
        let found = match &mut self.rows {
            Some(rows) => rows.next().map(|row| self.row = row).is_some(),
            None => self.row.read(&mut self.tokens, &self.layout, &mut self.names)?,
        };
        self.tokens.found();
        self.state = if found { State::AtomRow } else { State::Behind };
        Ok(true)
    }

    /// Parses the only atom of a file that writes it as single values.
    fn single(&mut self, tag: &str) -> Result<bool> {
        let is_component = AtomColumns::is_component(tag);
        let is_same = |tag: &str| if is_component { AtomColumns::is_component(tag) } else { AtomColumns::is_atom(tag) };
        let mut tags = vec![tag.to_owned()];
        let (mut values, mut ledger) = (Vec::new(), Ledger::default());
        loop {
            match self.tokens.next()? {
                Token::Value => {
                    ledger.add(self.tokens.value().len())?;
                    values.push((self.tokens.value().to_vec(), self.tokens.spot()));
                }
                token => {
                    self.tokens.give_back(token);
                    tags.pop();
                    break;
                }
            }
            let token = self.tokens.next()?;
            let tag = self.tag();
            if token != Token::Tag || !is_same(&tag) || tags.len() >= MOST_COLUMNS {
                self.tokens.give_back(token);
                break;
            }
            tags.push(tag);
        }
        let layout = AtomColumns::of(&tags, &self.request);
        if !layout.is_placed() {
            return Ok(false);
        }
        let file = self.tokens.file();
        self.row.single(&layout, &values, &mut self.names, &file)?;
        if is_component {
            let rows = vec![self.row.clone()];
            return self.keep(layout, rows).map(|()| false);
        }
        (self.layout, self.state) = (layout.of_one(), State::AtomRow);
        Ok(true)
    }

    /// Reads all atoms: the rows of a model need not follow each other.
    fn body(&mut self) -> Result<()> {
        let (mut at, mut places) = (0, HashMap::new());
        while self.state == State::AtomRow {
            let number = self.row.model;
            if self.models.get(at).is_none_or(|(known, _)| *known != number) {
                at = *places.entry(number).or_insert(self.models.len());
            }
            if at == self.models.len() {
                self.ledger.add(MODEL)?;
                let model = self.selects(number, at).then(|| {
                    let model = Model::new(&self.request, &self.layout.has(), Inference::new(false));
                    if self.layout.is_fractional() { model.whole() } else { model }
                });
                self.models.push_back((number, model));
            }
            if let Some((_, Some(model))) = self.models.get_mut(at) {
                if self.row.is_placed(&self.layout, || self.tokens.file())? {
                    self.row.give(model, &self.layout, &self.operators.symmetry)?;
                } else {
                    model.unplaced(self.request.strict, || self.tokens.place())?;
                }
            }
            if self.layout.is_of_one() {
                self.state = State::Behind;
            } else {
                self.row()?;
            }
        }
        self.rest()
    }

    /// Whether the model with this number, the one at this place of the file from 0, is kept.
    fn selects(&self, number: i64, at: usize) -> bool {
        match self.request.model {
            Some(requested) => requested == number,
            None => (at as u64) < self.request.frames.last(),
        }
    }

    /// The cell for fractional positions.
    fn crystal_cell(&self, file: &Place) -> Result<Cell> {
        self.operators.cell().ok_or_else(|| {
            let problem = "positions are fractions of a cell that the file does not give";
            Error::scene(file.clone(), problem, "give _cell_length_a to _cell_angle_gamma")
        })
    }

    /// Reads the file, if it was not read yet, and takes its next model.
    fn take(&mut self) -> Result<Option<Option<Model>>> {
        if self.state == State::Before {
            self.seek()?;
            self.body()?;
        }
        let Some((number, model)) = self.models.pop_front() else { return Ok(None) };
        self.taken = number;
        Ok(Some(model))
    }
}

/// The most columns of a loop, and the longest tag in bytes.
const MOST_COLUMNS: usize = 4096;
const LONGEST_TAG: usize = 128;

/// Bytes of a model besides its atoms, in a list and in a map of their numbers.
const MODEL: usize = 2 * size_of::<Model>() + 64;

impl ParticleFrames for Mmcif {
    fn next(&mut self) -> Result<Option<Particles>> {
        let requested = self.request.model;
        let behind = self.state != State::Before;
        while let Some(model) = self.take()? {
            let Some(model) = model else {
                self.passed.push(self.taken);
                continue;
            };
            let more = !self.models.is_empty();
            let file = self.tokens.file();
            model.check_placed(&file)?;
            let assembly = match &self.request.assembly {
                Some(id) => Some(self.operators.assembly(id, &file)?),
                None => None,
            };
            let crystal = if self.layout.is_fractional() { Some(self.crystal_cell(&file)?) } else { None };
            let copies = match (&assembly, &crystal) {
                (Some(assembly), _) => Copies::Assembly(assembly),
                (None, Some(cell)) => Copies::Made(&|listed| {
                    self.operators.symmetry.fill(listed, cell, !self.request.as_listed, &file, &self.request.watch)
                }),
                (None, None) => Copies::None,
            };
            let mut particles = model.finish(copies, self.names.list(AtomProperty::Asym), &file)?;
            // An assembly is not periodic.
            particles.cell = self.operators.cell().filter(|_| assembly.is_none());
            self.names.label(&mut particles);
            let warnings = &mut particles.skipped.assumed;
            warnings.extend(self.operators.assumed_angles().filter(|_| particles.cell.is_some()));
            warnings.extend(self.tokens.quote_warning());
            if self.layout.is_of_component() {
                let which = if self.layout.is_ideal() { "idealised positions" } else { "positions" };
                warnings.push(format!("the file is of a chemical component, whose {which} are shown"));
            }
            if self.blocks {
                warnings.push("the file has several data blocks and the first with atoms is shown".into());
            }
            if more && self.request.any_model() {
                warnings.push(more_models(None));
            }
            if assembly.is_none() && !std::mem::replace(&mut self.has_reported, true) {
                warnings.extend(not_assembled(self.operators.counts()));
            }
            if requested.is_some() {
                self.models.clear();
            }
            return Ok(Some(particles));
        }
        match requested.filter(|_| !behind) {
            Some(number) => Err(self.passed.no_model(number, &self.tokens.file())),
            None => Ok(None),
        }
    }

    fn skip(&mut self) -> Result<bool> {
        if self.request.model.is_some() {
            return Ok(self.next()?.is_some());
        }
        Ok(self.take()?.is_some())
    }
}

#[cfg(test)]
mod tests;
