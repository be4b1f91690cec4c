//! Elements from a column of symbols that contains atom names: `HB1`, `CA`, `OW`, as programs write them to XYZ files.
//! A name of two capital letters may also be a symbol; it is not one where other words with its first letter, or with
//! carbon's, can only be names.

use super::{NAMES, is_virtual, rules};
use crate::elements::{atomic_number, element};
use halfline_ground::quote::{count, quote};
use std::collections::BTreeMap;

/// Codes above all atomic numbers: a symbol that may be a name is its atomic number plus [`UNSURE`]; a virtual site has
/// its own.
const UNSURE: u8 = 128;
const SITE: u8 = u8::MAX;

/// The content of a species column besides symbols.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Species {
    /// Names that are not symbols, counted by their first letter from A, and some of them.
    named: [u64; 26],
    names: BTreeMap<String, u64>,
    /// Virtual sites by name.
    sites: BTreeMap<String, u64>,
    /// Whether there are symbols that may be names.
    unsure: bool,
}

impl Species {
    /// The code of a word: a symbol, optionally with a number or a charge after it (`C12`), an atomic number, or a
    /// name; 0 for anything else.
    pub(crate) fn code(&mut self, word: &str) -> u8 {
        if let Ok(number) = word.parse::<u8>() {
            return element(number).map_or(0, |_| number);
        }
        let letters = word.trim_end_matches(|c: char| c.is_ascii_digit() || "+-_*'".contains(c));
        let number = atomic_number(letters);
        let capital = letters.bytes().all(|byte| byte.is_ascii_uppercase());
        // Elements beyond lawrencium do not occur; `SG` and `CN` are names.
        if number > 0 && !(capital && number > 103) {
            let name = if capital && letters.len() == 2 { rules::of_name(letters.as_bytes()) } else { 0 };
            let unsure = name > 0 && name != number;
            self.unsure |= unsure;
            return if unsure { UNSURE + number } else { number };
        }
        if is_virtual(word.as_bytes(), None) {
            tally(&mut self.sites, word, 1);
            return SITE;
        }
        // Names of three letters and more are as often words with other meanings.
        let letters = word.trim_matches(|c: char| c.is_ascii_digit() || "'*".contains(c));
        let capital = letters.bytes().all(|byte| byte.is_ascii_uppercase());
        let name = capital && (letters.len() == 2 || ["OXT", "HXT"].contains(&letters)) && word.len() <= 5;
        let number = if name { rules::of_name(letters.as_bytes()) } else { 0 };
        if number > 0 {
            self.named[usize::from(letters.as_bytes()[0] - b'A')] += 1;
            tally(&mut self.names, word, 1);
        }
        number
    }

    /// Adds the counts of another part of the file.
    pub(crate) fn add(&mut self, other: Self) {
        self.named.iter_mut().zip(other.named).for_each(|(count, more)| *count += more);
        self.unsure |= other.unsure;
        other.names.iter().for_each(|(name, n)| tally(&mut self.names, name, *n));
        other.sites.iter().for_each(|(name, n)| tally(&mut self.sites, name, *n));
    }

    /// Turns codes into atomic numbers, except codes of virtual sites. Returns the messages, and whether there are
    /// virtual sites.
    pub(crate) fn settle(self, codes: &mut [u8]) -> (Vec<String>, bool) {
        let mut names = 0_u64;
        if self.unsure {
            for code in codes.iter_mut().filter(|code| is_unsure(**code)) {
                let (number, is_name) = self.decide(*code);
                names += u64::from(is_name);
                *code = number;
            }
        }
        (self.messages(codes.len() as u64, names), !self.sites.is_empty())
    }

    /// The same for the number of particles of each code, virtual sites not among them. Returns the messages.
    pub(crate) fn settle_counts(self, counts: &mut [u64; 256]) -> Vec<String> {
        let total = counts.iter().sum::<u64>() + self.sites.values().sum::<u64>();
        let mut names = 0_u64;
        for code in (0..=u8::MAX).filter(|code| is_unsure(*code)) {
            let count = std::mem::take(&mut counts[usize::from(code)]);
            let (number, is_name) = self.decide(code);
            names += if is_name { count } else { 0 };
            counts[usize::from(number)] += count;
        }
        self.messages(total, names)
    }

