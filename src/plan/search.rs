//! How the candidates of a ray are found.

use crate::certify::tiles::WHOLE;
use crate::error::Error;
use std::str::FromStr;

/// How the candidates of a ray are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Search {
    /// What the scene requires.
    #[default]
    Auto,
    /// Every ray asks all spheres.
    All,
    /// The spheres are binned into tiles of 8 x 8 pixels by what they surely cover, nearest first; a ray asks those of its
    /// tile.
    Tiles,
}

impl Search {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Auto, Self::All, Self::Tiles];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::All => "all",
            Self::Tiles => "tiles",
        }
    }

    /// The level of the lists of candidates: tiles, or one for the whole image.
    pub(crate) fn level(self) -> u32 {
        if self == Self::All { WHOLE } else { 0 }
    }

    /// Why it was chosen, in words.
    pub(crate) fn reason(self, certified: bool) -> &'static str {
        match (self, certified) {
            (Self::All, true) => "it was asked for",
            (Self::All, false) => "a form that runs alone asks every sphere, so that its errors are its own",
            _ => "viewing rays of a tile meet the same spheres: nothing is built but lists, nearest first",
        }
    }
}

impl FromStr for Search {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self, Error> {
        crate::error::by_name("search", name, Self::ALL, Self::name)
    }
}
