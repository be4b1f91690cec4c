//! Infers elements and virtual sites from names. Atoms are added one by one and decided residue by residue, because the
//! meaning of a name depends on its neighbours: `CA` is calcium where it is alone and carbon in a chain. Whether names
//! are aligned in the columns of the PDB format depends on the whole file and is decided at the end.

pub(crate) mod residues;
pub(crate) mod rules;
pub mod slices;
pub(super) mod species;

use super::names::is_same;
use halfline_ground::quote::{count, quote};
use residues::{ResidueClass, class};
use rules::{InferenceRule, Site};
use std::collections::BTreeMap;

/// Codes of atoms that are undecided or not elements, above all atomic numbers.
const UNKNOWN: u8 = 128;
const VIRTUAL: u8 = u8::MAX;

/// The code of counted atoms for which columns and name give different elements; unknown names have lower ones.
const LATE: u8 = VIRTUAL - 1;

/// The most unknown names that are counted separately; the others are counted together.
const NAMES: usize = 16;

/// The most bytes per atom, besides its code, while the list of them grows.
pub(super) const BYTES: usize = 2 * size_of::<(usize, u8)>();

/// The most atoms in a residue. A file without residue numbers is one residue, and a part of it is sufficient.
const RESIDUE: usize = 1 << 12;

/// The names of an atom.
pub(crate) struct AtomNames<'a> {
    /// The content of the element column; may be empty.
    pub(crate) symbol: &'a [u8],
    /// The name; in PDB files with its blanks.
    pub(crate) name: &'a [u8],
    /// The residue's name.
    pub(crate) residue: &'a [u8],
    /// Everything that distinguishes the residue from the one before it.
    pub(crate) site: &'a [u8],
}

/// An atom of the current residue.
struct ResidueAtom {
    index: usize,
    name: [u8; 8],
    length: u8,
    /// Whether its element is to be inferred.
    open: bool,
}

impl ResidueAtom {
    fn raw(&self) -> &[u8] {
        &self.name[..usize::from(self.length)]
    }

    fn name(&self) -> &[u8] {
        self.raw().trim_ascii()
    }
}

/// Statistics on how names are aligned in the columns of a PDB file.
#[derive(Default)]
struct Evidence {
    /// Short names that begin in the first column although their symbol has one letter.
    left: u64,
    /// Short names that begin in the second column.
    second: u64,
    /// Symbols of two letters in the right columns, and one column too far to the right.
    placed: u64,
    shifted: u64,
}

impl Evidence {
    fn take(&mut self, name: &[u8], element: Option<u8>) {
        let &[first, second, third, b' '] = name else { return };
        let short = |a: u8, b: u8| rules::of_symbol(&[a, b]);
        if first.is_ascii_alphabetic() {
            let pair = if second.is_ascii_alphabetic() { short(first, second) } else { 0 };
            match element {
                _ if pair == 0 => self.left += 1,
                Some(element) if element == pair => self.placed += 1,
                Some(_) => self.left += 1,
                None => {}
            }
        } else if second.is_ascii_alphabetic() {
            let pair = if third.is_ascii_alphabetic() { short(second, third) } else { 0 };
            if pair > 0 && element == Some(pair) {
                self.shifted += 1;
            } else {
                self.second += 1;
            }
        }
    }

    /// Whether names are aligned as in the format.
    fn is_standard(&self) -> bool {
        self.left <= self.second && (self.shifted == 0 || self.placed > 0)
    }
}

/// The result for a whole model.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Inferred {
    /// Atoms without an element in the file, by [`InferenceRule`] it was found.
    counts: [u64; 4],
    unknown: u64,
    beads: u64,
    /// Whether PDB names are not in their columns.
    astray: bool,
    /// Virtual sites by name.
    sites: BTreeMap<String, u64>,
    /// Names of unknown atoms; the n-th has the code [`UNKNOWN`] + n.
    pub(super) names: Vec<String>,
}

impl Inferred {
    /// The messages about a model of a file with `met` atoms.
    pub(super) fn sentences(&self, met: u64) -> Vec<String> {
        self.sentences_of("the file", met)
    }

