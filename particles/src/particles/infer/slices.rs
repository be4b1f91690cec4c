//! Elements of atoms that another program holds, by the rules for files that give no elements.

use super::{AtomNames, Inference, is_site, unknown};
use crate::particles::masses;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::{count, quote};
use std::collections::BTreeMap;

/// Atoms of another program, as slices with an entry for each. All but the names may be empty, where nothing is known.
#[derive(Debug, Clone, Copy)]
pub struct NamedAtoms<'a, S> {
    /// Names, such as `CA`, `OW` or `MW`; for atoms without names the names of their types.
    pub names: &'a [S],
    /// Symbols of elements, as far as they are known; everything else is inferred.
    pub symbols: &'a [S],
    /// Names of the residues, such as `ALA`.
    pub residues: &'a [S],
    /// A number for each residue. Atoms of a residue follow each other.
    pub residue_numbers: &'a [u64],
    /// Masses in u, which are used where names do not give an element.
    pub masses: &'a [f64],
}

/// The elements and virtual sites that names and masses give.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct NamedElements {
    /// The atomic number of each atom; 0 for an unknown element, and for a virtual site.
    pub elements: Vec<u8>,
    /// Whether each is a virtual site, a massless point of a force field that is not an atom: `MW` of TIP4P water.
    pub is_site: Vec<bool>,
    /// Whole sentences about inferred elements, unknown ones and virtual sites, with their numbers.
    pub warnings: Vec<String>,
}

/// Infers elements and virtual sites from the names of atoms and residues, as the readers do for PDB and GRO files.
///
/// # Errors
/// [`Error::Settings`] for slices of different lengths.
pub fn elements_of_names<S: AsRef<str>>(atoms: &NamedAtoms<'_, S>) -> Result<NamedElements> {
    let given = atoms.names.len();
    for (what, found) in [
        ("symbols", atoms.symbols.len()),
        ("residues", atoms.residues.len()),
        ("residue numbers", atoms.residue_numbers.len()),
        ("masses", atoms.masses.len()),
    ] {
        if ![0, given].contains(&found) {
            let problem = format!("there are {given} names and {found} {what}");
            return Err(Error::settings(problem, format!("give one for each atom, or no {what}")));
        }
    }
    let text =
        |texts: &'_ [S], n: usize| texts.get(n).map(|text| text.as_ref().as_bytes().to_vec()).unwrap_or_default();
    let (mut inference, mut elements) = (Inference::new(false), Vec::with_capacity(given));
    for (n, name) in atoms.names.iter().enumerate() {
        let number = atoms.residue_numbers.get(n).copied().unwrap_or_default();
        let (symbol, residue) = (text(atoms.symbols, n), text(atoms.residues, n));
        let names = AtomNames {
            symbol: &symbol,
            name: name.as_ref().trim().as_bytes(),
            residue: &residue,
            site: &number.to_le_bytes(),
        };
        inference.push(&names, &mut elements);
    }
    let inferred = inference.finish(&mut elements);
    let mut warnings = inferred.sentences_of("the topology", given as u64);
    let is_site: Vec<bool> = elements.iter().map(|code| is_site(*code)).collect();
    // The mass of a bead is the mass of several atoms.
    let by_mass = inferred.beads == 0 && atoms.masses.iter().any(|mass| mass.fract() != 0.0);
    let (mut weighed, mut names) = (0, BTreeMap::<&str, u64>::new());
    for (n, code) in elements.iter_mut().enumerate() {
        let Some(slot) = unknown(*code) else { continue };
        *code = atoms.masses.get(n).filter(|_| by_mass).and_then(|mass| masses::nearest(*mass)).unwrap_or(0);
        match *code {
            0 => *names.entry(inferred.names.get(slot).map_or("others", |name| name)).or_default() += 1,
            _ => weighed += 1,
        }
    }
    if weighed > 0 {
        warnings.push(format!("the elements of {} follow from their masses", count(weighed, "unknown atom")));
    }
    if !names.is_empty() {
        let total = names.values().sum();
        let names: Vec<String> = names.iter().map(|(name, n)| format!("{n} {}", quote(name))).collect();
        warnings.push(format!("the element of {} is unknown ({})", count(total, "atom"), names.join(", ")));
    }
    elements.iter_mut().zip(&is_site).filter(|(_, is_site)| **is_site).for_each(|(code, _)| *code = 0);
    Ok(NamedElements { elements, is_site, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn atoms<'a>(names: &'a [&'a str], residues: &'a [&'a str]) -> NamedAtoms<'a, &'a str> {
        NamedAtoms { names, symbols: &[], residues, residue_numbers: &[], masses: &[] }
    }

    #[test]
    fn elements_and_sites_are_those_of_files() {
        let names = ["OW", "HW1", "HW2", "MW", "N", "CA", "C", "CA"];
        let residues = ["SOL", "SOL", "SOL", "SOL", "ALA", "ALA", "ALA", "CA"];
        let found = elements_of_names(&atoms(&names, &residues)).expect("elements");
        assert_eq!(found.elements, [8, 1, 1, 0, 7, 6, 6, 20]);
        assert_eq!(found.is_site.iter().position(|is_site| *is_site), Some(3));
        assert_eq!(found.is_site.iter().filter(|is_site| **is_site).count(), 1);
        let messages = found.warnings.join("; ");
        assert!(messages.starts_with("the topology gives no element for 7 of 8 atoms"), "{messages}");
        assert!(messages.ends_with("1 virtual site left out (1 `MW`)"), "{messages}");
    }

    #[test]
    fn symbols_come_before_names_and_names_before_masses() {
        let given = NamedAtoms {
            symbols: &["N", "", "", ""],
            residue_numbers: &[1, 2, 3, 4],
            masses: &[12.011, 12.011, 55.845, 500.0],
            ..atoms(&["C1", "O1", "?1", "?2"], &["LIG"; 4])
        };
        let found = elements_of_names(&given).expect("elements");
        assert_eq!(found.elements, [7, 8, 26, 0]);
        assert_eq!(
            found.warnings[1..],
            ["the elements of 1 unknown atom follow from their masses", "the element of 1 atom is unknown (1 `?2`)"]
        );
        // Reduced units.
        let reduced = elements_of_names(&NamedAtoms { masses: &[1.0; 4], ..given }).expect("elements");
        assert_eq!(reduced.elements, [7, 8, 0, 0]);
    }

    #[test]
    fn slices_of_different_lengths_are_refused() {
        let error = elements_of_names(&NamedAtoms { masses: &[1.0], ..atoms(&["C", "H"], &[]) }).expect_err("1 mass");
        assert_eq!(error.to_string(), "there are 2 names and 1 masses; give one for each atom, or no masses");
    }
}
