//! The table of extremes: small pictures of hard cases for ray tracers. `halfline measure --suite extremes` and a test
//! run it; the modules make the scenes. Views are oblique unless a case needs the axes, because rounding of directions
//! has no effect along the axes.
//!
//! Sources in the comments: *peers* are failures of other renderers, measured 2026-11 with their own programs (Embree,
//! Cycles, OVITO, POV-Ray, Mitsuba, Tachyon); *numerics* are measurements of the forms of the quadratic in f32, f64 and
//! big floats for this project; issues are given by repository and number.

mod crowd;
mod distance;
mod parts;
mod scale;
mod touching;
mod wild;

use halfline::error::Result;
use halfline::scene::Scene;
use std::path::Path;

/// The seed of the published tables.
pub const SEED: u64 = 0x5eed_0003;

/// Scenes with a common difficulty.
pub struct Family {
    /// The difficulty.
    pub name: &'static str,
    make: Make,
}

/// The source of the scenes.
enum Make {
    /// A seed.
    Seed(fn(u64) -> Result<Vec<Scene>>),
    /// Data of third parties, in a file of this name.
    #[cfg_attr(target_arch = "wasm32", expect(dead_code, reason = "a browser has no files"))]
    File(&'static str, fn(&Path) -> Result<Vec<Scene>>),
}

impl Family {
    /// The name of its third-party file, if it has one.
    #[must_use]
    pub fn file(&self) -> Option<&'static str> {
        match self.make {
            Make::Seed(_) => None,
            Make::File(name, _) => Some(name),
        }
    }

    /// Its scenes for a seed. Data is searched for in `folder`; a family without its file is empty.
    ///
    /// # Errors
    /// Errors of [`read::scene`](halfline_files::read::scene) for malformed data.
    pub fn scenes(&self, seed: u64, folder: Option<&Path>) -> Result<Vec<Scene>> {
        match self.make {
            Make::Seed(make) => make(seed),
            Make::File(name, make) => match folder.map(|folder| folder.join(name)).filter(|path| path.is_file()) {
                Some(path) => make(&path),
                None => Ok(Vec::new()),
            },
        }
    }
}

/// All of them.
pub const FAMILIES: &[Family] = &[
    // pbrt-v3#44 (a unit sphere 1e4 away shrinks), mitsuba3#512 (rings), pytracer#22 (missed at 4e3 radii).
    Family { name: "far, on the axis", make: Make::Seed(distance::on_axis) },
    Family { name: "far, oblique", make: Make::Seed(distance::oblique) },
    Family { name: "far, off the axis", make: Make::Seed(distance::off_axis) },
    // numerics: from 1e7 on f32 gets the order of hits wrong, not hit or miss.
    Family { name: "clusters 1e3 to 1e9 away", make: Make::Seed(distance::clusters) },
    // OVITO: 50 % of the pixels of 300 spheres at 1e7 wrong; pbrt-v3#265 (dark ring 8e5 from the origin).
    Family { name: "offsets 1e3 to 1e12", make: Make::Seed(distance::offsets) },
    // peers: OVITO's picture is empty at 800 scene radii; Embree's 1,405 + 1,607 wrong pixels at 1e6.
    Family { name: "peers' failures", make: Make::Seed(distance::peers) },
    // numerics: f32 cannot decide from k = 24 on, the stable forms in f64 from 48.
    Family { name: "grazing, b = r(1 +- 2^-k)", make: Make::Seed(touching::grazing) },
    Family { name: "grazing a large disc", make: Make::Seed(touching::grazing_large) },
    // A tangent ray hits (aardvark.base#127); D = 0 by Pythagorean triples and quadruples.
    Family { name: "exact tangency", make: Make::Seed(touching::touched) },
    // peers: there Embree loses 40 % of the inward rays, and 13 % of the outward rays hit the sphere they start on.
    Family { name: "eye on a surface", make: Make::Seed(touching::on_surface) },
    Family { name: "eye just off a surface", make: Make::Seed(touching::off_surface) },
    // OSPRay's comment on large spheres (Intersect.ih); peers: Embree's horizon, 512 false hits.
    Family { name: "planet with pebbles", make: Make::Seed(touching::planet) },
    Family { name: "horizon in a long lens", make: Make::Seed(touching::horizon) },
    // numerics: without scaling 29 % wrong at r = 1e20, everything at |d| = 1e20.
    Family { name: "r = 1e-30 to 1e30", make: Make::Seed(scale::sizes) },
    Family { name: "sizes 1e-9 to 1e9 at once", make: Make::Seed(scale::mixed) },
    Family { name: "depths 1e-45 to 1e40 at once", make: Make::Seed(scale::span) },
    Family { name: "viewport 1e-20 to 1e20", make: Make::Seed(scale::viewports) },
    Family { name: "wide lenses", make: Make::Seed(scale::wide) },
    Family { name: "long lenses", make: Make::Seed(scale::long) },
    Family { name: "stretched pixels", make: Make::Seed(scale::stretched) },
    // up x view cancels to its last bits.
    Family { name: "up almost along the view", make: Make::Seed(scale::rolled) },
    Family { name: "1 x 1, 1 x N, N x 1", make: Make::Seed(scale::slivers) },
    Family { name: "spheres of 1e-3 pixels", make: Make::Seed(scale::dust) },
    // mitsuba3#1871: an epsilon thicker than a shell.
    Family { name: "shells 1e-9 r apart", make: Make::Seed(crowd::shells) },
    Family { name: "coincident spheres", make: Make::Seed(crowd::coincident) },
    Family { name: "mirror-symmetric ties", make: Make::Seed(crowd::ties) },
    // numerics: a bound per ray and a bound per sphere differ most with wide lenses, near the eye plane.
    Family { name: "around the eye", make: Make::Seed(crowd::around) },
    // The cover of Ray Tracing in One Weekend, and harder variants.
    Family { name: "ground and crumbs", make: Make::Seed(crowd::ground) },
    Family { name: "anything at all", make: Make::Seed(wild::anything) },
    // Haines' Standard Procedural Databases.
    #[cfg(not(target_arch = "wasm32"))]
    Family { name: "shells.nff", make: Make::File("shells.nff", crowd::spiral) },
    // JPL ephemeris DE421.
    #[cfg(not(target_arch = "wasm32"))]
    Family { name: "Jupiter from the Earth", make: Make::File("solar_system.csv", crowd::solar) },
];
