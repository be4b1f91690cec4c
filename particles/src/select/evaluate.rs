//! The particles that a selection selects.

use super::columns::{Key, NUMBERS};
use super::expression::{Comparison, Kind, Node, Operation, Value};
use super::ligand::{self, Residue, is_metal};
use super::note::{Note, Unmatched};
use super::selection::Selection;
use super::values::{Range, pattern};
use crate::elements::element;
use crate::near::near;
use crate::nearest::did_you_mean;
use crate::particles::frame::{Column, Particles};
use crate::particles::infer::residues::{ResidueClass, class};
use crate::particles::infer::rules::is_ion;
use crate::particles::residues;
use glob::{MatchOptions, Pattern};
use halfline_ground::error::{Error, Result};
use halfline_ground::parallel;
use halfline_ground::quote::{list, number, quote};
use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A flag for every particle.
pub(super) type Mask = Vec<bool>;

/// Evaluates selections of the particles of a frame.
pub(super) struct Evaluator<'a> {
    particles: &'a Particles,
    selection: &'a Selection,
    /// Whether the part is evaluated for what it does not select, so that nothing is what it may select.
    is_negated: bool,
    /// Words that select nothing, and what the file has instead.
    pub(super) notes: Vec<Note>,
}

/// The values of a column.
enum Data<'a> {
    /// Numbers of names.
    Names(&'a [f64], &'a [String]),
    Elements(&'a [u8]),
    Numbers(Box<dyn Fn(usize) -> f64 + Sync + 'a>),
}

impl<'a> Evaluator<'a> {
    pub(super) fn new(particles: &'a Particles, selection: &'a Selection) -> Self {
        Self { particles, selection, is_negated: false, notes: Vec::new() }
    }

    /// Which particles are selected.
    ///
    /// # Errors
    /// [`Error::Settings`] for a column that the file does not have, or a name where it has numbers; [`Error::Limits`]
    /// where memory is short.
    pub(super) fn mask(&mut self) -> Result<Mask> {
        let selection = self.selection;
        self.node(&selection.root)
    }

    fn len(&self) -> usize {
        self.particles.positions.len()
    }

    fn node(&mut self, node: &Node) -> Result<Mask> {
        match node {
            Node::All => Ok(vec![true; self.len()]),
            Node::None => Ok(vec![false; self.len()]),
            Node::Group(inner) => self.node(inner),
            Node::Not(inner) => {
                self.is_negated = !self.is_negated;
                let mask = self.node(inner);
                self.is_negated = !self.is_negated;
                let mut mask = mask?;
                parallel::each(&mut mask, |_, flag| *flag = !*flag);
                Ok(mask)
            }
            Node::Chain(first, rest) => {
                let mut mask = self.node(first)?;
                for (operation, part) in rest {
                    let other = self.node(part)?;
                    parallel::zip(&mut mask, &other, |flag, other| match operation {
                        Operation::And => *flag &= other,
                        Operation::Or => *flag |= other,
                    });
                }
                Ok(mask)
            }
            Node::Kind(kind) => self.kind(*kind),
            Node::Values(column, values) => self.values(column, values),
            Node::Compare(comparison) => self.compare(comparison),
            Node::Near(part) => {
                let chosen = self.node(&part.of)?;
                let mut mask = near(&self.particles.positions, &chosen, part.reach)?;
                if !part.itself {
                    parallel::zip(&mut mask, &chosen, |flag, chosen| *flag &= !chosen);
                }
                Ok(mask)
            }
            Node::Same(column, inner) => {
                let chosen = self.node(inner)?;
                self.same(column, &chosen)
            }
        }
    }

    fn kind(&mut self, kind: Kind) -> Result<Mask> {
        let mask = match kind {
            Kind::Hydrogen => parallel::map(self.elements("hydrogen")?, |number| *number == 1),
            Kind::Protein => self.residues(|name| class(name) == Some(ResidueClass::Protein))?,
            Kind::Nucleic => self.residues(|name| class(name) == Some(ResidueClass::Nucleic))?,
            Kind::Water => self.residues(|name| class(name) == Some(ResidueClass::Water))?,
            Kind::Ion => self.residues(is_ion)?,
            Kind::Metal => parallel::map(self.elements("metal")?, |number| is_metal(*number)),
            Kind::Ligand => self.ligands()?,
            Kind::Backbone => {
                let mut mask = self.residues(|name| class(name) == Some(ResidueClass::Protein))?;
                let Data::Names(values, names) = self.data("name")? else {
                    return Err(self.missing("name"));
                };
                let backbone = |name: &String| ["N", "CA", "C", "O"].contains(&name.trim());
                let named = flags(values, &names.iter().map(backbone).collect::<Vec<_>>());
                parallel::zip(&mut mask, &named, |flag, named| *flag &= named);
                mask
            }
        };
        if parallel::all(&mask, |flag| !flag) {
            let residues = match self.column("resname").map(|column| self.particles.labels.get(&column.name)) {
                Some(Some(names)) => format!("the residues of the file are {}", listed(names)),
                _ => String::new(),
            };
            self.note(kind.word(), Vec::new(), residues);
        }
        Ok(mask)
    }

    /// The particles in residues whose name in capitals has a property.
    fn residues(&self, is: impl Fn(&[u8]) -> bool) -> Result<Mask> {
        let Data::Names(values, names) = self.data("resname")? else { return Err(self.missing("resname")) };
        let chosen: Vec<bool> = names.iter().map(|name| is(name.trim().to_ascii_uppercase().as_bytes())).collect();
        Ok(flags(values, &chosen))
    }

    /// The particles of ligands; see [`ligand`].
    fn ligands(&self) -> Result<Mask> {
        let Data::Names(values, names) = self.data("resname")? else { return Err(self.missing("resname")) };
        let (elements, numbers) = (self.elements("ligand")?, self.residue_numbers()?);
        let chains = ["chain", "segid"].map(|name| self.column(name));
        let atoms = match self.data("name") {
            Ok(Data::Names(values, names)) => Some((values, names)),
            _ => None,
        };
        let atom =
            |n: usize| atoms.and_then(|(values, names)| names.get(values[n] as usize)).map_or("", |name| name.trim());
        let same_chain = |a: usize, b: usize| {
            chains.iter().flatten().all(|chain| chain.values[a].to_bits() == chain.values[b].to_bits())
        };
        let of: Vec<std::ops::Range<usize>> = ligand::runs(&numbers);
        let residue = |range: &std::ops::Range<usize>| {
            let name = names.get(values[range.start] as usize).map_or("", |name| name.trim());
            Residue { name: name.to_ascii_uppercase(), range: range.clone() }
        };
        let residues: Vec<Residue> = of.iter().map(residue).collect();
        let file =
            ligand::Molecules { positions: &self.particles.positions, elements, atom: &atom, same_chain: &same_chain };
        let mut mask = vec![false; self.len()];
        for range in file.ligands(&residues) {
            mask[range].fill(true);
        }
        Ok(mask)
    }

    fn values(&mut self, word: &str, values: &[Value]) -> Result<Mask> {
        let (data, codes, mut empty) = (self.data(word)?, self.codes(word), Vec::new());
        let mut note = |value: &Value, is_empty: bool| {
            if is_empty {
                empty.push(value.to_string());
            }
        };
        let mask = match &data {
            Data::Names(numbers, names) => {
                let there = occurring(numbers, names.len());
                let chosen = any_of(values, names, &there, MatchOptions::new(), &mut note);
                flags(numbers, &chosen)
            }
            Data::Elements(elements) => {
                let names: Vec<String> = (0..=u8::MAX).map(symbol).collect();
                let mut there = vec![false; names.len()];
                elements.iter().for_each(|number| there[usize::from(*number)] = true);
                let any_case = MatchOptions { case_sensitive: false, ..MatchOptions::new() };
                let chosen = any_of(values, &names, &there, any_case, &mut note);
                parallel::map(elements, |number| chosen[usize::from(*number)])
            }
            Data::Numbers(of) => {
                let mut mask = vec![false; self.len()];
                for value in values {
                    let range = Range::of(value, word, self.selection)?;
                    let is_in = |n: usize| match &codes {
                        Some(code) => range.contains_with_code(of(n), code(n)),
                        None => range.contains(of(n)),
                    };
                    let found = AtomicBool::new(false);
                    parallel::each(&mut mask, |n, flag| {
                        if is_in(n) {
                            *flag = true;
                            found.store(true, Relaxed);
                        }
                    });
                    note(value, !found.load(Relaxed));
                }
                mask
            }
        };
        if !empty.is_empty() {
            let there = self.describe(&data);
            drop(data);
            self.note(word, empty, there);
        }
        Ok(mask)
    }

    /// The insertion codes of residues, where a word means the number of a residue and the file has codes: a number
    /// without a code means the residue without one.
    fn codes(&self, word: &str) -> Option<impl Fn(usize) -> &'a str + use<'a>> {
        let column = self.column("icode").filter(|_| Key::of(word) == Key::Resid)?;
        let names = self.particles.labels.get(&column.name)?;
        Some(|n: usize| names.get(column.values[n] as usize).map_or("", |code| code.trim()))
    }

    fn compare(&mut self, comparison: &Comparison) -> Result<Mask> {
        let Comparison { column, absolute, sign, value } = comparison;
        let fail = |problem: String, mend: &str| {
            Err(Error::settings(format!("selection `{}`: {problem}", self.selection.brief()), mend))
        };
        match (self.data(column)?, value.parse::<f64>()) {
            (Data::Numbers(of), Ok(limit)) => {
                let of = |n: usize| if *absolute { of(n).abs() } else { of(n) };
                Ok(parallel::from_fn(self.len(), |n| sign.holds(of(n), limit)))
            }
            (Data::Numbers(_), Err(_)) => {
                let problem = format!("{column} is a number in this file, and {} is not", quote(value));
                fail(problem, "compare it with a number")
            }
            _ => {
                let mend = format!("write {column} {value} or not {column} {value}");
                fail(format!("{column} has names in this file, which are not compared"), &mend)
            }
        }
    }

    /// The particles that have the value of a chosen one.
    fn same(&self, word: &str, chosen: &[bool]) -> Result<Mask> {
        match Key::of(word) {
            Key::Residue => {
                let residues = self.residue_numbers()?;
                let mut members = vec![false; residues.last().map_or(0, |last| *last as usize + 1)];
                residues.iter().zip(chosen).filter(|(_, flag)| **flag).for_each(|(n, _)| members[*n as usize] = true);
                Ok(parallel::map(&residues, |n| members[*n as usize]))
            }
            _ => {
                let of: Box<dyn Fn(usize) -> f64 + Sync> = match self.data(word)? {
                    Data::Names(values, _) => Box::new(|n| values[n]),
                    Data::Elements(elements) => Box::new(|n| f64::from(elements[n])),
                    Data::Numbers(of) => of,
                };
                // Zeros are equal whatever their sign.
                let bits = |n: usize| (of(n) + 0.0).to_bits();
                let known: HashSet<u64> = (0..self.len()).filter(|n| chosen[*n]).map(bits).collect();
                Ok(parallel::from_fn(self.len(), |n| known.contains(&bits(n))))
            }
        }
    }

    /// The number of each particle's residue in the file's order.
    fn residue_numbers(&self) -> Result<Vec<u32>> {
        let has_numbers = NUMBERS.iter().any(|name| self.column(name).is_some());
        residues::numbers(self.particles).filter(|_| has_numbers).ok_or_else(|| self.missing("residue"))
    }

    fn column(&self, name: &str) -> Option<&'a Column> {
        self.particles.column(name)
    }

    fn elements(&self, word: &str) -> Result<&'a [u8]> {
        if self.particles.elements.is_empty() && self.len() > 0 {
            Err(self.missing(word))
        } else {
            Ok(&self.particles.elements)
        }
    }

    /// The values that a word reads.
    fn data(&self, word: &str) -> Result<Data<'a>> {
        let particles = self.particles;
        let columns = match Key::of(word) {
            Key::Index(first) => {
                let first = f64::from(first);
                return Ok(Data::Numbers(Box::new(move |n| particles.index(n) as f64 + first)));
            }
            Key::Axis(axis) => return Ok(Data::Numbers(Box::new(move |n| particles.positions[n][axis]))),
            Key::Radius if particles.radii.is_empty() => return Err(self.missing(word)),
            Key::Radius => return Ok(Data::Numbers(Box::new(move |n| particles.radii[n]))),
            Key::Element => return self.elements(word).map(Data::Elements),
            Key::Resid | Key::Residue => NUMBERS.iter().map(|name| (*name).to_owned()).collect(),
            Key::Columns(columns) => columns,
            Key::Kind(_) => Vec::new(),
        };
        let column = columns.iter().find_map(|name| self.column(name)).ok_or_else(|| self.missing(word))?;
        Ok(match particles.labels.get(&column.name) {
            Some(names) => Data::Names(&column.values, names),
            None => Data::Numbers(Box::new(|n| column.values[n])),
        })
    }

    fn missing(&self, word: &str) -> Error {
        let problem = format!("selection `{}`: the file has no {word}", self.selection.brief());
        let mut has: Vec<&str> = ["index", "x", "y", "z"].to_vec();
        has.extend((!self.particles.radii.is_empty()).then_some("radius"));
        has.extend((!self.particles.elements.is_empty()).then_some("element"));
        has.extend(
            self.particles.has.iter().map(String::as_str).filter(|name| !["x", "y", "z", "radius"].contains(name)),
        );
        let mend = format!("the file has {}", list(&has));
        Error::settings(problem, did_you_mean(word, has, mend))
    }

    /// The values that the file has, for a message.
    fn describe(&self, data: &Data<'_>) -> String {
        match data {
            Data::Names(_, names) => format!("the file has {}", listed(names)),
            Data::Elements(elements) => {
                let mut there: Vec<u8> = elements.to_vec();
                there.sort_unstable();
                there.dedup();
                let names: Vec<String> = there.into_iter().map(symbol).filter(|name| !name.is_empty()).collect();
                format!("the file has {}", listed(&names))
            }
            Data::Numbers(of) => {
                let numbers = (0..self.len()).map(of).filter(|x| !x.is_nan());
                let [low, high] = numbers.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
                match low <= high {
                    true => format!("the file has {} to {}", brief(low), brief(high)),
                    false => "the file has no numbers there".into(),
                }
            }
        }
    }

    fn note(&mut self, word: &str, values: Vec<String>, there: String) {
        if !self.is_negated {
            let (word, selection) = (word.to_owned(), self.selection.brief().to_string());
            self.notes.push(Note::Unmatched(Unmatched { word, values, selection, there }));
        }
    }
}

