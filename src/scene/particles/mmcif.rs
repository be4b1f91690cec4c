//! Macromolecular CIF: the loop of `_atom_site`, its columns in any order, model after model (PDBx/mmCIF dictionary,
//! mmcif.wwpdb.org). Small-molecule CIF, whose places are fractions of the cell, is read too, and its symmetry fills the cell.

mod operators;
mod row;
mod symmetry;
mod tokens;

use super::infer::Inference;
use super::molecule::{Choice, Copies, Kind, Model, Names, Passed, more_models, not_assembled};
use super::{Cell, Frames, Particles};
use crate::error::{Error, Place, Result};
use crate::memory::Ledger;
use crate::scene::ReadOptions;
use crate::scene::lines::Lines;
use crate::scene::source::Source;
use operators::{Item, Operators};
use row::{Layout, Row};
use tokens::{Token, Tokens};

/// The reader.
pub(super) struct Mmcif {
    tokens: Tokens,
    choice: Choice,
    operators: Operators,
    layout: Layout,
    row: Row,
    names: RowNames,
    state: State,
    /// Models that are behind, kept or not, and the numbers of those that were not asked for.
    count: u64,
    passed: Passed,
    /// Whether it was said that assemblies are not built.
    told: bool,
    /// Whether another data block follows that of the atoms.
    blocks: bool,
}

/// Names of chains and the like, numbered.
#[derive(Debug, Default)]
struct RowNames {
    chains: Names,
    asyms: Names,
    entities: Names,
}

/// Where in the file the reader is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// Before the atoms.
    Before,
    /// Within them: the row holds the first atom of the next model.
    Row,
    /// Behind them, in the same block.
    Behind,
    End,
}

impl Mmcif {
    pub(super) fn new(source: Source, options: &ReadOptions) -> Self {
        Self {
            tokens: Tokens::new(Lines::new(source.reader, &source.path).of_any_bytes()),
            choice: Choice::of(options),
            operators: Operators::default(),
            layout: Layout::default(),
            row: Row::default(),
            names: RowNames::default(),
            state: State::Before,
            count: 0,
            passed: Passed::default(),
            told: false,
            blocks: false,
        }
    }

