//! Elements and virtual sites where a file gives names instead. Atoms are taken one by one and decided residue by residue,
//! for what a name means depends on its neighbours: `CA` is calcium where it is alone and carbon in a chain. Only what
//! depends on the whole file, whether its names stand in the columns of the PDB format, waits until the end.

mod residues;
pub(super) mod rules;
mod species;

pub(in crate::scene) use species::Species;

use crate::quote::quote;
use residues::{Class, class};
use rules::{How, Site};
use std::collections::BTreeMap;

/// Codes of what is not decided or is no element, above all atomic numbers.
const UNKNOWN: u8 = 128;
const VIRTUAL: u8 = u8::MAX;

/// Unknown names that are told apart; the rest counts together.
const NAMES: usize = 16;

/// Bytes that are kept of an atom beside its code, at most, while the list of them doubles.
pub(super) const BYTES: usize = 2 * size_of::<(usize, u8)>();

/// More atoms than any residue has. A file that numbers nothing is one residue; what is known of a part of it will do.
const RESIDUE: usize = 1 << 12;

/// An atom as a file names it.
pub(super) struct Named<'a> {
    /// What stands where an element belongs; empty where nothing does.
    pub(super) symbol: &'a [u8],
    /// The name; in PDB files with its blanks, as the columns have it.
    pub(super) name: &'a [u8],
    /// The residue's name.
    pub(super) residue: &'a [u8],
    /// Whatever tells the residue from the one before it.
    pub(super) site: &'a [u8],
}

/// An atom of the current residue.
struct Member {
    index: usize,
    name: [u8; 8],
    length: u8,
    /// Whether its element is to be found.
    open: bool,
}

impl Member {
    fn raw(&self) -> &[u8] {
        &self.name[..usize::from(self.length)]
    }

    fn name(&self) -> &[u8] {
        self.raw().trim_ascii()
    }
}

/// How names stand in the columns of a PDB file.
#[derive(Default)]
struct Evidence {
    /// Short names that begin in the first column though their symbol has one letter.
    left: u64,
    /// Short names that begin in the second column.
    second: u64,
    /// Symbols of two letters where they belong, and a column too far to the right.
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

    /// Whether names are aligned as the format says.
    fn is_standard(&self) -> bool {
        self.left <= self.second && (self.shifted == 0 || self.placed > 0)
    }
}

/// What was found of a whole model.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Inferred {
    /// Atoms without an element in the file, by [`How`] it was found.
    counts: [u64; 4],
    unknown: u64,
    beads: u64,
    /// Whether PDB names do not stand in their columns.
    astray: bool,
    /// Virtual sites by name.
    sites: BTreeMap<String, u64>,
    /// Names of unknown atoms; the n-th has the code [`UNKNOWN`] + n.
    pub(super) names: Vec<String>,
}

impl Inferred {
    /// What there is to report, of `met` atoms.
    pub(super) fn sentences(&self, met: u64) -> Vec<String> {
        let mut said = Vec::new();
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
            said.push(format!(
                "the file gives no element for {named} of {met} atoms; inferred: {}{astray}",
                ways.join(", ")
            ));
        }
        if self.beads > 0 {
            said.push(format!("{} particles are beads of a coarse-grained model, not atoms", self.beads));
        }
        if !self.sites.is_empty() {
            let total: u64 = self.sites.values().sum();
            let mut names: Vec<String> =
                self.sites.iter().take(NAMES).map(|(name, n)| format!("{n} {}", quote(name))).collect();
            if self.sites.len() > NAMES {
                names.push("others".into());
            }
            said.push(format!("{total} virtual sites are left out ({}): they are no atoms", names.join(", ")));
        }
        said
    }

    /// How many particles are no atoms and are left out.
    pub(super) fn sites(&self) -> u64 {
        self.sites.values().sum()
    }
}

/// Finds elements. The caller keeps them; codes above all atomic numbers stand for what is not decided.
#[derive(Default)]
pub(super) struct Inference {
    /// Whether names have the columns of the PDB format.
    columns: bool,
    site: Vec<u8>,
    residue: Vec<u8>,
    members: Vec<Member>,
    open: usize,
    evidence: Evidence,
    /// Atoms that columns and names tell differently: what the name tells.
    late: Vec<(usize, u8)>,
    /// Atoms that both tell alike.
    alike: u64,
    found: Inferred,
}

impl Inference {
    /// `columns` says whether names come with the four columns of the PDB format.
    pub(super) fn new(columns: bool) -> Self {
        Self { columns, ..Self::default() }
    }

    /// Takes the atom that follows the last of `elements` and appends it there.
    pub(super) fn push(&mut self, atom: &Named<'_>, elements: &mut Vec<u8>) {
        if self.site != atom.site || self.residue != atom.residue || self.members.len() == RESIDUE {
            self.decide(elements);
            self.site.clear();
            self.site.extend(atom.site);
            self.residue.clear();
            self.residue.extend(atom.residue);
        }
        let symbol = rules::of_symbol(atom.symbol);
        let mut member = Member { index: elements.len(), name: [0; 8], length: 0, open: symbol == 0 };
        // Longer names are told apart well enough by their beginning.
        let length = atom.name.len().min(member.name.len());
        member.name[..length].copy_from_slice(&atom.name[..length]);
        member.length = length as u8;
        self.open += usize::from(member.open);
        elements.push(symbol);
        // `X` says that nobody knows.
        if member.open && atom.symbol.trim_ascii().eq_ignore_ascii_case(b"X") && !is_virtual(member.name(), None) {
            member.open = false;
            self.open -= 1;
            elements[member.index] = self.unknown(b"X");
            self.found.unknown += 1;
        }
        self.members.push(member);
    }

