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

/// The same on a device, given what [`for_viewing_rays`] says of the frame.
///
/// # Errors
/// [`Error::Settings`] for splats by a method.
pub(super) fn on_device(
    requested: Search,
    certified: bool,
    device: Device,
    planned: (Search, &'static str),
) -> Result<(Search, &'static str)> {
    match (requested, device) {
        (Search::Splat, _) if !certified => {
            let problem = format!("{SEARCH} splat is for certified answers");
            Err(Error::settings(problem, format!("use {ACCURACY} certified, or {SEARCH} auto")))
        }
        (Search::Splat, Device::Cpu) => Ok((Search::Tiles, NO_DEVICE)),
        (Search::Auto, Device::Hardware) if certified => {
            Ok((Search::Splat, "the device holds the spheres, and the host sends only the camera"))
        }
        _ => Ok(planned),
    }
}

/// Why a device searches lists although it holds spheres for splats elsewhere.
pub(crate) const NOT_PLACED: &str =
    "the device cannot place these spheres for this camera, so the host bins them into tiles";

/// Why a frame is searched by tiles although splats are requested.
pub(crate) const NO_DEVICE: &str = "the CPU path has no splats, so the spheres are binned into tiles";

/// What computes a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Device {
    Cpu,
    /// An adapter that runs on the host's processor: short lists take a fifth of the time there (docs/performance-log.md).
    Software,
    Hardware,
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
        Search::Tiles | Search::Splat => {
            let problem = format!("given rays have no pixels, so {SEARCH} {} does not apply", requested.name());
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
