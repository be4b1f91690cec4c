//! The parts of a selection.

/// An expression or a part of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Node {
    All,
    None,
    Not(Box<Node>),
    /// In parentheses.
    Group(Box<Node>),
    /// Combined from left to right, as in MDAnalysis.
    Chain(Box<Node>, Vec<(Operation, Node)>),
    /// A kind of molecule, residue or atom.
    Kind(Kind),
    /// A column has one of these values.
    Values(String, Vec<Value>),
    Compare(Comparison),
    Near(Near),
    /// Particles whose value in this column, or whose residue, a selected particle has.
    Same(String, Box<Node>),
}

/// The operation that combines two parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operation {
    And,
    Or,
}

/// Words for residues and atoms by their names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Protein,
    Nucleic,
    Water,
    Ion,
    /// N, CA, C and O of a protein.
    Backbone,
    Hydrogen,
    /// Elements that are metals.
    Metal,
    /// Small organic molecules, see [`super::ligand`].
    Ligand,
}

impl Kind {
    /// All of them, by their words; a word may have two forms.
    pub(super) const WORDS: [(&'static str, Self); 12] = [
        ("protein", Self::Protein),
        ("nucleic", Self::Nucleic),
        ("water", Self::Water),
        ("waters", Self::Water),
        ("ion", Self::Ion),
        ("ions", Self::Ion),
        ("backbone", Self::Backbone),
        ("hydrogen", Self::Hydrogen),
        ("metal", Self::Metal),
        ("metals", Self::Metal),
        ("ligand", Self::Ligand),
        ("ligands", Self::Ligand),
    ];

    pub(super) fn word(self) -> &'static str {
        Self::WORDS.iter().find(|(_, kind)| *kind == self).map_or("", |(word, _)| word)
    }
}

/// A value in a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Value {
    /// A name with wildcards, a number, or a range such as `10:20`.
    Word(String),
    /// `10 to 20`.
    Range(String, String),
}

/// `COLUMN < 0.5`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Comparison {
    pub(super) column: String,
    /// Whether the number without its sign is compared.
    pub(super) absolute: bool,
    pub(super) sign: Sign,
    pub(super) value: String,
}

/// A comparison sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sign {
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
    Other,
}

impl Sign {
    /// Whether `a` compares so with `b`; false where one of them is not a number.
    pub(super) fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Self::Less => a < b,
            Self::AtMost => a <= b,
            Self::More => a > b,
            Self::AtLeast => a >= b,
            Self::Equal => a == b,
            Self::Other => a.partial_cmp(&b).is_some_and(std::cmp::Ordering::is_ne),
        }
    }

    /// The sign with both sides exchanged.
    pub(super) fn flipped(self) -> Self {
        match self {
            Self::Less => Self::More,
            Self::AtMost => Self::AtLeast,
            Self::More => Self::Less,
            Self::AtLeast => Self::AtMost,
            same => same,
        }
    }
}

/// Particles whose centre is at most this far from the centre of a selected one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Near {
    pub(super) reach: f64,
    pub(super) of: Box<Node>,
    /// Whether the selected ones themselves are included: VMD's `within` does, MDAnalysis' `around` does not.
    pub(super) itself: bool,
}

impl Node {
    /// Visits this part and all parts of it.
    pub(super) fn visit(&self, see: &mut dyn FnMut(&Self)) {
        see(self);
        match self {
            Self::Not(inner) | Self::Group(inner) | Self::Same(_, inner) => inner.visit(see),
            Self::Near(near) => near.of.visit(see),
            Self::Chain(first, rest) => {
                first.visit(see);
                rest.iter().for_each(|(_, part)| part.visit(see));
            }
            Self::All | Self::None | Self::Kind(_) | Self::Values(..) | Self::Compare(_) => {}
        }
    }
}
