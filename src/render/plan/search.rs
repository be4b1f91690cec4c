//! Chooses how the candidates of a ray are found.

use crate::error::{Error, Result};
use crate::quote::setting::{ACCURACY, SEARCH};
use crate::settings::Search;

/// Up to this number of spheres a method tests all of them. With 16 spheres, lists already save a fifth on lavapipe and
/// a third on the CPU path (clouds, 1024 x 1024, colour alone; docs/performance-log.md).
const FEW: usize = 8;

/// Why a plan with tiles tests all spheres after all.
pub(crate) const NO_LENS: &str =
    "the field of view is too wide or too narrow to bin spheres into tiles, so every ray tests all of them";

/// How viewing rays find candidates for the requested search, and why.
pub(super) fn for_viewing_rays(requested: Search, certified: bool, spheres: usize) -> (Search, &'static str) {
    match requested {
        Search::Auto if certified || spheres > FEW => (
            Search::Tiles,
            "viewing rays of a tile hit the same few spheres, so short lists, nearest first, are enough",
        ),
        Search::Auto => (Search::All, "testing so few spheres costs less than binning them into tiles"),
        requested => (requested, "it is requested"),
    }
}

/// The most spheres that a method tests for each given ray: 1e5 rays then take 4 to 14 CPU seconds (docs/performance-log.md),
/// and as many certified ones less than one.
const MOST: usize = 10_000;

/// How given rays find candidates: certified ones by a tree unless all spheres are requested, those of a method by testing
/// all spheres.
///
/// # Errors
/// [`Error::Settings`] for tiles, and for a tree by a method; [`Error::Limits`] for more than [`MOST`] spheres by a method.
pub(super) fn for_given_rays(requested: Search, by_method: bool, spheres: usize) -> Result<Search> {
    match requested {
        Search::Tiles => {
            let problem = format!("given rays have no pixels, so {SEARCH} tiles does not apply");
            Err(Error::settings(problem, "use the search tree, all or auto"))
        }
        Search::Tree if by_method => {
            let problem = "the search tree is for certified and exact answers; a method tests all spheres";
            let mend = format!("use {SEARCH} all or auto, or {ACCURACY} certified without a method");
            Err(Error::settings(problem, mend))
        }
        _ if by_method && spheres > MOST => Err(Error::Limits {
            problem: format!("a method tests all spheres for every ray, at most {MOST}, and there are {spheres}"),
            mend: format!("use {ACCURACY} certified without a method, which is faster here"),
        }),
        Search::Auto if !by_method => Ok(Search::Tree),
        Search::Auto => Ok(Search::All),
        requested => Ok(requested),
    }
}

/// The error for a tree with viewing rays.
pub(super) fn only_given_rays() -> Error {
    let problem = "the search tree is for given rays; viewing rays use tiles, which cost less to build";
    Error::settings(problem, format!("use {SEARCH} tiles or all, or remove it"))
}
