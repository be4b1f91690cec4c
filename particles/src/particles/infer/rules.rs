//! Rules for a single atom's name, given its residue and the file's columns.

use super::residues::{ResidueClass, class};
use crate::elements::atomic_number;

/// The kind of site of an atom record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Site {
    /// An atom, by its atomic number.
    Element(u8),
    /// A massless site of a force field: not an atom.
    Virtual,
    /// A bead of a coarse-grained model: several atoms.
    Bead,
    Unknown,
}

/// The rule that found an element, the most reliable first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum InferenceRule {
    /// The residue is known, with its atoms.
    Residue,
    /// An ion, alone in its residue.
    Ion,
    /// The columns of the name.
    Columns,
    /// The name alone.
    Name,
}

/// Two-letter symbols that are more common at the beginning of a name than their first letter alone.
const PAIRS: [&[u8]; 11] = [b"CL", b"BR", b"FE", b"ZN", b"MG", b"MN", b"CU", b"SI", b"SE", b"LI", b"PT"];

/// Names of ions in CHARMM and AMBER that are not symbols.
const IONS: [(&[u8], &str); 14] = [
    (b"SOD", "Na"),
    (b"POT", "K"),
    (b"CLA", "Cl"),
    (b"CAL", "Ca"),
    (b"CES", "Cs"),
    (b"LIT", "Li"),
    (b"RUB", "Rb"),
    (b"BAR", "Ba"),
    (b"CAD", "Cd"),
    (b"MAG", "Mg"),
    (b"CIO", "Cs"),
    (b"IOD", "I"),
    (b"FLU", "F"),
    (b"BRO", "Br"),
];

/// The atomic number of a symbol, optionally with a charge or a number after it (`Cu2+`); 0 for anything else.
pub(crate) fn of_symbol(symbol: &[u8]) -> u8 {
    let symbol = symbol.trim_ascii();
    let letters = symbol.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    match symbol {
        // The most common elements, without a search.
        b"C" => 6,
        b"O" => 8,
        b"N" => 7,
        b"H" => 1,
        _ => std::str::from_utf8(&symbol[..letters]).map_or(0, atomic_number),
    }
}

/// The letters at the beginning of a name, after the number of an old hydrogen name: `HB` of `1HB2`.
pub(super) fn letters(name: &[u8]) -> &[u8] {
    let start = name.iter().position(u8::is_ascii_alphabetic).unwrap_or(name.len());
    let rest = &name[start..];
    &rest[..rest.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(rest.len())]
}

/// The element of an atom that is alone in its residue, if it is an ion. A chain trace also has one atom per residue;
/// there `CA` is calcium only if the residue has that name too.
pub(super) fn ion(name: &[u8], residue: &[u8], class: Option<ResidueClass>) -> Option<u8> {
    if class.is_some() && letters(name) != letters(residue) {
        return None;
    }
    let name = letters(name);
    let listed = |name: &[u8]| IONS.iter().find(|(ion, _)| name.eq_ignore_ascii_case(ion)).map(|(_, symbol)| *symbol);
    if let Some(symbol) = listed(name) {
        return Some(atomic_number(symbol));
    }
    let element = of_symbol(name);
    let named =
        name.eq_ignore_ascii_case(letters(residue)) || listed(letters(residue)).map(atomic_number) == Some(element);
    let trace = name.eq_ignore_ascii_case(b"CA") || name.len() == 1;
    (element > 0 && (named || !trace)).then_some(element)
}

/// Whether a residue with this name in capitals is a single ion: a metal or a halogen, by a name of any program.
pub(crate) fn is_ion(residue: &[u8]) -> bool {
    // Names of molecules begin with the symbols of elements beyond bismuth more often than those occur: PO4 is no
    // polonium.
    let known = |element: u8| element <= 83 && !NONMETALS.contains(&element);
    class(residue).is_none() && ion(residue, residue, None).is_some_and(known)
}

