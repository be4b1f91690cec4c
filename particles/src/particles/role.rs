//! The meaning of a column.

/// The meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// A coordinate of axis 0, 1 or 2.
    Position(usize),
    Radius,
    Diameter,
    /// A component of a colour.
    Color(usize),
    /// The symbol of an element.
    Symbol,
    /// An atomic number.
    Number,
    /// Text, which is read only if it is requested.
    Text,
    /// A number that is read only if it is requested.
    Other,
}

impl Role {
    /// Whether its numbers decide if a particle is valid.
    pub(crate) fn is_checked(self) -> bool {
        matches!(self, Self::Position(_) | Self::Radius | Self::Diameter)
    }
}
