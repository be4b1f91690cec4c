//! The words for columns, and the columns of files that they mean.

use super::expression::Kind;

/// The property of a particle that a word reads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Key {
    /// The number in the file's order, counted from this number.
    Index(u8),
    /// A coordinate.
    Axis(usize),
    /// The radius in the file.
    Radius,
    /// The symbol of the element.
    Element,
    /// The residue's number and insertion code.
    Resid,
    /// All that distinguishes residues: number, insertion code, name, chain and segment.
    Residue,
    /// A kind of residue or atom.
    Kind(Kind),
    /// The first of these columns that the file has.
    Columns(Vec<String>),
}

/// Words that several programs have for a column: the word, and the columns of readers.
const ALIASES: [(&[&str], &[&str]); 9] = [
    (&["name", "atomname"], &["name", "species", "atom_name", "atom"]),
    (&["resname"], &["resname"]),
    (&["chain", "chainid"], &["chain", "chainid"]),
    (&["segid", "segname"], &["segid"]),
    (&["id"], &["id", "serial"]),
    (&["serial"], &["serial", "id"]),
    (&["bfactor", "beta", "tempfactor"], &["bfactor", "beta", "tempfactor"]),
    (&["charge"], &["charge", "q"]),
    (&["record_type", "record"], &["record"]),
];

/// The columns with the number of a residue.
pub(super) const NUMBERS: [&str; 3] = ["residue", "resid", "resnum"];

impl Key {
    /// The meaning of a word.
    pub(super) fn of(word: &str) -> Self {
        let word = word.to_lowercase();
        match word.as_str() {
            "index" => Self::Index(0),
            "bynum" => Self::Index(1),
            "x" => Self::Axis(0),
            "y" => Self::Axis(1),
            "z" => Self::Axis(2),
            "radius" => Self::Radius,
            "element" => Self::Element,
            "resid" | "resnum" => Self::Resid,
            "residue" => Self::Residue,
            _ => {
                let known = ALIASES.iter().find(|(words, _)| words.contains(&word.as_str()));
                Self::Columns(match known {
                    Some((_, columns)) => columns.iter().map(|column| (*column).to_owned()).collect(),
                    None => vec![word],
                })
            }
        }
    }
}

/// The columns that a word reads: the first that is there counts.
pub(crate) fn candidates(word: &str) -> Vec<String> {
    match Key::of(word) {
        Key::Index(0) => vec!["index".into()],
        Key::Resid | Key::Residue => NUMBERS.map(str::to_owned).to_vec(),
        Key::Columns(columns) => columns,
        Key::Index(_) | Key::Axis(_) | Key::Radius | Key::Element | Key::Kind(_) => vec![word.to_lowercase()],
    }
}

/// The columns that a reader must keep for this key, as far as the file has them.
pub(super) fn keys(key: &Key) -> Vec<String> {
    let names = |all: &[&str]| all.iter().map(|name| (*name).to_owned()).collect();
    match key {
        Key::Index(_) | Key::Axis(_) | Key::Radius | Key::Element | Key::Kind(Kind::Hydrogen | Kind::Metal) => {
            Vec::new()
        }
        Key::Resid => names(&[&NUMBERS[..], &["icode"]].concat()),
        Key::Residue => names(&[&NUMBERS[..], &RESIDUE].concat()),
        Key::Kind(Kind::Ligand) => names(&[&NUMBERS[..], &RESIDUE, &["name", "species", "atom_name", "atom"]].concat()),
        Key::Kind(Kind::Backbone) => names(&["resname", "name"]),
        Key::Kind(_) => names(&["resname"]),
        Key::Columns(columns) => columns.clone(),
    }
}

/// The columns besides the number that distinguish residues.
pub(super) const RESIDUE: [&str; 4] = ["icode", "resname", "chain", "segid"];
