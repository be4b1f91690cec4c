//! Signs of PDB, PQR and PDBQT, which have the same records.

use crate::formats::table::signs::is_csv;
use crate::signs::numbers;
use halfline_ground::quote::setting::FORMAT;

/// The records that a PDB file may begin with.
pub(super) const RECORDS: [&str; 20] = [
    "HEADER", "OBSLTE", "TITLE", "SPLIT", "CAVEAT", "COMPND", "REMARK", "CRYST1", "MODEL", "ATOM", "HETATM", "AUTHOR",
    "USER", "NUMMDL", "SEQRES", "HELIX", "SHEET", "SSBOND", "ORIGX1", "SCALE1",
];

pub(super) fn is_pdb(lines: &[&str]) -> bool {
    // In free form a blank is enough behind the name of the record.
    let is_atom = |line: &str| ["ATOM", "HETATM"].contains(&line.split_whitespace().next().unwrap_or_default());
    let record = |line: &str| RECORDS.contains(&line.get(..6).unwrap_or(line).trim_end()) || is_atom(line);
    let mut nonblank = lines.iter().filter(|line| !line.trim().is_empty());
    // A title or a header of columns may begin with the name of a record, but what is behind it does not.
    let second = nonblank.clone().nth(1);
    let is_table = lines.first().is_some_and(|line| is_csv(&[line]));
    if second.is_some_and(|line| !record(line) && (is_table || !line.starts_with(|c: char| c.is_ascii_uppercase()))) {
        return false;
    }
    match nonblank.next() {
        // In GROMOS the word is alone on its line too, and its block ends before atoms; some writers of PDB have no title.
        Some(line) if line.trim_end() == "TITLE" => {
            nonblank.find(|line| line.trim_end() == "END" || record(line)).is_some_and(|line| record(line))
        }
        line => line.is_some_and(|line| record(line)),
    }
}

/// The atoms of a file of PDB records.
pub(super) fn atoms<'a>(lines: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
    lines.iter().copied().filter(|line| line.starts_with("ATOM") || line.starts_with("HETATM"))
}

/// A charge in columns 71 to 76 of an atom, and an AutoDock atom type behind it.
pub(super) fn has_charge(atom: &str) -> bool {
    let point = atom.as_bytes().get(72) == Some(&b'.') && atom.as_bytes().get(76) == Some(&b' ');
    point
        && numbers(atom.get(70..76).unwrap_or_default()) == 1
        && atom.get(77..).is_some_and(|kind| !kind.trim().is_empty())
}

/// A tree of branches.
pub(super) fn is_tree(lines: &[&str]) -> bool {
    is_pdb(lines) && lines.iter().any(|line| line.trim_end() == "ROOT")
}

/// PDB records whose atoms end in a charge and an AutoDock atom type, or that have a tree of branches.
pub(super) fn is_pdbqt(lines: &[&str]) -> bool {
    atoms(lines).next().is_some_and(|atom| has_charge(atom) || is_tree(lines))
}

/// Whether PDB records have a tree, or an atom with a charge and a type that PDB's columns cannot hold: a letter in column 79, or
/// `A` (aromatic carbon) in column 78.
pub(super) fn has_types(lines: &[&str]) -> bool {
    let typed = |atom: &str| {
        let kind = atom.as_bytes().get(77..).unwrap_or_default();
        kind.get(1).is_some_and(u8::is_ascii_alphabetic) || kind.first() == Some(&b'A')
    };
    is_tree(lines) || atoms(lines).any(|atom| has_charge(atom) && typed(atom))
}

/// The numbers with a decimal point that follow each other in an atom.
pub(super) fn run(atom: &str) -> usize {
    let is_number = |word: &&str| word.contains('.') && word.parse::<f64>().is_ok();
    atom.split_whitespace().skip_while(|word| !is_number(word)).take_while(is_number).count()
}

/// Coordinates, occupancy and B factor of an atom, as far as its columns of PDB have numbers; `None` where they cannot be these.
pub(super) fn column_numbers(atom: &str) -> Option<[f64; 5]> {
    let field = |from: usize, to: usize| atom.get(from..to.min(atom.len())).unwrap_or_default().trim();
    let mut found = [0.0; 5];
    for (k, (from, to)) in [(30, 38), (38, 46), (46, 54), (54, 60), (60, 66)].into_iter().enumerate() {
        found[k] = match field(from, to) {
            "" if k > 2 => continue,
            text => text.parse().ok()?,
        };
    }
    Some(found)
}

/// PDB records most of whose atoms have two numbers after their coordinates, and are not in the columns of PDB.
pub(super) fn is_free(lines: &[&str]) -> bool {
    let [fit, free] = atoms(lines).fold([0, 0], |[fit, free], atom| match column_numbers(atom) {
        None if run(atom) == 5 => [fit, free + 1],
        _ => [fit + 1, free],
    });
    is_pdb(lines) && free > fit
}

/// The same, or atoms with charges: numbers in the columns of the occupancy, some of them negative.
pub(super) fn is_pqr(lines: &[&str]) -> bool {
    let negative = |atom: &str| run(atom) == 5 && column_numbers(atom).is_some_and(|numbers| numbers[3] < 0.0);
    is_free(lines) || is_pdb(lines) && atoms(lines).any(negative)
}

/// The warning about a PQR file whose numbers are in PDB's columns.
pub(super) fn doubt(lines: &[&str]) -> Option<String> {
    let in_columns = |atom: &str| run(atom) == 5 && column_numbers(atom).is_some();
    let is_either = !is_pqr(lines) && atoms(lines).next().is_some();
    (is_either && atoms(lines).all(in_columns)).then(|| {
        format!(
            "the numbers behind the coordinates are in the columns of occupancy and B factor of pdb; they are read as charge and \
             radius, as the name of the file says; {FORMAT} sets another"
        )
    })
}
