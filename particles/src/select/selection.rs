//! A selection: an expression and its text.

use super::columns::{Key, keys};
use super::expression::{Kind, Node, Operation};
use super::grammar;
use super::note::Note;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::{Quote, shortened};
use std::fmt;
use std::str::FromStr;

/// An expression that selects particles, parsed from text.
#[derive(Debug, Clone, PartialEq)]
pub struct Selection {
    text: String,
    /// Its name for readers of a legend.
    caption: Option<String>,
    pub(super) root: Node,
}

impl Selection {
    /// The columns of a file that the expression reads, in lower case; a file has some of them.
    pub(crate) fn columns(&self) -> Vec<String> {
        let mut columns: Vec<String> = Vec::new();
        self.root.visit(&mut |node| {
            let word = match node {
                Node::Values(column, _) | Node::Same(column, _) => Key::of(column),
                Node::Compare(comparison) => Key::of(&comparison.column),
                Node::Kind(kind) => Key::Kind(*kind),
                _ => return,
            };
            for name in keys(&word) {
                if !columns.contains(&name) {
                    columns.push(name);
                }
            }
        });
        columns
    }

    /// The columns, in lower case, whose values it lists.
    pub(crate) fn worded_columns(&self) -> Vec<String> {
        let mut columns = Vec::new();
        self.root.visit(&mut |node| {
            if let Node::Values(column, _) = node {
                columns.extend(keys(&Key::of(column)));
            }
        });
        columns
    }

    /// The same with a caption.
    #[must_use]
    pub fn captioned(self, caption: &str) -> Self {
        Self { caption: Some(caption.to_owned()), ..self }
    }

    /// The name of the selection in a legend: its caption, else the expression.
    #[must_use]
    pub fn label(&self) -> &str {
        self.caption.as_ref().unwrap_or(&self.text)
    }

    /// The caption, if it has one.
    #[must_use]
    pub fn caption(&self) -> Option<&str> {
        self.caption.as_deref()
    }

    /// The expression for messages: a long one is shortened.
    pub fn brief(&self) -> Quote<'_> {
        shortened(&self.text, 120)
    }

    /// Remarks on the meaning of the expression where other programs, or the user, may read it differently.
    pub(super) fn remarks(&self) -> Vec<Note> {
        let mut remarks = Vec::new();
        let loose =
            |node: &Node| matches!(node, Node::Near(near) if near.itself && !matches!(*near.of, Node::Group(_)));
        self.root.visit(&mut |node| {
            let Node::Chain(first, rest) = node else { return };
            let or = rest.iter().position(|(operation, _)| *operation == Operation::Or);
            if or.is_some_and(|at| rest[at..].iter().any(|(operation, _)| *operation == Operation::And)) {
                remarks.push(format!(
                    "the selection `{}` combines `or` and a later `and` from left to right, as MDAnalysis does; VMD combines `and` first; use parentheses",
                    self.brief()
                ));
            }
            let parts = std::iter::once(&**first).chain(rest.iter().map(|(_, part)| part));
            if parts.take(rest.len()).any(loose) {
                remarks.push(format!(
                    "in the selection `{}`, `within` applies to the next word only; use parentheses: within 5 of (...)",
                    self.brief()
                ));
            }
        });
        remarks.into_iter().map(Note::Remark).collect()
    }

    /// The first word by which a particle is selected because of others; `None` where each is selected by itself.
    pub fn word_for_several(&self) -> Option<&'static str> {
        let mut found = None;
        self.root.visit(&mut |node| {
            let word = match node {
                Node::Near(near) if near.itself => "within",
                Node::Near(_) => "around",
                Node::Same(..) => "same",
                Node::Kind(kind @ Kind::Ligand) => kind.word(),
                _ => return,
            };
            found.get_or_insert(word);
        });
        found
    }
}

impl fmt::Display for Selection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for Selection {
    type Err = Error;

    /// Parses an expression.
    ///
    /// # Errors
    /// [`Error::Settings`] with the column of the first character that does not fit.
    fn from_str(text: &str) -> Result<Self> {
        grammar::parse(text).map(|root| Self { text: text.trim().to_owned(), caption: None, root })
    }
}
