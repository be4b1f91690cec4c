//! The meaning of a column.

/// The meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// A coordinate of axis 0, 1 or 2.
    Position(usize),
    Radius,
    Diameter,
    /// A component of linear RGB.
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
    /// The meaning of a field that is called by its plain name, `x`, `y`, `z`, `radius` or `diameter`, in lower case.
    pub(crate) fn of_field(name: &str) -> Self {
        match name {
            "x" => Self::Position(0),
            "y" => Self::Position(1),
            "z" => Self::Position(2),
            "radius" => Self::Radius,
            "diameter" => Self::Diameter,
            _ => Self::Other,
        }
    }
}