    /// The messages about a model with `met` atoms of this origin.
    fn sentences_of(&self, origin: &str, met: u64) -> Vec<String> {
        let mut messages = Vec::new();
        let named: u64 = self.counts.iter().sum::<u64>() + self.unknown;
        if named > 0 {
            let ways =
                ["from known residues", "as single ions", "from the columns of their names", "from their names alone"];
            let ways = ways.iter().zip(self.counts).filter(|(_, count)| *count > 0);
            let mut ways: Vec<String> = ways.map(|(way, count)| format!("{count} {way}")).collect();
            if self.unknown > 0 {
                ways.push(format!("{} unknown", self.unknown));
            }
            let astray = if self.astray { "; names are not in the columns of the PDB format" } else { "" };
            messages.push(format!(
                "{origin} gives no element for {named} of {met} atoms; inferred: {}{astray}",
                ways.join(", ")
            ));
        }
        if self.beads > 0 {
            messages.push(format!("{} particles are beads of a coarse-grained model, not atoms", self.beads));
        }
        if !self.sites.is_empty() {
            let total: u64 = self.sites.values().sum();
            let mut names: Vec<String> =
                self.sites.iter().take(NAMES).map(|(name, n)| format!("{n} {}", quote(name))).collect();
            if self.sites.len() > NAMES {
                names.push("others".into());
            }
            messages.push(format!("{} left out ({})", count(total, "virtual site"), names.join(", ")));
        }
        messages
    }

    /// The number of particles that are not atoms and are left out.
    pub(super) fn sites(&self) -> u64 {
        self.sites.values().sum()
    }
}

/// Infers elements. The caller stores them; codes above all atomic numbers mark undecided atoms.
#[derive(Default)]
pub(crate) struct Inference {
    /// Whether names have the columns of the PDB format.
    pub(super) columns: bool,
    site: Vec<u8>,
    residue: Vec<u8>,
    members: Vec<ResidueAtom>,
    open: usize,
    evidence: Evidence,
    /// Atoms for which columns and name give different elements: the name's element.
    late: Vec<(usize, u8)>,
    /// The number of such atoms in the parts that were counted, by both codes.
    counted: BTreeMap<(u8, u8), u64>,
    /// Atoms for which both give the same.
    alike: u64,
    found: Inferred,
}

impl Inference {
    /// `columns` says whether names include the four columns of the PDB format.
    pub(crate) fn new(columns: bool) -> Self {
        Self { columns, ..Self::default() }
    }

    /// Adds the atom after the last of `elements` and appends its code there.
    pub(super) fn push(&mut self, atom: &AtomNames<'_>, elements: &mut Vec<u8>) {
        if self.decides_before(atom) {
            self.decide(elements);
            self.site.clear();
            self.site.extend(atom.site);
            self.residue.clear();
            self.residue.extend(atom.residue);
        }
        let symbol = rules::of_symbol(atom.symbol);
        let mut member = ResidueAtom { index: elements.len(), name: [0; 8], length: 0, open: symbol == 0 };
        // The beginning of a longer name is distinctive enough.
        let length = atom.name.len().min(member.name.len());
        member.name[..length].copy_from_slice(&atom.name[..length]);
        member.length = length as u8;
        self.open += usize::from(member.open);
        elements.push(symbol);
        // `X` means that the element is unknown.
        if member.open && atom.symbol.trim_ascii().eq_ignore_ascii_case(b"X") && !is_virtual(member.name(), None) {
            member.open = false;
            self.open -= 1;
            elements[member.index] = self.unknown(b"X");
            self.found.unknown += 1;
        } else if member.open && is_virtual(atom.symbol.trim_ascii(), None) {
            // The file says so itself, whatever the name is: `EP` of OpenMM's water of five sites.
            member.open = false;
            self.open -= 1;
            elements[member.index] = self.virtual_site(member.name());
        }
        self.members.push(member);
    }

    /// Whether the atoms so far are decided without this one, because it begins another residue.
    pub(super) fn decides_before(&self, atom: &AtomNames<'_>) -> bool {
        !is_same(&self.site, atom.site) || !is_same(&self.residue, atom.residue) || self.members.len() == RESIDUE
    }

    /// Ends a part of the atoms, whose codes are counted before the list is emptied.
    pub(super) fn end_part(&mut self, elements: &mut [u8]) {
        self.decide(elements);
        for (index, by_name) in std::mem::take(&mut self.late) {
            *self.counted.entry((elements[index], by_name)).or_default() += 1;
            elements[index] = LATE;
        }
    }

