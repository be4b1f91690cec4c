//! Messages about selections. Those about the blocks of a file are joined: what holds for every block holds for the file.

use halfline_ground::quote::quote;
use std::collections::HashSet;
use std::fmt;

/// A message about a selection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Note {
    /// The meaning of an expression that may be misread.
    Remark(String),
    /// A word selects nothing.
    Unmatched(Unmatched),
    /// None of so many particles is left.
    NoneLeft(u64),
}

/// A word that selects nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unmatched {
    pub(super) word: String,
    /// The values after the word that no particle has; empty for a word without values.
    pub(super) values: Vec<String>,
    /// The selection, for messages.
    pub(super) selection: String,
    /// Words for what the file has instead; empty where that is not known.
    pub(super) there: String,
}

/// The notes about the blocks of a file so far.
#[derive(Debug, Default)]
pub struct Notes(Option<Vec<Note>>);

impl Notes {
    /// Joins the notes about the next block, which must have particles.
    pub fn join(&mut self, block: Vec<Note>) {
        self.0 = Some(match self.0.take() {
            Some(known) => known.into_iter().filter_map(|note| note.and(&block)).collect(),
            None => block,
        });
    }

    /// The messages that hold for all blocks.
    pub fn messages(&self) -> impl Iterator<Item = String> + '_ {
        self.0.iter().flatten().map(Note::to_string)
    }
}

impl Note {
    /// The part of this note that also holds for another block with these notes; `None` if nothing is left.
    fn and(self, block: &[Self]) -> Option<Self> {
        match self {
            Self::Remark(_) => block.contains(&self).then_some(self),
            Self::Unmatched(word) => word.and(block).map(Self::Unmatched),
            Self::NoneLeft(known) => block.iter().find_map(|note| match note {
                Self::NoneLeft(more) => Some(Self::NoneLeft(known + more)),
                _ => None,
            }),
        }
    }
}

impl Unmatched {
    fn and(mut self, block: &[Note]) -> Option<Self> {
        let others = block.iter().filter_map(|note| match note {
            Note::Unmatched(other) if self.is_like(other) => Some(other),
            _ => None,
        });
        let others: Vec<&Self> = others.collect();
        if others.iter().any(|other| other.there != self.there) {
            self.there.clear();
        }
        if self.values.is_empty() {
            return (!others.is_empty()).then_some(self);
        }
        let theirs: HashSet<&String> = others.iter().flat_map(|other| &other.values).collect();
        self.values.retain(|value| theirs.contains(value));
        (!self.values.is_empty()).then_some(self)
    }

    /// Whether another note is about the same word.
    fn is_like(&self, other: &Self) -> bool {
        let have = |note: &Self| !note.values.is_empty();
        (&self.word, &self.selection, have(self)) == (&other.word, &other.selection, have(other))
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Remark(text) => f.write_str(text),
            Self::NoneLeft(count) => write!(f, "the selections leave none of the {count} particles"),
            Self::Unmatched(Unmatched { word, values, selection, there }) => {
                let (what, more) = match &values[..] {
                    [] => (word.clone(), "is selected by it".to_owned()),
                    [value] => (format!("{word} {value}"), "has it".to_owned()),
                    [value, others @ ..] => {
                        (format!("{word} {value}"), format!("has it, nor {} other values", others.len()))
                    }
                };
                write!(f, "{} in the selection `{selection}`: no particle {more}", quote(&what))?;
                if there.is_empty() { Ok(()) } else { write!(f, "; {there}") }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unmatched(word: &str, values: &[&str], there: &str) -> Note {
        let values = values.iter().map(|value| (*value).to_owned()).collect();
        Note::Unmatched(Unmatched { word: word.into(), values, selection: "s".into(), there: there.into() })
    }

    /// The notes of blocks, joined in this order.
    fn messages(blocks: &[&[Note]]) -> Vec<String> {
        let mut notes = Notes::default();
        blocks.iter().for_each(|block| notes.join(block.to_vec()));
        notes.messages().collect()
    }

    #[test]
    fn what_holds_for_all_blocks_is_reported() {
        let first = [unmatched("type", &["7", "8", "9"], "the file has 1 to 3")];
        let kind = [unmatched("water", &[], "")];
        assert_eq!(
            messages(&[&first, &[unmatched("type", &["9", "7"], "the file has 1 to 4")]]),
            ["`type 7` in the selection `s`: no particle has it, nor 1 other values"]
        );
        assert_eq!(
            messages(&[&first, &first]),
            ["`type 7` in the selection `s`: no particle has it, nor 2 other values; the file has 1 to 3"]
        );
        let apart = [unmatched("type", &["9"], ""), unmatched("type", &["7"], "")];
        assert_eq!(
            messages(&[&first, &apart]),
            ["`type 7` in the selection `s`: no particle has it, nor 1 other values"]
        );
        assert_eq!(messages(&[&kind, &kind]), ["`water` in the selection `s`: no particle is selected by it"]);
        for other in [&kind[..], &[unmatched("type", &["1"], "")], &[unmatched("x", &["7"], "")], &[]] {
            assert!(messages(&[&first, other]).is_empty(), "{other:?}");
        }
        assert!(messages(&[&kind, &[unmatched("water", &["7"], "")]]).is_empty());
    }

    #[test]
    fn all_blocks_are_counted_where_nothing_is_left() {
        let remark = Note::Remark("from left to right".into());
        let none = |count| [remark.clone(), Note::NoneLeft(count)];
        assert_eq!(
            messages(&[&none(3), &none(4)]),
            ["from left to right", "the selections leave none of the 7 particles"]
        );
        assert_eq!(messages(&[&none(3), std::slice::from_ref(&remark), &none(4)]), ["from left to right"]);
        assert!(messages(&[]).is_empty());
    }
}