    /// Decides what is left. Virtual sites have the code that [`is_site`] knows, unknown atoms are numbered by their names.
    pub(super) fn finish(mut self, elements: &mut [u8]) -> Inferred {
        self.decide(elements);
        let standard = self.evidence.is_standard();
        let how = if standard { How::Columns } else { How::Name };
        self.found.counts[how as usize] += self.alike;
        self.found.astray = !standard;
        for (index, by_name) in std::mem::take(&mut self.late) {
            if !standard {
                elements[index] = by_name;
            }
            match elements[index] < UNKNOWN {
                true => self.found.counts[how as usize] += 1,
                false => self.found.unknown += 1,
            }
        }
        self.found
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

    fn decide_one(&mut self, member: &Member, residue: &Residue) -> u8 {
        let name = member.name();
        let (site, how) = residue.site(name);
        if self.columns {
            let known = if let Site::Element(element) = site { Some(element) } else { None };
            self.evidence.take(member.raw(), known);
        }
        let code = match site {
            Site::Virtual => {
                let name = String::from_utf8_lossy(name).into_owned();
                let full = self.found.sites.len() > RESIDUE && !self.found.sites.contains_key(&name);
                *self.found.sites.entry(if full { "others".into() } else { name }).or_default() += 1;
                return VIRTUAL;
            }
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
            None if code < UNKNOWN => self.found.counts[How::Name as usize] += 1,
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

/// Whether this code is a virtual site's.
pub(super) fn is_site(code: u8) -> bool {
    code == VIRTUAL
}

/// The place of an unknown atom's name in [`Inferred::names`].
pub(super) fn unknown(code: u8) -> Option<usize> {
    (code >= UNKNOWN && code != VIRTUAL).then(|| usize::from(code - UNKNOWN))
}

/// What is known of a residue as a whole.
struct Residue {
    name: Vec<u8>,
    class: Option<Class>,
    /// Whether all its atoms have one name.
    alone: bool,
    /// Whether it is coarse-grained.
    beads: bool,
    /// Whether it has the particles that the Drude model adds to heavy atoms.
    drude: bool,
    /// Whether it has the atoms of a chain's backbone.
    chain: bool,
    /// Whether its names do not stand in the columns of the PDB format.
    astray: bool,
}

impl Residue {
    fn of(members: &[Member], name: &[u8], columns: bool) -> Self {
        let name = name.trim_ascii().to_ascii_uppercase();
        let has = |wanted: &[u8]| members.iter().any(|member| member.name() == wanted);
        let first = members.first().map(Member::name).unwrap_or_default();
        let alone = members.iter().all(|member| member.name() == first);
        let class = class(&name);
        // No atomistic model calls an atom so.
        let beads =
            ["BB", "BAS", "BB1", "GL1", "GL2", "PO4", "NC3", "ROH", "AM1"].iter().any(|bead| has(bead.as_bytes()))
                || class == Some(Class::Bead);
        let mut evidence = Evidence::default();
        if columns {
            members.iter().for_each(|member| evidence.take(member.raw(), None));
        }
        let drude = members.iter().any(|member| member.name().starts_with(b"D")) && is_drude(members);
        let chain = has(b"CA") && (has(b"N") || has(b"C") || has(b"CB"));
        Self { name, class, alone, beads, drude, chain, astray: evidence.left > evidence.second }
    }

    /// What stands at an atom's place, where it does not depend on columns, and which rule says so.
    fn site(&self, name: &[u8]) -> (Site, How) {
        if is_virtual(name, self.class) || self.drude && name.starts_with(b"D") {
            return (Site::Virtual, How::Name);
        }
        if self.beads {
            return (Site::Bead, How::Name);
        }
        if let Some(element) = self.alone.then(|| rules::ion(name, &self.name, self.class)).flatten() {
            return (Site::Element(element), How::Ion);
        }
        if let Some(element) = self.class.and_then(|_| rules::in_residue(name, &self.name)) {
            return (Site::Element(element), How::Residue);
        }
        // In a chain, or in a trace of one: a residue of calcium alone is called so.
        if name == b"CA" && (self.chain || self.alone) {
            return (Site::Element(6), How::Name);
        }
        (Site::Unknown, How::Name)
    }
}

/// Massless sites of force fields: charges of water models beside the oxygen (`MW` of GROMACS, `OM` of CHARMM, `EPW` of AMBER,
/// `LP1`), lone pairs of halogens (`LP`), dummies around metals (`DM1`), masses of rigid groups in GROMACS (`MCB1`),
/// pseudo-atoms of NMR (`QB`).
fn is_virtual(name: &[u8], class: Option<Class>) -> bool {
    let letters = rules::letters(name).to_ascii_uppercase();
    match &letters[..] {
        b"MW" | b"EP" | b"EPW" | [b'L', b'P', ..] => true,
        b"DM" | b"DU" | b"DUM" => class.is_none(),
        b"M" | b"OM" | b"IW" | b"L" => class == Some(Class::Water),
        [b'M' | b'Q', ..] => class == Some(Class::Protein),
        _ => false,
    }
}

/// Whether most heavy atoms of a residue have a partner named as they are behind a D. Deuterium is named as the hydrogen
/// it stands for, behind whose first letter no heavy atom's name is left.
fn is_drude(members: &[Member]) -> bool {
    let mut names: Vec<&[u8]> = members.iter().map(Member::name).collect();
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
