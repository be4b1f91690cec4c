//! Metals and ligands. MDAnalysis has no words for them; these rules are stated in docs/selection.md.

use crate::particles::infer::residues::class;
use crate::particles::infer::rules::is_ion;
use std::ops::Range;

/// Whether an element is a metal: all but hydrogen, helium and the right of the periodic table from boron, silicon,
/// germanium, antimony and astatine on.
pub(super) fn is_metal(number: u8) -> bool {
    matches!(number, 3..=4 | 11..=13 | 19..=31 | 37..=50 | 55..=84 | 87..=117)
}

/// The least atoms of a ligand, hydrogens excluded: benzene has six.
const LEAST: usize = 6;

/// The longest bond between residues of a chain, ångström: C-N has 1.33, O3'-P 1.61.
const BOND: f64 = 2.0;

/// Names of the wwPDB's chemical components that solutions are made of: alcohols, glycols and their ethers, acids of
/// buffers, detergents.
const ADDITIVES: [&str; 56] = [
    "GOL", "EDO", "PEG", "PGE", "PG4", "PG0", "PG5", "PG6", "PE3", "PE4", "PE5", "PE8", "P6G", "P33", "1PE", "2PE",
    "7PE", "12P", "15P", "XPE", "PGO", "PDO", "MPD", "MRD", "BU1", "BU2", "BU3", "HEZ", "DIO", "TRS", "BTB", "EPE",
    "MES", "NHE", "CXS", "CAC", "CIT", "FLC", "TLA", "TAR", "MLI", "MLA", "SIN", "MLT", "BCN", "DTT", "DTV", "BOG",
    "BNG", "LMT", "LMU", "LMN", "C8E", "CE9", "UND", "D10",
];

/// A residue of the file.
pub(super) struct Residue {
    /// In capitals.
    pub(super) name: String,
    /// Its atoms.
    pub(super) range: Range<usize>,
}

/// The atoms of a file, as far as the rule for ligands reads them.
pub(super) struct Molecules<'a> {
    pub(super) positions: &'a [[f64; 3]],
    pub(super) elements: &'a [u8],
    /// The name of an atom, empty where the file has none.
    pub(super) atom: &'a dyn Fn(usize) -> &'a str,
    /// Whether two atoms are in the same chain.
    pub(super) same_chain: &'a dyn Fn(usize, usize) -> bool,
}

/// The ranges of equal consecutive numbers.
pub(super) fn runs(numbers: &[u32]) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    for run in numbers.chunk_by(|a, b| a == b) {
        let start = runs.last().map_or(0, |last: &Range<usize>| last.end);
        runs.push(start..start + run.len());
    }
    runs
}

impl Molecules<'_> {
    /// The atoms of residues that are ligands: with a name that is none of a protein, nucleic acid, water, ion, lipid,
    /// sugar, cap or additive; of at least six atoms besides hydrogens, with carbon; and not a member of a chain.
    pub(super) fn ligands<'a>(&'a self, residues: &'a [Residue]) -> impl Iterator<Item = Range<usize>> + 'a {
        let is_ligand = move |n: &usize| {
            let Residue { name, range } = &residues[*n];
            let heavy = self.elements[range.clone()].iter().filter(|number| **number != 1).count();
            let before = n.checked_sub(1).map(|before| &residues[before]);
            Self::has_free_name(name.as_bytes())
                && heavy >= LEAST
                && self.elements[range.clone()].contains(&6)
                && !before.is_some_and(|before| self.are_linked(before, &residues[*n]))
                && !residues.get(n + 1).is_some_and(|after| self.are_linked(&residues[*n], after))
        };
        (0..residues.len()).filter(is_ligand).map(|n| residues[n].range.clone())
    }

    fn has_free_name(name: &[u8]) -> bool {
        class(name).is_none() && !is_ion(name) && !ADDITIVES.iter().any(|known| known.as_bytes() == name)
    }

    /// Whether two consecutive residues are linked as in a protein or a nucleic acid: the carbon C of the first to a nitrogen,
    /// any carbon to the nitrogen N of the second, O3' to a phosphorus, any oxygen to the P of the second.
    fn are_linked(&self, first: &Residue, second: &Residue) -> bool {
        if !(self.same_chain)(first.range.start, second.range.start) {
            return false;
        }
        let bond = |a: usize, b: usize| {
            let square = |k: usize| (self.positions[a][k] - self.positions[b][k]).powi(2);
            square(0) + square(1) + square(2) < BOND * BOND
        };
        let is = |n: usize, element: u8, name: &str| {
            self.elements[n] == element && (name.is_empty() || (self.atom)(n) == name)
        };
        let any = |from: (u8, &str), to: (u8, &str)| {
            first
                .range
                .clone()
                .filter(|a| is(*a, from.0, from.1))
                .any(|a| second.range.clone().filter(|b| is(*b, to.0, to.1)).any(|b| bond(a, b)))
        };
        any((6, "C"), (7, "")) || any((6, ""), (7, "N")) || any((8, "O3'"), (15, "")) || any((8, ""), (15, "P"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::element;

    /// The metals of the periodic table as IUPAC's names of groups have it, written out.
    #[test]
    fn metals_are_those_of_the_periodic_table() {
        let others = "H He B C N O F Ne Si P S Cl Ar Ge As Se Br Kr Sb Te I Xe At Rn Og";
        for number in 1..=118 {
            let symbol = element(number).expect("an element").symbol;
            assert_eq!(is_metal(number), !others.split(' ').any(|other| other == symbol), "{symbol}");
        }
    }
}
