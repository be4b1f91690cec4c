//! The kinds of engines, and which of them finds the first hits of rays.

use crate::settings::Search;
use halfline_ground::error::{Error, Result};
use halfline_ground::quote::setting::{ACCURACY, METHOD, SEARCH};

/// The engine that finds the first hits of viewing rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EngineKind {
    /// Every ray tests every sphere, by one form of the quadratic.
    Method,
    /// The CPU path bins the spheres into tiles of pixels, and a ray tests the spheres of its tile.
    Strips,
    /// A device holds the spheres, which leave their depths in the pixels that they cover.
    Resident,
    /// The judge decides every pixel in exact arithmetic.
    Judge,
    /// The rays of a curved lens are given rays.
    Given {
        /// A tree finds the spheres that a ray may hit; otherwise every ray tests every sphere.
        tree: bool,
    },
}

impl EngineKind {
    /// The name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Method | Self::Given { tree: false } => "all",
            Self::Strips => "tiles",
            Self::Resident => "splat",
            Self::Judge => "exact",
            Self::Given { tree: true } => "tree",
        }
    }

    /// The reason for this engine.
    pub(crate) fn reason(self) -> &'static str {
        match self {
            Self::Method => "a method tests every sphere for every ray",
            Self::Strips => {
                "viewing rays of a tile hit the same few spheres, so short lists, nearest first, are enough"
            }
            Self::Resident => "the device holds the spheres, and the host sends only the camera",
            Self::Judge => "exact arithmetic decides every pixel",
            Self::Given { tree: true } => "a tree of boxes finds the spheres that a ray of a curved lens may hit",
            Self::Given { tree: false } => "every ray of a curved lens tests every sphere",
        }
    }
}

/// The most spheres that a method tests for each viewing ray.
const MAX_VIEWED: usize = 100_000;

/// The most spheres that a method tests for each given ray: 1e5 rays then take 4 to 14 CPU seconds
/// (docs/performance.md), and 1e5 certified rays less than one.
const MAX_GIVEN: usize = 10_000;

/// Refuses a method for more spheres than it tests for each viewing ray.
///
/// # Errors
/// [`Error::Limits`].
pub(super) fn check_method(spheres: usize) -> Result<()> {
    if spheres <= MAX_VIEWED {
        return Ok(());
    }
    Err(Error::Limits {
        problem: format!("a method tests every sphere for every pixel, at most {MAX_VIEWED}, and there are {spheres}"),
        mend: format!("remove {METHOD}: {ACCURACY} certified is faster here, and fast too"),
    })
}

/// The search by which given rays find candidates, never `auto`: for certified rays a tree unless all spheres are
/// requested; for a method all spheres.
///
/// # Errors
/// [`Error::Settings`] for a tree by a method; [`Error::Limits`] for more than [`MAX_GIVEN`] spheres by a method.
pub(super) fn for_given_rays(requested: Search, by_method: bool, spheres: usize) -> Result<Search> {
    match requested {
        Search::Tree if by_method => {
            let problem = "the search tree is for certified and exact answers; a method tests all spheres";
            let mend = format!("use {SEARCH} all or auto, or {ACCURACY} certified without a method");
            Err(Error::settings(problem, mend))
        }
        _ if by_method && spheres > MAX_GIVEN => Err(Error::Limits {
            problem: format!("a method tests all spheres for every ray, at most {MAX_GIVEN}, and there are {spheres}"),
            mend: format!("use {ACCURACY} certified without a method, which is faster here"),
        }),
        Search::Auto if !by_method => Ok(Search::Tree),
        Search::Auto => Ok(Search::All),
        requested => Ok(requested),
    }
}
