//! Files of figures without pixels.

use std::path::Path;

/// The formats of figures without pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VectorFormat {
    /// Scalable Vector Graphics 1.1.
    Svg,
    /// Portable Document Format 1.7.
    Pdf,
}

impl VectorFormat {
    /// The format of a file name's extension, in upper or lower case.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        match &path.extension()?.to_str()?.to_ascii_lowercase()[..] {
            "svg" => Some(Self::Svg),
            "pdf" => Some(Self::Pdf),
            _ => None,
        }
    }
}