    /// [`Inference::finish`] for the number of atoms of each code, all of whose parts have ended. Virtual sites are not
    /// among them.
    pub(super) fn finish_counts(mut self, counts: &mut [u64; 256]) -> Inferred {
        let (standard, how) = self.alignment();
        counts[usize::from(LATE)] = 0;
        for ((by_columns, by_name), count) in std::mem::take(&mut self.counted) {
            let code = if standard { by_columns } else { by_name };
            counts[usize::from(code)] += count;
            self.count_late(code, how, count);
        }
        self.found
    }

    /// Decides the remaining atoms. Virtual sites have the code of [`is_site`], unknown atoms are numbered by their
    /// names.
    pub(super) fn finish(mut self, elements: &mut [u8]) -> Inferred {
        self.decide(elements);
        let (standard, how) = self.alignment();
        for (index, by_name) in std::mem::take(&mut self.late) {
            if !standard {
                elements[index] = by_name;
            }
            self.count_late(elements[index], how, 1);
        }
        self.found
    }

    /// Whether names are aligned as in the format, and the rule for atoms whose columns count therefore.
    fn alignment(&mut self) -> (bool, InferenceRule) {
        let standard = self.evidence.is_standard();
        let how = if standard { InferenceRule::Columns } else { InferenceRule::Name };
        self.found.counts[how as usize] += self.alike;
        self.found.astray = !standard;
        (standard, how)
    }

    fn count_late(&mut self, code: u8, how: InferenceRule, count: u64) {
        match code < UNKNOWN {
            true => self.found.counts[how as usize] += count,
            false => self.found.unknown += count,
        }
    }

    /// Decides the atoms of the current residue.
    fn decide(&mut self, elements: &mut [u8]) {
        let members = std::mem::take(&mut self.members);
        if std::mem::take(&mut self.open) > 0 {
            let residue = Residue::of(&members, &self.residue, self.columns);
            for member in members.iter().filter(|member| member.open) {
                elements[member.index] = self.decide_one(member, &residue);
            }
        }
        self.members = members;
        self.members.clear();
    }

    /// Counts a virtual site; its code.
    fn virtual_site(&mut self, name: &[u8]) -> u8 {
        let name = String::from_utf8_lossy(name).into_owned();
        let full = self.found.sites.len() > RESIDUE && !self.found.sites.contains_key(&name);
        *self.found.sites.entry(if full { "others".into() } else { name }).or_default() += 1;
        VIRTUAL
    }

    fn decide_one(&mut self, member: &ResidueAtom, residue: &Residue) -> u8 {
        let name = member.name();
        let (site, how) = residue.site(name);
        if self.columns {
            let known = if let Site::Element(element) = site { Some(element) } else { None };
            self.evidence.take(member.raw(), known);
        }
        let code = match site {
            Site::Virtual => return self.virtual_site(name),
            Site::Bead => {
                self.found.beads += 1;
                return self.unknown(name);
            }
            Site::Element(element) => {
                self.found.counts[how as usize] += 1;
                return element;
            }
            Site::Unknown => match rules::of_name(name) {
                0 => self.unknown(name),
                element => element,
            },
        };
        let by_columns = if self.columns && !residue.astray { rules::of_columns(member.raw()) } else { None };
        match by_columns {
            Some(element) if element == code => self.alike += 1,
            Some(element) => {
                self.late.push((member.index, code));
                return element;
            }
            None if code < UNKNOWN => self.found.counts[InferenceRule::Name as usize] += 1,
            None => self.found.unknown += 1,
        }
        code
    }

    fn unknown(&mut self, name: &[u8]) -> u8 {
        let name = String::from_utf8_lossy(name);
        let names = &mut self.found.names;
        let slot = names.iter().position(|known| *known == name).unwrap_or_else(|| {
            let name = if names.len() < NAMES { &name } else { "others" };
            if names.last().is_none_or(|last| last != name) {
                names.push(name.to_owned());
            }
            names.len() - 1
        });
        UNKNOWN + slot as u8
    }
}

/// Whether this code means a virtual site.
pub(super) fn is_site(code: u8) -> bool {
    code == VIRTUAL
}

/// The code of the unknown atoms whose name has this index in [`Inferred::names`].
pub(super) fn code_of_unknown(slot: usize) -> usize {
    usize::from(UNKNOWN) + slot
}

/// The index of an unknown atom's name in [`Inferred::names`].
pub(super) fn unknown(code: u8) -> Option<usize> {
    (code >= UNKNOWN && code != VIRTUAL).then(|| usize::from(code - UNKNOWN))
}

