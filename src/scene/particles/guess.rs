//! Which element an atom is of, where a file gives only the atom's name.

use crate::scene::style::elements::atomic_number;

/// Residues of proteins and nucleic acids: no metal stands in them, so their `CA` is a carbon wherever it is written.
const POLYMER: [&[u8]; 31] = [
    b"ALA", b"ARG", b"ASN", b"ASP", b"CYS", b"GLN", b"GLU", b"GLY", b"HIS", b"ILE", b"LEU", b"LYS", b"MET", b"PHE",
    b"PRO", b"SER", b"THR", b"TRP", b"TYR", b"VAL", b"A", b"C", b"G", b"U", b"I", b"DA", b"DC", b"DG", b"DT", b"DU",
    b"DI",
];

/// The ions that CHARMM calls by names of its own.
const IONS: [(&[u8], &str); 5] = [(b"SOD", "Na"), (b"POT", "K"), (b"CLA", "Cl"), (b"CAL", "Ca"), (b"CES", "Cs")];

/// Elements of two letters that names in molecules mean more often than their first letter.
const PAIRS: [&str; 10] = ["CL", "BR", "FE", "ZN", "MG", "MN", "CU", "SI", "SE", "LI"];

/// The atomic number of a symbol in bytes, perhaps with a charge or a number behind it (`Cu2+`); 0 for none.
pub(super) fn of_symbol(symbol: &[u8]) -> u8 {
    let symbol = symbol.trim_ascii();
    let letters = symbol.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    match symbol {
        // What molecules are made of, without a search.
        b"C" => 6,
        b"O" => 8,
        b"N" => 7,
        b"H" => 1,
        _ => std::str::from_utf8(&symbol[..letters]).map_or(0, atomic_number),
    }
}

/// By the four columns of a PDB name: the symbol ends in the second, unless four letters begin with hydrogen's (wwPDB
/// format 3.3, ATOM). 0 for none.
pub(super) fn of_columns(name: &[u8], residue: &[u8]) -> u8 {
    let &[first, second, .., last] = name else { return of_name(name, residue) };
    let hydrogen = first == b'H' && !last.is_ascii_whitespace();
    if first.is_ascii_alphabetic() && second.is_ascii_alphabetic() && !hydrogen && !is_polymer(residue) {
        let both = of_symbol(&[first, second]);
        if both > 0 {
            return both;
        }
    }
    let letter = name.iter().find(|byte| byte.is_ascii_alphabetic());
    letter.map_or(0, |letter| of_symbol(&[*letter]))
}

/// By a name that no columns align, as well as it can be done: `CA` is calcium in a residue of that name and else carbon.
/// 0 for what no element's name begins like, such as virtual sites and beads.
pub(super) fn of_name(name: &[u8], residue: &[u8]) -> u8 {
    let letters = letters(name);
    if let Some((_, symbol)) = IONS.iter().find(|(ion, _)| letters.eq_ignore_ascii_case(ion)) {
        return atomic_number(symbol);
    }
    let whole = of_symbol(letters);
    let pair = PAIRS.iter().any(|pair| letters.eq_ignore_ascii_case(pair.as_bytes())) && !is_polymer(residue);
    // Written as in the periodic table, `Cu`, it is meant so.
    let title = letters.len() == 2 && letters[0].is_ascii_uppercase() && letters[1].is_ascii_lowercase();
    let alone = letters.eq_ignore_ascii_case(self::letters(residue));
    if whole > 0 && (pair || title || alone) {
        return whole;
    }
    match letters.first() {
        Some(letter) if b"HCNOFPShcnofps".contains(letter) => of_symbol(&[*letter]),
        _ => whole,
    }
}

/// The first run of letters: `HB` of `1HB2`.
fn letters(name: &[u8]) -> &[u8] {
    let start = name.iter().position(u8::is_ascii_alphabetic).unwrap_or(name.len());
    let rest = &name[start..];
    &rest[..rest.iter().position(|byte| !byte.is_ascii_alphabetic()).unwrap_or(rest.len())]
}

fn is_polymer(residue: &[u8]) -> bool {
    POLYMER.contains(&residue.trim_ascii())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::style::elements::element;

    fn symbol(number: u8) -> &'static str {
        element(number).map_or("none", |element| element.symbol)
    }

    #[test]
    fn columns_tell_calcium_from_the_alpha_carbon() {
        for (name, residue, expected) in [
            (" CA ", "ALA", "C"),
            ("CA  ", " CA", "Ca"),
            ("CA  ", "ALA", "C"),
            ("HG11", "XXX", "H"),
            ("HG  ", " HG", "Hg"),
            ("1HB ", "XXX", "H"),
            ("2HG1", "XXX", "H"),
            (" OXT", "XXX", "O"),
            ("OX  ", "XXX", "O"),
            ("FE  ", "HEM", "Fe"),
            (" D  ", "DOD", "H"),
            ("NA  ", " NA", "Na"),
            ("    ", "XXX", "none"),
            ("1234", "XXX", "none"),
            (" X  ", "XXX", "none"),
        ] {
            assert_eq!(symbol(of_columns(name.as_bytes(), residue.as_bytes())), expected, "{name:?} of {residue}");
        }
    }

    #[test]
    fn names_without_columns_are_guessed() {
        for (name, residue, expected) in [
            ("OW", "SOL", "O"),
            ("HW1", "SOL", "H"),
            ("MW", "SOL", "none"),
            ("CA", "LYS", "C"),
            ("CA", "CA", "Ca"),
            ("NA", "NA+", "Na"),
            ("NA", "LIG", "N"),
            ("SOD", "SOD", "Na"),
            ("CL2", "LIG", "Cl"),
            ("Cu1", "", "Cu"),
            ("1HB2", "ALA", "H"),
            ("W", "PW", "W"),
            ("", "", "none"),
        ] {
            assert_eq!(symbol(of_name(name.as_bytes(), residue.as_bytes())), expected, "{name:?} of {residue}");
        }
        assert_eq!([of_symbol(b"Cu2+"), of_symbol(b" zn"), of_symbol(b"\xff"), of_symbol(b"2")], [29, 30, 0, 0]);
    }
}
