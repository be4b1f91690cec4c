//! Macromolecular CIF: the loop of `_atom_site` with its columns in any order, model after model (PDBx/mmCIF
//! dictionary, mmcif.wwpdb.org). Small-molecule CIF, with positions as fractions of the cell, is read too, and its
//! symmetry fills the cell.

mod operators;
mod row;
mod symmetry;
mod tokens;

use super::atom_property::{AtomProperty, NameTable};
use super::frame::{ParticleFrames, Particles};
use super::infer::Inference;
use super::molecule::{Copies, Model, Passed, more_models, not_assembled};
use super::request::Request;
use crate::read::lines::Lines;
use crate::read::source::SceneSource;
use halfline::error::{Error, Place, Result};
use halfline::memory::Ledger;
use halfline::quote::setting::{FRAMES, MODEL};
use halfline::scene::Cell;
use operators::{OperatorItem, Operators};
use row::{AtomColumns, AtomRow};
use tokens::{Token, Tokens};

/// The reader.
pub(in crate::read) struct Mmcif {
    tokens: Tokens,
    request: Request,
    operators: Operators,
    layout: AtomColumns,
    row: AtomRow,
    names: NameTable,
    state: State,
    /// The number of models read or skipped, and the numbers of the skipped ones.
    count: u64,
    passed: Passed,
    /// Whether it was reported that assemblies are not built.
    told: bool,
    /// Whether another data block follows the one with the atoms.
    blocks: bool,
}

/// The reader's state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Before the atoms.
    Before,
    /// Within the atoms: the row holds the first atom of the next model.
    AtomRow,
    /// After the atoms, in the same block.
    Behind,
    End,
}

impl Mmcif {
    pub(in crate::read) fn new(source: SceneSource, request: Request) -> Self {
        Self {
            tokens: Tokens::new(Lines::new(source.reader, &source.path).of_any_bytes()),
            request,
            operators: Operators::default(),
            layout: AtomColumns::default(),
            row: AtomRow::default(),
            names: NameTable::default(),
            state: State::Before,
            count: 0,
            passed: Passed::default(),
            told: false,
            blocks: false,
        }
    }

    /// Moves to the first atom of the first block that has atoms.
    fn seek(&mut self) -> Result<()> {
        loop {
            match self.tokens.next()? {
                Token::End => {
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
                    (self.state, self.blocks) = (State::End, token == Token::Block);
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
                if self.state == State::Before && AtomColumns::is_atom(&tag) {
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
        if self.state == State::Before && tags.first().is_some_and(|tag| AtomColumns::is_atom(tag)) {
            let layout = AtomColumns::of(&tags, &self.request);
            // Loops of dictionaries, or of other data about atoms, are ignored.
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
                if let Some(item) = item {
                    self.operators.take(*item, &self.tokens)?;
                }
            }
            if items.is_empty() {
                return Ok(false);
            }
        }
    }

    /// Reads the next row of atoms; false where there is none.
    fn row(&mut self) -> Result<bool> {
        let found = self.row.read(&mut self.tokens, &self.layout, &mut self.names)?;
        self.tokens.found();
        self.state = if found { State::AtomRow } else { State::Behind };
        Ok(true)
    }

    /// Parses the only atom of a file that writes it as single values.
    fn single(&mut self, tag: &str) -> Result<bool> {
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
            if token != Token::Tag || !AtomColumns::is_atom(&tag) || tags.len() >= MOST_COLUMNS {
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
        (self.layout, self.state) = (layout.of_one(), State::AtomRow);
        Ok(true)
    }

    /// Reads the atoms of the row's model into `model`, or skips them.
    fn body(&mut self, mut model: Option<&mut Model>) -> Result<()> {
        let number = self.row.model;
        while self.state == State::AtomRow && self.row.model == number {
            if let Some(model) = &mut model {
                self.row.give(model, &self.operators.symmetry)?;
            }
            if self.layout.is_of_one() {
                self.state = State::Behind;
            } else {
                self.row()?;
            }
        }
        self.count += 1;
        Ok(())
    }

    /// Checks that the operators were read if an assembly is selected.
    fn know_operators(&mut self) -> Result<()> {
        if self.request.assembly.is_some() && !self.operators.known() && self.state == State::AtomRow {
            if self.request.model.is_none() && self.count < self.request.frames.last() {
                let problem = "the operators of the assembly come after the atoms of several models";
                let mend = format!("select one model with {MODEL} or {FRAMES}");
                return Err(Error::settings(format!("{}: {problem}", self.tokens.file()), mend));
            }
            while self.state == State::AtomRow {
                self.row()?;
            }
        }
        self.rest()
    }

    /// The cell for fractional positions.
    fn crystal_cell(&self, file: &Place) -> Result<Cell> {
        self.operators.cell().ok_or_else(|| {
            let problem = "positions are fractions of a cell that the file does not give";
            Error::scene(file.clone(), problem, "give _cell_length_a to _cell_angle_gamma")
        })
    }

    fn begin(&mut self) -> Result<bool> {
        if self.state == State::Before {
            self.seek()?;
        }
        Ok(self.state == State::AtomRow)
    }
}

/// The most columns of a loop, and the longest tag in bytes.
const MOST_COLUMNS: usize = 4096;
const LONGEST_TAG: usize = 128;

impl ParticleFrames for Mmcif {
    fn next(&mut self) -> Result<Option<Particles>> {
        let asked = self.request.model;
        let behind = self.state != State::Before;
        while self.begin()? {
            let number = self.row.model;
            if asked.is_some_and(|wanted| wanted != number) {
                self.passed.push(number);
                self.body(None)?;
                continue;
            }
            let mut model = Model::new(&self.request, &self.layout.has(), Inference::new(false));
            if self.layout.is_fractional() {
                model = model.whole();
            }
            self.body(Some(&mut model))?;
            let more = self.state == State::AtomRow;
            self.know_operators()?;
            let file = self.tokens.file();
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
            let said = &mut particles.skipped.assumed;
            if self.blocks {
                said.push("the file has several data blocks and the first with atoms is shown".into());
            }
            if more && self.request.any_model() {
                said.push(more_models(None));
            }
            if assembly.is_none() && !std::mem::replace(&mut self.told, true) {
                said.extend(not_assembled(self.operators.counts()));
            }
            if asked.is_some() {
                self.state = State::End;
            }
            return Ok(Some(particles));
        }
        match asked.filter(|_| !behind) {
            Some(wanted) => Err(self.passed.no_model(wanted, &self.tokens.file())),
            None => Ok(None),
        }
    }

    fn skip(&mut self) -> Result<bool> {
        if self.request.model.is_some() {
            return Ok(self.next()?.is_some());
        }
        let found = self.begin()?;
        if found {
            self.body(None)?;
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests;
