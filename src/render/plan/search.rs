//! Chooses how the candidates of a ray are found.

use crate::error::{Error, Result};
use crate::quote::setting::SEARCH;
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

/// Up to this number of spheres testing all of them is cheaper than walking a tree. Clouds, 1e5 rays, both ways of
/// origins, CPU milliseconds per call by all and by a tree: lavapipe 33 and 41, 71 and 80 with 32 spheres, 47 and 42,
/// 91 and 83 with 64; the CPU path 20 and 24, 70 and 58 with 32, 34 and 24, 128 and 59 with 64 (Mesa 22.3.6, 2 shared
/// cores; an earlier tree of two boxes per node, as for the next number).
const FEW_SPHERES: usize = 48;

/// Up to this number of rays testing all spheres is cheaper than building a tree, for any number of spheres: 1e5
/// spheres and 64 rays take 37 CPU milliseconds by all and 50 by a tree on lavapipe, 43 and 49 on the CPU path; 256
/// rays 110 and 49, 113 and 55.
const FEW_RAYS: usize = 100;

/// How given rays find candidates: as requested, else by the lower cost.
///
/// # Errors
/// [`Error::Settings`] for tiles.
pub(super) fn for_given_rays(requested: Search, spheres: usize, rays: usize) -> Result<Search> {
    match requested {
        Search::Tiles => {
            let problem = format!("given rays have no pixels, so {SEARCH} tiles does not apply");
            Err(Error::settings(problem, "use the search tree, all or auto"))
        }
        Search::Auto if spheres > FEW_SPHERES && rays > FEW_RAYS => Ok(Search::Tree),
        Search::Auto => Ok(Search::All),
        requested => Ok(requested),
    }
}

/// The error for a tree with viewing rays.
pub(super) fn only_given_rays() -> Error {
    let problem = "the search tree is for given rays; viewing rays use tiles, which cost less to build";
    Error::settings(problem, format!("use {SEARCH} tiles or all, or remove it"))
}
