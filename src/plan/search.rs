//! How the candidates of a ray are found.

use crate::error::{Error, Result};
use crate::settings::Search;

/// Spheres up to which a form asks all of them: with 16, lists save a fifth on lavapipe and a third on the CPU path
/// already (clouds, 1024 x 1024, colour alone; docs/performance.md).
const FEW: usize = 8;

/// Why tiles were planned and all spheres are asked.
pub(crate) const NO_LENS: &str =
    "this lens is too wide or too narrow to bin spheres into tiles, and every ray asks all of them";

/// How viewing rays find candidates where `asked` was asked for, and why.
pub(super) fn for_viewing_rays(asked: Search, certified: bool, spheres: usize) -> (Search, &'static str) {
    match asked {
        Search::Auto if certified || spheres > FEW => (
            Search::Tiles,
            "viewing rays of a tile closer_hit_any_order the same spheres: nothing is built but lists, nearest first",
        ),
        Search::Auto => (Search::All, "so few spheres are asked sooner than they are binned into tiles"),
        asked => (asked, "it was asked for"),
    }
}

/// Spheres up to which asking all of them is cheaper than walking a tree. Clouds, 1e5 rays, both ways of origins, CPU
/// milliseconds a call by all and by a tree: lavapipe 33 and 41, 71 and 80 with 32 spheres, 47 and 42, 91 and 83 with 64;
/// the CPU path 20 and 24, 70 and 58 with 32, 34 and 24, 128 and 59 with 64 (Mesa 22.3.6, 2 shared cores).
const FEW_SPHERES: usize = 48;

/// Rays up to which asking all spheres is cheaper than making a tree of them, however many they are: 1e5 spheres and 64 rays
/// take 37 CPU milliseconds by all and 50 by a tree on lavapipe, 43 and 49 on the CPU path; 256 rays 110 and 49, 113 and 55.
const FEW_RAYS: usize = 100;

/// How given rays find candidates: as `asked`, else by what costs less.
///
/// # Errors
/// [`Error::Settings`] for tiles.
pub(super) fn for_given_rays(asked: Search, spheres: usize, rays: usize) -> Result<Search> {
    match asked {
        Search::Tiles => {
            let problem = "given rays have no pixels that could be tiled";
            Err(Error::settings(problem, "use the search tree or all, or leave it to auto"))
        }
        Search::Auto if spheres > FEW_SPHERES && rays > FEW_RAYS => Ok(Search::Tree),
        Search::Auto => Ok(Search::All),
        asked => Ok(asked),
    }
}

/// Why viewing rays do not walk a tree.
pub(super) fn only_given_rays() -> Error {
    let problem = "the search by a tree is for given rays; viewing rays have tiles, which cost less to make";
    Error::settings(problem, "use --search tiles or all, or leave it out")
}
