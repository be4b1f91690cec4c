//! How the candidates of a ray are found.

use crate::certify::tiles::WHOLE;
use crate::error::Error;
use std::str::FromStr;

/// Spheres up to which a form asks all of them: with 16, lists save a fifth on lavapipe and a third on the CPU path
/// already (clouds, 1024 x 1024, colour alone; docs/performance.md).
const FEW: usize = 8;

/// Why tiles were planned and all spheres are asked.
pub(crate) const NO_LENS: &str =
    "this lens is too wide or too narrow to bin spheres into tiles, and every ray asks all of them";

/// How the candidates of a ray are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Search {
    /// What the scene requires.
    #[default]
    Auto,
    /// Every ray asks all spheres.
    All,
    /// The spheres are binned into tiles of 8 x 8 pixels by what they surely cover, nearest first; a ray asks those of its
    /// tile until the rest lies behind what it hit.
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

    /// What is done where this was asked for, and why, in words.
    pub(super) fn decide(self, certified: bool, spheres: usize) -> (Self, &'static str) {
        match self {
            Self::Auto if certified || spheres > FEW => {
                (Self::Tiles, "viewing rays of a tile meet the same spheres: nothing is built but lists, nearest first")
            }
            Self::Auto => (Self::All, "so few spheres are asked sooner than they are binned into tiles"),
            asked => (asked, "it was asked for"),
        }
    }
}

impl FromStr for Search {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self, Error> {
        crate::error::by_name("search", name, Self::ALL, Self::name)
    }
}