/// Properties of a residue as a whole, by which the sites of its atoms are decided.
struct Residue {
    name: Vec<u8>,
    class: Option<ResidueClass>,
    /// Whether all its atoms have the same name.
    alone: bool,
    /// Whether it is coarse-grained.
    beads: bool,
    /// Whether it has Drude particles on heavy atoms.
    drude: bool,
    /// Whether it has the backbone atoms of a chain.
    chain: bool,
    /// Whether its names are not in the columns of the PDB format.
    astray: bool,
}

impl Residue {
    fn of(members: &[ResidueAtom], name: &[u8], columns: bool) -> Self {
        let name = name.trim_ascii().to_ascii_uppercase();
        let has = |name: &[u8]| members.iter().any(|member| member.name() == name);
        let first = members.first().map(ResidueAtom::name).unwrap_or_default();
        let alone = members.iter().all(|member| member.name() == first);
        let class = class(&name);
        // Atomistic models do not use these names.
        let beads =
            ["BB", "BAS", "BB1", "GL1", "GL2", "PO4", "NC3", "ROH", "AM1"].iter().any(|bead| has(bead.as_bytes()))
                || class == Some(ResidueClass::Bead);
        let mut evidence = Evidence::default();
        if columns {
            members.iter().for_each(|member| evidence.take(member.raw(), None));
        }
        let drude = members.iter().any(|member| member.name().starts_with(b"D")) && is_drude(members);
        let chain = has(b"CA") && (has(b"N") || has(b"C") || has(b"CB"));
        Self { name, class, alone, beads, drude, chain, astray: evidence.left > evidence.second }
    }

    /// The site of a name and the rule that gives it, where it does not depend on columns.
    fn site(&self, name: &[u8]) -> (Site, InferenceRule) {
        if is_virtual(name, self.class) || self.drude && name.starts_with(b"D") {
            return (Site::Virtual, InferenceRule::Name);
        }
        if self.beads {
            return (Site::Bead, InferenceRule::Name);
        }
        if let Some(element) = self.alone.then(|| rules::ion(name, &self.name, self.class)).flatten() {
            return (Site::Element(element), InferenceRule::Ion);
        }
        if let Some(element) = self.class.and_then(|_| rules::in_residue(name, &self.name)) {
            return (Site::Element(element), InferenceRule::Residue);
        }
        // In a chain, or in a trace of one; the residue of a calcium ion has its name.
        if name == b"CA" && (self.chain || self.alone) {
            return (Site::Element(6), InferenceRule::Name);
        }
        (Site::Unknown, InferenceRule::Name)
    }
}

/// Massless sites of force fields: charges of water models beside the oxygen (`MW` of GROMACS, `OM` of CHARMM, `EPW` of
/// AMBER, `LP1`), lone pairs of halogens (`LP`), dummies around metals (`DM1`), masses of rigid groups in GROMACS
/// (`MCB1`), pseudo-atoms of NMR (`QB`).
fn is_virtual(name: &[u8], class: Option<ResidueClass>) -> bool {
    let letters = rules::letters(name).to_ascii_uppercase();
    match &letters[..] {
        b"MW" | b"EP" | b"EPW" | [b'L', b'P', ..] => true,
        b"DM" | b"DU" | b"DUM" => class.is_none(),
        b"M" | b"OM" | b"IW" | b"L" => class == Some(ResidueClass::Water),
        [b'M' | b'Q', ..] => class == Some(ResidueClass::Protein),
        _ => false,
    }
}

/// Whether most heavy atoms of a residue have a partner with the same name after a D. Deuterium has the name of the
/// hydrogen that it replaces, in which no heavy atom's name follows the first letter.
fn is_drude(members: &[ResidueAtom]) -> bool {
    let mut names: Vec<&[u8]> = members.iter().map(ResidueAtom::name).collect();
    names.sort_unstable();
    let heavy = |name: &&&[u8]| matches!(rules::letters(name).first(), Some(b'C' | b'N' | b'O' | b'S' | b'P'));
    let (mut atoms, mut pairs) = (0, 0);
    for name in names.iter().filter(heavy) {
        let partner = [b"D", *name].concat();
        atoms += 1;
        pairs += usize::from(names.binary_search(&&partner[..]).is_ok());
    }
    pairs > 0 && 2 * pairs >= atoms
}

#[cfg(test)]
mod tests;