    /// Moves to the first atom of the first block that has one.
    fn seek(&mut self) -> Result<()> {
        loop {
            match self.tokens.next()? {
                Token::End => {
                    let problem = "there are no atoms: no values of _atom_site with Cartn_x, Cartn_y, Cartn_z";
                    return Err(Error::scene(self.tokens.file(), problem, "give a file of coordinates"));
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

    /// Reads what is left of the block behind the atoms.
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

    /// Takes a value or a loop; true if these are atoms and the first of them is in the row.
    fn item(&mut self, token: Token) -> Result<bool> {
        match token {
            Token::Loop => self.a_loop(),
            Token::Tag => {
                let tag = self.tag();
                if self.state == State::Before && Layout::is_atom(&tag) {
                    return self.single(&tag);
                }
                let item = Item::of(&tag);
                match self.tokens.next()? {
                    Token::Value => {}
                    // A tag without its value is no reason to stop.
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

    /// The current word as a tag in lower case. No tag that is known is longer than what is kept of it.
    fn tag(&self) -> String {
        let word = self.tokens.word();
        String::from_utf8_lossy(&word[..word.len().min(LONGEST_TAG)]).to_ascii_lowercase()
    }

    /// Takes a loop: its tags, then either the first row of atoms or all rows of what is kept.
    fn a_loop(&mut self) -> Result<bool> {
        let mut tags = Vec::new();
        let after = loop {
            match self.tokens.next()? {
                Token::Tag if tags.len() < MOST_COLUMNS => tags.push(self.tag()),
                Token::Tag => {
                    let problem = format!("a loop of more than {MOST_COLUMNS} columns");
                    return Err(Error::scene(self.tokens.place(), problem, "give fewer"));
                }
                token => break token,
            }
        };
        self.tokens.give_back(after);
        if self.state == State::Before && tags.first().is_some_and(|tag| Layout::is_atom(tag)) {
            let layout = Layout::of(&tags, &self.choice);
            // A dictionary's or a file's loop of something else about atoms.
            if layout.is_placed() {
                self.layout = layout;
                return self.row();
            }
        }
        let items: Vec<Option<Item>> = tags.iter().map(|tag| Item::of(tag)).collect();
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
        self.state = if found { State::Row } else { State::Behind };
        Ok(true)
    }

    /// Takes the one atom of a file that writes it as single values.
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
            if token != Token::Tag || !Layout::is_atom(&tag) || tags.len() >= MOST_COLUMNS {
                self.tokens.give_back(token);
                break;
            }
            tags.push(tag);
        }
        let layout = Layout::of(&tags, &self.choice);
        if !layout.is_placed() {
            return Ok(false);
        }
        let file = self.tokens.file();
        self.row.single(&layout, &values, &mut self.names, &file)?;
        (self.layout, self.state) = (layout.of_one(), State::Row);
        Ok(true)
    }

    /// Reads the atoms of the row's model into `model`, or passes over them.
    fn body(&mut self, mut model: Option<&mut Model>) -> Result<()> {
        let number = self.row.model;
        while self.state == State::Row && self.row.model == number {
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

    /// Makes sure that the operators were read where an assembly is asked for.
    fn know_operators(&mut self) -> Result<()> {
        if self.choice.assembly.is_some() && !self.operators.known() && self.state == State::Row {
            if self.choice.model.is_none() && self.count < self.choice.frames.last() {
                let problem = "the assembly's operators stand behind the atoms, which are of several models";
                let mend = "ask for one model with --model, or for one of --frames";
                return Err(Error::settings(format!("{}: {problem}", self.tokens.file()), mend));
            }
            while self.state == State::Row {
                self.row()?;
            }
        }
        self.rest()
    }

    /// The cell that places are fractions of.
    fn crystal_cell(&self, file: &Place) -> Result<Cell> {
        self.operators.cell().ok_or_else(|| {
            let problem = "places are fractions of a cell that the file does not give";
            Error::scene(file.clone(), problem, "give _cell_length_a to _cell_angle_gamma")
        })
    }

    fn begin(&mut self) -> Result<bool> {
        if self.state == State::Before {
            self.seek()?;
        }
        Ok(self.state == State::Row)
    }
}

/// More columns than any loop has, and bytes of a tag.
const MOST_COLUMNS: usize = 4096;
const LONGEST_TAG: usize = 128;

impl Frames for Mmcif {
    fn next(&mut self) -> Result<Option<Particles>> {
        let asked = self.choice.model;
        let behind = self.state != State::Before;
        while self.begin()? {
            let number = self.row.model;
            if asked.is_some_and(|wanted| wanted != number) {
                self.passed.push(number);
                self.body(None)?;
                continue;
            }
            let mut model = Model::new(&self.choice, &self.layout.has(), Inference::new(false));
            self.body(Some(&mut model))?;
            let more = self.state == State::Row;
            self.know_operators()?;
            let file = self.tokens.file();
            let assembly = match &self.choice.assembly {
                Some(id) => Some(self.operators.assembly(id, &file)?),
                None => None,
            };
            let crystal = if self.layout.is_fractional() { Some(self.crystal_cell(&file)?) } else { None };
            let copies = match (&assembly, &crystal) {
                (Some(assembly), _) => Copies::Assembly(assembly),
                (None, Some(cell)) => Copies::Made(&|listed| {
                    self.operators.symmetry.fill(listed, cell, !self.choice.as_listed, &file, &self.choice.watch)
                }),
                (None, None) => Copies::None,
            };
            let mut particles = model.finish(copies, &self.names.asyms.list, &file)?;
            // An assembly is not what the crystal repeats.
            particles.cell = self.operators.cell().filter(|_| assembly.is_none());
            let names = &self.names;
            let named = [(Kind::Chain, &names.chains), (Kind::Asym, &names.asyms), (Kind::Entity, &names.entities)];
            for (kind, names) in named.into_iter().filter(|(kind, _)| self.choice.wants(*kind)) {
                particles.labels.insert(kind.name().into(), names.labels());
            }
            let said = &mut particles.skipped.assumed;
            if self.blocks {
                said.push("the file has several data blocks and the first with atoms is shown".into());
            }
            if more && self.choice.any_model() {
                said.push(more_models(None));
            }
            if assembly.is_none() && !std::mem::replace(&mut self.told, true) {
                said.extend(not_assembled(self.operators.told()));
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
        if self.choice.model.is_some() {
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