    /// The atomic number of a symbol that may be a name, and whether it is one.
    fn decide(&self, code: u8) -> (u8, bool) {
        let carbon = self.named[usize::from(b'C' - b'A')] > 0;
        let number = code - UNSURE;
        let symbol = element(number).map_or("", |element| element.symbol);
        let first = symbol.bytes().next().map_or(0, |letter| usize::from(letter - b'A'));
        // Where carbons have names, nitrogens do too; but sodium is more common than the nitrogen NA of haem.
        let named = number != 11 && (carbon || self.named[first] > 0);
        (if named { rules::of_name(symbol.to_ascii_uppercase().as_bytes()) } else { number }, named)
    }

    /// The messages about `of` particles; `names` of them have symbols that are names.
    fn messages(&self, of: u64, names: u64) -> Vec<String> {
        let mut messages = Vec::new();
        let named: u64 = self.named.iter().sum();
        if named > 0 {
            let some = listed(&self.names);
            let also = if names > 0 {
                format!(", and so are {names} that could be symbols, such as CA")
            } else {
                String::new()
            };
            messages.push(format!(
                "{named} of {of} species are atom names and not symbols ({some}){also}; elements are inferred from their first letters"
            ));
        }
        if !self.sites.is_empty() {
            let total: u64 = self.sites.values().sum();
            messages.push(format!("{} left out ({})", count(total, "virtual site"), listed(&self.sites)));
        }
        messages
    }
}

/// Whether a code stands for a symbol that may be a name.
fn is_unsure(code: u8) -> bool {
    code > UNSURE && code != SITE
}

/// Counts a name; the number of different names is limited.
fn tally(names: &mut BTreeMap<String, u64>, name: &str, n: u64) {
    let full = names.len() >= NAMES && !names.contains_key(name);
    *names.entry(if full { "others" } else { name }.to_owned()).or_default() += n;
}

fn listed(names: &BTreeMap<String, u64>) -> String {
    names.iter().map(|(name, n)| format!("{n} {}", quote(name))).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn symbols(words: &str) -> (String, Vec<String>) {
        let mut all = Species::default();
        let mut codes = Vec::new();
        // In two parts, as files are read.
        for words in words.split('|') {
            let mut species = Species::default();
            codes.extend(words.split(' ').filter(|word| !word.is_empty()).map(|word| species.code(word)));
            all.add(species);
        }
        let (messages, _) = all.settle(&mut codes);
        let symbol = |code: &u8| if *code == SITE { "-" } else { element(*code).map_or("?", |element| element.symbol) };
        (codes.iter().map(symbol).collect::<Vec<_>>().join(" "), messages)
    }

    #[test]
    fn symbols_are_parsed() {
        for (words, expected) in [
            ("C H1 Cl2 Cu2+ 26 D Xx 0 Ca", "C H Cl Cu Fe H ? ? Ca"),
            ("CA CL NA HG CD ZN", "Ca Cl Na Hg Cd Zn"),
            ("ca na", "Ca Na"),
            ("A B LJ1 POL SOL type1 CORE", "? B ? ? ? ? ?"),
            ("O_3 C_R Zn3+2", "O ? Zn"),
        ] {
            assert_eq!(symbols(words), (expected.to_owned(), vec![]), "{words}");
        }
    }

    #[test]
    fn atom_names_among_the_species_decide_similar_names() {
        let (found, messages) = symbols("N HN CA HA CB 1HB2|HG CG CD ND1 CE1 O OXT OT1 CL SG NA");
        assert_eq!(found, "N H C H C H H C C N C O O O Cl S Na");
        assert!(messages[0].starts_with("8 of 17 species are atom names"), "{messages:?}");
        assert!(messages[0].contains("and so are 5 that could be symbols"), "{messages:?}");
        // The names of water say nothing about metals with other first letters.
        let (found, messages) = symbols("OW HW1 HW2 MW|CA NA CL OW HW1 HW2 MW");
        assert_eq!(found, "O H H - Ca Na Cl O H H -");
        assert_eq!(messages[1], "2 virtual sites left out (2 `MW`)");
    }
}