/// Atomic numbers of elements that are not single ions: hydrogen, boron to oxygen, silicon to sulphur, arsenic,
/// selenium, tellurium and the noble gases.
const NONMETALS: [u8; 16] = [1, 2, 5, 6, 7, 8, 10, 14, 15, 16, 18, 33, 34, 36, 52, 54];

/// The element of an atom in a known residue: its name begins with the symbol. `None` for names that do not occur
/// there.
pub(super) fn in_residue(name: &[u8], residue: &[u8]) -> Option<u8> {
    let letters = letters(name);
    if letters.eq_ignore_ascii_case(b"SE") && matches!(residue, b"MSE" | b"SEC" | b"CSE") {
        return Some(atomic_number("Se"));
    }
    match letters.first()?.to_ascii_uppercase() {
        b'D' => Some(1),
        letter @ (b'H' | b'C' | b'N' | b'O' | b'P' | b'S') => Some(of_symbol(&[letter])),
        _ => None,
    }
}

/// The element by the four columns of a PDB name: a one-letter symbol is in the second column; a two-letter symbol
/// begins in the first, and so does a four-letter name (wwPDB format 3.3, ATOM). `None` where the columns are not
/// conclusive.
pub(super) fn of_columns(name: &[u8]) -> Option<u8> {
    let &[first, second, _, last] = name else { return None };
    let full = !last.is_ascii_whitespace();
    let one = |letter: u8| Some(of_symbol(&[letter])).filter(|element| *element > 0 && letter != b'T');
    match (first.is_ascii_alphabetic(), second.is_ascii_alphabetic()) {
        // Programs that begin every name in this column write these symbols so; no carbon, boron, fluorine or sulphur
        // has such a name.
        (false, true) if matches!(&name[1..3], b"CL" | b"BR" | b"FE" | b"SI") => Some(of_symbol(&name[1..3])),
        // Mostly hydrogens, `1HB `, and names of some programs, `1C4A`.
        (false, true) => one(second),
        (true, true) if full && PAIRS.iter().all(|pair| !name[..2].eq_ignore_ascii_case(pair)) => {
            one(first).or_else(|| Some(of_symbol(&name[..2])).filter(|element| *element > 0))
        }
        (true, true) => Some(of_symbol(&name[..2])).filter(|element| *element > 0),
        _ => None,
    }
}

