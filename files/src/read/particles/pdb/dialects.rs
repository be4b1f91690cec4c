//! The last columns of PDBQT and PQR files, which differ from those of PDB.
//!
//! PDBQT (autodock.scripps.edu/faqs-help/faq/what-is-the-format-of-a-pdbqt-file): a partial charge in columns 71 to 76
//! and an AutoDock atom type in 78 and 79. PQR (pdb2pqr.readthedocs.io/en/latest/formats/pqr.html): words separated by
//! blanks; charge and radius follow the three coordinates.

use super::columns::{COORDINATE, NAME, RESIDUE_ID, RESIDUE_NAME, X, coordinate, field};
use crate::read::lines::{Lines, Word, Words};
use crate::read::particles::atom_property::{AtomProperty, NameTable};
use crate::read::particles::infer::AtomNames;
use crate::read::particles::molecule::Model;
use halfline::error::Result;
use halfline::quote::quote;
use halfline::quote::setting::FORMAT;
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

/// Parses the atom of the current line of a PQR file.
pub(super) fn pqr<R: BufRead>(lines: &Lines<R>, names: &mut NameTable, model: &mut Model) -> Result<()> {
    let line = lines.text().as_bytes();
    // A serial number of many digits directly follows the record's name.
    let words: Vec<Word<'_, R>> = Words::of(lines).skip_while(|word| ["ATOM", "HETATM"].contains(&word.text)).collect();
    let is_real = |word: &Word<'_, R>| word.text.contains('.') && word.text.parse::<f64>().is_ok();
    let first = words.iter().position(is_real).unwrap_or(words.len());
    let spaced = words.get(first..first + 3).filter(|numbers| first >= 4 && numbers.iter().all(is_real));
    let mut position = [0.0; 3];
    let (rest, atom, chain) = if let Some(numbers) = spaced {
        for (axis, word) in numbers.iter().enumerate() {
            position[axis] = word.finite(["x", "y", "z"][axis])?;
        }
        // Serial number, name, residue, optional chain, number.
        let text = |n: usize| words[n].text.as_bytes();
        let from = words[first - 1].at + words[first - 1].text.len();
        let site = &line[words[2].at..from];
        let chain = if first > 4 { text(3) } else { b"" };
        (&words[first + 3..], AtomNames { symbol: b"", name: text(1), residue: text(2), site }, chain)
    } else {
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let at = X + k * COORDINATE;
            position[k] = coordinate(lines, at..at + COORDINATE, axis)?;
        }
        let behind = words.iter().position(|word| word.at >= X + 3 * COORDINATE).unwrap_or(words.len());
        let residue = field(line, RESIDUE_NAME).trim_ascii();
        let site = field(line, RESIDUE_ID);
        let name = field(line, NAME).trim_ascii();
        (
            &words[behind..],
            AtomNames { symbol: b"", name, residue, site },
            site.get(..1).unwrap_or_default().trim_ascii(),
        )
    };
    let [charge, radius, element @ ..] = rest else {
        let problem = "expected charge and radius after the coordinates";
        return Err(lines.ends("radius", problem, format!("add two numbers, or use {FORMAT} pdb")));
    };
    let (charge, length) = (charge.finite("charge")?, radius.finite("radius")?);
    if length < 0.0 {
        let problem = format!("{} is negative", quote(radius.text));
        return Err(lines.fail(radius.at, "radius", problem, "use 0 or more"));
    }
    // Some programs append the element.
    let symbol = element.last().map_or("", |word| word.text).as_bytes();
    let atom = AtomNames { symbol: if symbol.len() <= 2 { symbol } else { b"" }, ..atom };
    let serial = words.first().and_then(|word| word.text.trim_start_matches(char::is_alphabetic).parse().ok());
    // An insertion code may follow the residue's number.
    let whole = std::str::from_utf8(atom.site).unwrap_or_default();
    let site = whole.trim_end_matches(|c: char| !c.is_ascii_digit());
    let icode = if site.is_empty() { "" } else { whole[site.len()..].trim() };
    let number = site.rsplit(|c: char| !(c.is_ascii_digit() || c == '-')).next().and_then(|digits| digits.parse().ok());
    let record = &line[..line.iter().take_while(|byte| byte.is_ascii_alphabetic()).count()];
    model.push(&atom, position, 0, |kind| {
        Ok(match kind {
            AtomProperty::Charge => charge,
            AtomProperty::Serial => serial.unwrap_or(f64::NAN),
            AtomProperty::Residue => number.unwrap_or(f64::NAN),
            AtomProperty::Chain => names.number(kind, chain)?,
            AtomProperty::Name => names.number(kind, atom.name.trim_ascii())?,
            AtomProperty::Resname => names.number(kind, atom.residue)?,
            AtomProperty::Icode => names.number(kind, icode.as_bytes())?,
            AtomProperty::Record => names.number(kind, record)?,
            _ => 0.0,
        })
    })?;
    // Force fields give the hydrogens of water no size.
    model.radius(if length > 0.0 { length } else { f64::NAN });
    Ok(())
}