/// A number for a message: whole where it is, else with six digits.
fn brief(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() < 1e15 { x.to_string() } else { number(x, 6) }
}

/// The symbol of an atomic number; empty for an unknown element.
fn symbol(number: u8) -> String {
    element(number).map_or_else(String::new, |element| element.symbol.to_owned())
}

/// Which of `names` the values mean; `note` gets for each value whether none of those that are `there` is meant.
fn any_of(
    values: &[Value],
    names: &[String],
    there: &[bool],
    options: MatchOptions,
    note: &mut impl FnMut(&Value, bool),
) -> Vec<bool> {
    let mut chosen = vec![false; names.len()];
    for value in values {
        let (pattern, mut is_empty): (Pattern, bool) = (pattern(value), true);
        for (n, _) in names.iter().enumerate().filter(|(_, name)| pattern.matches_with(name.trim(), options)) {
            chosen[n] = true;
            is_empty &= !there[n];
        }
        note(value, is_empty);
    }
    chosen
}

/// Which of the numbers below `count` occur.
fn occurring(values: &[f64], count: usize) -> Vec<bool> {
    let mut there = vec![false; count];
    for value in values.iter().filter(|value| **value >= 0.0) {
        if let Some(flag) = there.get_mut(*value as usize) {
            *flag = true;
        }
    }
    there
}

/// The flags of particles whose values are numbers of names.
fn flags(values: &[f64], chosen: &[bool]) -> Mask {
    parallel::map(values, |value| *value >= 0.0 && chosen.get(*value as usize).copied().unwrap_or(false))
}

/// Names for a message, without blank ones.
fn listed(names: &[String]) -> String {
    list(names.iter().map(|name| name.trim()).filter(|name| !name.is_empty()))
}
