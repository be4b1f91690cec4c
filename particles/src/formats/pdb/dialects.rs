//! The last columns of PDBQT and PQR files, which differ from the columns of PDB.
//!
//! PDBQT (autodock.scripps.edu/faqs-help/faq/what-is-the-format-of-a-pdbqt-file): a partial charge in columns 71 to 76
//! and an AutoDock atom type in 78 and 79. PQR (pdb2pqr.readthedocs.io/en/latest/formats/pqr.html): words separated by
//! blanks; charge and radius follow the three coordinates.

use super::columns::{COORDINATE, NAME, RESIDUE_ID, RESIDUE_NAME, X, coordinate, field};
use crate::lines::{Lines, Word, Words};
use crate::particles::atom_property::{AtomProperty, NameTable};
use crate::particles::infer::AtomNames;
use crate::particles::molecule::Model;
use halfline_ground::error::Result;
use halfline_ground::quote::quote;
use halfline_ground::quote::setting::FORMAT;
use std::io::BufRead;

/// The element symbol of an AutoDock type: aromatic carbon, donors and acceptors of hydrogen bonds, carbon of a ring
/// that is closed while docking, water that is docked with a ligand. Other types are element symbols.
pub(super) fn symbol(kind: &[u8]) -> &[u8] {
    match kind.trim_ascii() {
        b"A" | b"J" | b"Q" | [b'C', b'G'] => b"C",
        b"HD" | b"HS" => b"H",
        b"NA" | b"NS" => b"N",
        b"OA" | b"OS" | b"W" => b"O",
        b"SA" => b"S",
        other => other,
    }
}

/// The columns of an atom of a PQR file.
struct PqrAtom<'a, R> {
    position: [f64; 3],
    names: AtomNames<'a>,
    chain: &'a [u8],
    /// The words behind the coordinates: charge, radius, and perhaps the element.
    rest: &'a [Word<'a, R>],
}

impl<'a, R: BufRead> PqrAtom<'a, R> {
    /// The atom of a line whose coordinates are three words from `first` on: behind serial number, name, residue, optional
    /// chain, number.
    fn of_words(line: &'a [u8], words: &'a [Word<'a, R>], first: usize) -> Result<Self> {
        let mut position = [0.0; 3];
        for (axis, word) in words[first..first + 3].iter().enumerate() {
            position[axis] = word.finite(["x", "y", "z"][axis])?;
        }
        let text = |n: usize| words[n].text.as_bytes();
        let site = &line[words[2].at..words[first - 1].at + words[first - 1].text.len()];
        let names = AtomNames { symbol: b"", name: text(1), residue: text(2), site };
        let chain = if first > 4 { text(3) } else { b"" };
        Ok(Self { position, names, chain, rest: &words[first + 3..] })
    }

    /// The atom of a line with PDB's columns.
    fn of_columns(lines: &'a Lines<R>, words: &'a [Word<'a, R>]) -> Result<Self> {
        let line = lines.text().as_bytes();
        let mut position = [0.0; 3];
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let at = X + k * COORDINATE;
            position[k] = coordinate(lines, at..at + COORDINATE, axis)?;
        }
        let behind = words.iter().position(|word| word.at >= X + 3 * COORDINATE).unwrap_or(words.len());
        let (residue, site) = (field(line, RESIDUE_NAME).trim_ascii(), field(line, RESIDUE_ID));
        let names = AtomNames { symbol: b"", name: field(line, NAME).trim_ascii(), residue, site };
        let chain = site.get(..1).unwrap_or_default().trim_ascii();
        Ok(Self { position, names, chain, rest: &words[behind..] })
    }

    /// Charge and radius.
    fn charge_and_radius(&self, lines: &Lines<R>) -> Result<[f64; 2]> {
        let [charge, radius, ..] = self.rest else {
            let problem = "expected charge and radius after the coordinates";
            return Err(lines.ends("radius", problem, format!("add two numbers, or use {FORMAT} pdb")));
        };
        let (charge, length) = (charge.finite("charge")?, radius.finite("radius")?);
        if length < 0.0 {
            let problem = format!("{} is negative", quote(radius.text));
            return Err(lines.fail(radius.at, "radius", problem, "use 0 or more"));
        }
        Ok([charge, length])
    }

    /// The number of the residue, and the insertion code that may follow it.
    fn residue(&self) -> (Option<f64>, &'a str) {
        let whole = std::str::from_utf8(self.names.site).unwrap_or_default();
        let site = whole.trim_end_matches(|c: char| !c.is_ascii_digit());
        let icode = if site.is_empty() { "" } else { whole[site.len()..].trim() };
        let digits = site.rsplit(|c: char| !(c.is_ascii_digit() || c == '-')).next();
        (digits.and_then(|digits| digits.parse().ok()), icode)
    }
}

/// Parses the atom of the current line of a PQR file.
pub(super) fn pqr<R: BufRead>(lines: &Lines<R>, names: &mut NameTable, model: &mut Model) -> Result<()> {
    let line = lines.text().as_bytes();
    // A serial number of many digits directly follows the record's name.
    let words: Vec<Word<'_, R>> = Words::of(lines).skip_while(|word| ["ATOM", "HETATM"].contains(&word.text)).collect();
    let is_real = |word: &Word<'_, R>| word.text.contains('.') && word.text.parse::<f64>().is_ok();
    let first = words.iter().position(is_real).unwrap_or(words.len());
    let is_spaced = first >= 4 && words.get(first..first + 3).is_some_and(|numbers| numbers.iter().all(is_real));
    let atom = if is_spaced { PqrAtom::of_words(line, &words, first)? } else { PqrAtom::of_columns(lines, &words)? };
    let [charge, radius] = atom.charge_and_radius(lines)?;
    // Some programs append the element.
    let symbol = atom.rest.get(2..).and_then(<[_]>::last).map_or("", |word| word.text).as_bytes();
    let symbol = if symbol.len() <= 2 { symbol } else { b"" };
    let serial = words.first().and_then(|word| word.text.trim_start_matches(char::is_alphabetic).parse().ok());
    let (number, icode) = atom.residue();
    let record = &line[..line.iter().take_while(|byte| byte.is_ascii_alphabetic()).count()];
    model.push(&AtomNames { symbol, ..atom.names }, atom.position, 0, |kind| {
        Ok(match kind {
            AtomProperty::Charge => charge,
            AtomProperty::Serial => serial.unwrap_or(f64::NAN),
            AtomProperty::Residue => number.unwrap_or(f64::NAN),
            AtomProperty::Chain => names.number(kind, atom.chain)?,
            AtomProperty::Name => names.number(kind, atom.names.name.trim_ascii())?,
            AtomProperty::Resname => names.number(kind, atom.names.residue)?,
            AtomProperty::Icode => names.number(kind, icode.as_bytes())?,
            AtomProperty::Record => names.number(kind, record)?,
            _ => 0.0,
        })
    })?;
    // Force fields give the hydrogens of water no size.
    model.radius(if radius > 0.0 { radius } else { f64::NAN });
    Ok(())
}
