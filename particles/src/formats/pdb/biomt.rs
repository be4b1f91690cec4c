//! REMARK 350 of a PDB file: biological assemblies, as lists of chains and the operators that are applied to them
//! (wwPDB format 3.3, remark 350).

use crate::lines::{Lines, Words};
use crate::particles::assembly::{Assembly, AssemblyPart};
use halfline_ground::Operator;
use halfline_ground::error::{Error, Result};
use halfline_ground::memory::Ledger;
use halfline_ground::quote::{quote, unquoted};
use std::io::BufRead;

/// The part of the remark that was read.
#[derive(Debug, Default)]
pub(super) struct Biomt {
    assemblies: Vec<Assembly>,
    /// The first of the current lines' assemblies: `BIOMOLECULE: 1, 2` begins two.
    current: usize,
    /// Rows of an incomplete operator.
    rows: Vec<[f64; 4]>,
    /// Its name.
    name: String,
    /// Bytes of all names and operators.
    ledger: Ledger,
}

/// Bytes per entry of a growing list, besides its letters.
const ENTRY: usize = 96;

impl Biomt {
    /// Parses the current line, which belongs to the remark.
    pub(super) fn take<R: BufRead>(&mut self, lines: &Lines<R>) -> Result<()> {
        let mut words = Words::of(lines).skip(2);
        let Some(first) = words.next() else { return Ok(()) };
        if let Some(row) = first.text.strip_prefix("BIOMT") {
            return self.row(lines, row, first.at);
        }
        if let Some((_, ids)) = lines.text().split_once("BIOMOLECULE:") {
            self.current = self.assemblies.len();
            let ids = ids.split([',', ' ']).map(str::trim).filter(|id| !id.is_empty());
            self.ledger.add(ids.clone().map(|id| ENTRY + id.len()).sum())?;
            self.assemblies.extend(ids.map(|id| Assembly { id: id.to_owned(), parts: Vec::new() }));
        }
        let Some((_, list)) = lines.text().split_once("CHAINS:") else { return Ok(()) };
        if self.assemblies.is_empty() {
            self.assemblies.push(Assembly { id: "1".into(), parts: Vec::new() });
        }
        let chains = || list.split([',', ' ']).map(str::trim).filter(|name| !name.is_empty()).map(chain);
        let bytes: usize = chains().map(|name| ENTRY + name.len()).sum();
        for assembly in &mut self.assemblies[self.current..] {
            self.ledger.add(ENTRY + bytes)?;
            match assembly.parts.last_mut().filter(|_| first.text != "APPLY") {
                Some(part) => part.chains.extend(chains()),
                None => assembly.parts.push(AssemblyPart { chains: chains().collect(), operators: Vec::new() }),
            }
        }
        Ok(())
    }

    /// A row: `BIOMT1`, the operator's number, three numbers of the matrix, one of the shift.
    fn row<R: BufRead>(&mut self, lines: &Lines<R>, row: &str, at: usize) -> Result<()> {
        let fail = |problem: String, mend: &str| lines.fail(at, "REMARK 350", problem, mend);
        let mut words = Words::of(lines).skip(3);
        let name = words.next().map(|word| word.text).unwrap_or_default();
        let expected = self.rows.len() + 1;
        if row != expected.to_string() || expected > 1 && name != self.name {
            let problem = format!(
                "found {} of operator {}, expected BIOMT{expected}",
                unquoted(&format!("BIOMT{row}")),
                quote(name)
            );
            return Err(fail(problem, "give every operator three rows, BIOMT1 to BIOMT3"));
        }
        let mut numbers = [0.0; 4];
        for number in &mut numbers {
            let word =
                words.next().ok_or_else(|| fail("expected four numbers in the row".into(), "use 12 per operator"))?;
            *number = word.finite("REMARK 350")?;
        }
        self.rows.push(numbers);
        name.clone_into(&mut self.name);
        if let &[a, b, c] = &self.rows[..] {
            self.rows.clear();
            for assembly in &mut self.assemblies[self.current..] {
                self.ledger.add(ENTRY + size_of::<Operator>() + self.name.len())?;
                let part = assembly.parts.last_mut();
                let part = part.ok_or_else(|| {
                    fail("no chains are named before the operator".into(), "name the chains after APPLY")
                })?;
                part.operators.push((self.name.clone(), Operator([a, b, c])));
            }
        }
        Ok(())
    }

    /// The assemblies, with complete operators.
    ///
    /// # Errors
    /// [`Error::Scene`] where rows are missing.
    pub(super) fn assemblies<R: BufRead>(&self, lines: &Lines<R>) -> Result<&[Assembly]> {
        if self.rows.is_empty() {
            return Ok(&self.assemblies);
        }
        let problem = format!("operator {} has {} of three rows", quote(&self.name), self.rows.len());
        Err(Error::scene(lines.file().named("REMARK 350"), problem, "give BIOMT1 to BIOMT3"))
    }

    /// The names of the assemblies, and the most operators that each can have.
    pub(super) fn counts(&self) -> impl Iterator<Item = (String, u64)> {
        let most = |assembly: &Assembly| assembly.parts.iter().map(|part| part.operators.len()).max().unwrap_or(0);
        self.assemblies.iter().map(move |assembly| (assembly.id.clone(), most(assembly) as u64))
    }
}

/// `NULL` is the chain without a name.
fn chain(name: &str) -> Vec<u8> {
    if name == "NULL" { b" ".to_vec() } else { name.as_bytes().to_vec() }
}