/// The element by name in an unknown residue, where columns are not conclusive: the first letter, except for two-letter
/// symbols whose first letter is not an element, that are written as in the periodic table, or that are far more common
/// ([`PAIRS`]). 0 for unknown names.
pub(super) fn of_name(name: &[u8]) -> u8 {
    let letters = letters(name);
    let &[first, ref rest @ ..] = letters else { return 0 };
    let Some(second) = rest.first() else {
        // Tritium is less common than types numbered `T1`.
        return if first.eq_ignore_ascii_case(&b'T') { 0 } else { of_symbol(&[first]) };
    };
    // Letters after the first one number the atoms of organic molecules: `UNK` is not uranium.
    let one = if b"HCNOPSFB".contains(&first.to_ascii_uppercase()) { of_symbol(&[first]) } else { 0 };
    let two = of_symbol(&letters[..2]);
    let pair = PAIRS.iter().any(|pair| letters[..2].eq_ignore_ascii_case(pair));
    // `Fe`, `Ca`, as in the periodic table; with a number after them, small letters only number atoms.
    let written = first.is_ascii_uppercase() && second.is_ascii_lowercase() && first != b'H' && name.len() == 2;
    if two > 0 && (pair || written || one == 0) { two } else { one }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::element;

    fn symbol(number: impl Into<Option<u8>>) -> &'static str {
        number.into().and_then(element).map_or("none", |element| element.symbol)
    }

    #[test]
    fn columns_distinguish_calcium_from_the_alpha_carbon() {
        for (name, expected) in [
            (" CA ", "C"),
            ("CA  ", "Ca"),
            ("HG11", "H"),
            ("HG  ", "Hg"),
            ("1HB ", "H"),
            ("2HG1", "H"),
            (" OXT", "O"),
            ("FE  ", "Fe"),
            ("CL12", "Cl"),
            ("CA12", "C"),
            ("ZN12", "Zn"),
            (" D  ", "H"),
            (" CL1", "Cl"),
            (" FE ", "Fe"),
            (" SIA", "Si"),
            (" F2 ", "F"),
            (" SG ", "S"),
            (" CB ", "C"),
            ("1234", "none"),
            ("    ", "none"),
            ("C1  ", "none"),
            (" X  ", "none"),
            ("N", "none"),
        ] {
            assert_eq!(symbol(of_columns(name.as_bytes())), expected, "{name:?}");
        }
    }

    #[test]
    fn names_alone_give_the_likelier_element() {
        for (name, expected) in [
            ("CA", "C"),
            ("CD1", "C"),
            ("NA", "N"),
            ("HG1", "H"),
            ("1HB2", "H"),
            ("OXT", "O"),
            ("CL2", "Cl"),
            ("CLA", "Cl"),
            ("Cl1", "Cl"),
            ("BR", "Br"),
            ("B1", "B"),
            ("F3", "F"),
            ("FE", "Fe"),
            ("ZN1", "Zn"),
            ("Cu1", "Cu"),
            ("AU3", "Au"),
            ("RU", "Ru"),
            ("K", "K"),
            ("PB", "P"),
            ("Ho", "H"),
            ("Ca", "Ca"),
            ("Ca13", "C"),
            ("UNK", "none"),
            ("U1", "U"),
            ("T1", "none"),
            ("MW", "none"),
            ("BB", "B"),
            ("X1", "none"),
            ("", "none"),
        ] {
            assert_eq!(symbol(of_name(name.as_bytes())), expected, "{name:?}");
        }
        assert_eq!([of_symbol(b"Cu2+"), of_symbol(b" zn"), of_symbol(b"\xff"), of_symbol(b"2")], [29, 30, 0, 0]);
    }

    #[test]
    fn ions_are_single_atoms_with_an_ions_name() {
        for (name, residue, class, expected) in [
            ("CA", "CA", None, "Ca"),
            ("CA", "CA2", None, "Ca"),
            ("CAL", "CAL", None, "Ca"),
            ("CA", "CAL", None, "Ca"),
            ("CA", "LIG", None, "none"),
            ("CA", "ALA", Some(ResidueClass::Protein), "none"),
            ("ZN", "ION", None, "Zn"),
            ("NA+", "ION", None, "Na"),
            ("CL-", "CL-", None, "Cl"),
            ("CD", "CD", None, "Cd"),
            ("HG", "HG", None, "Hg"),
            ("K", "K", None, "K"),
            ("I", "IOD", None, "I"),
            ("N", "XXX", None, "none"),
            ("W", "W", Some(ResidueClass::Bead), "W"),
        ] {
            assert_eq!(symbol(ion(name.as_bytes(), residue.as_bytes(), class)), expected, "{name} of {residue}");
        }
    }

    #[test]
    fn known_residues_hold_the_elements_of_life() {
        for (name, residue, expected) in [
            ("CA", "HSD", "C"),
            ("ND1", "HSD", "N"),
            ("CE1", "HSD", "C"),
            ("CD2", "HSD", "C"),
            ("HG", "SER", "H"),
            ("DD21", "ASN", "H"),
            ("1HB", "ALA", "H"),
            ("SE", "MSE", "Se"),
            ("SD", "MET", "S"),
            ("SE", "MET", "S"),
            ("ZN", "CYS", "none"),
        ] {
            assert_eq!(symbol(in_residue(name.as_bytes(), residue.as_bytes())), expected, "{name} of {residue}");
        }
    }
}
