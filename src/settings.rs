//! The settings of a rendering: backend, accuracy, buffers, samples, part of the frame.

use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::intersect::Method;
use crate::scene::Scene;
use crate::shade::Shade;
use crate::tile::WHOLE;
use crate::window::Window;
use serde::Serialize;
use std::str::FromStr;

/// Where to compute.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// A GPU if there is one, a software adapter if not, the CPU path if there is no adapter at all.
    #[default]
    Auto,
    /// An adapter, or an error.
    Gpu,
    /// The CPU reference path.
    Cpu,
}

impl Backend {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Auto, Self::Gpu, Self::Cpu];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Gpu => "gpu",
            Self::Cpu => "cpu",
        }
    }
}

impl FromStr for Backend {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        crate::error::by_name("backend", name, Self::ALL, Self::name)
    }
}

/// The accuracy of the answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Accuracy {
    /// What the outputs require.
    #[default]
    Auto,
    /// f32, no certificate.
    Fast,
    /// Proved equal to the exact answer.
    Certified,
    /// Every pixel in exact arithmetic.
    Exact,
}

impl Accuracy {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Auto, Self::Fast, Self::Certified, Self::Exact];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Fast => "fast",
            Self::Certified => "certified",
            Self::Exact => "exact",
        }
    }
}

impl FromStr for Accuracy {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        crate::error::by_name("accuracy", name, Self::ALL, Self::name)
    }
}

/// The settings of a rendering, besides its scene.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// Where to compute.
    pub backend: Backend,
    /// Which adapter, by index or part of its name; `None` takes WGPU_ADAPTER_NAME or the first.
    pub adapter: Option<String>,
    /// One form of the quadratic and nothing else; `None` leaves the choice to the plan.
    pub method: Option<Method>,
    /// The accuracy of the answers.
    pub accuracy: Accuracy,
    /// How candidates are found.
    pub search: Search,
    /// How a hit becomes a colour.
    pub shade: Shade,
    /// Which buffers the frame shall hold; ids are always computed.
    pub aovs: Vec<Aov>,
    /// Samples of each pixel, which colour and alpha are the means of: the next square n x n, one point in each of n x n equal
    /// squares of the pixel; 0 and 1 take the pixel's centre. All other buffers are the answers of the centre.
    pub samples: u32,
    /// Chooses these points, together with the pixel's place in the full frame.
    pub seed: u32,
    /// Which part of the frame is rendered, bit for bit as the whole has it; `None` is all of it.
    pub window: Option<Window>,
    /// Bytes of memory that the caller needs for itself as long as it holds the frame, to write its files say: a frame that
    /// would not leave so many free is refused.
    pub reserve: u64,
    /// The error that is allowed. Certified answers promise it of t, relative to itself; where accuracy and method are
    /// left open, the cheapest method is taken whose predicted errors it allows. `None` promises the default and leaves
    /// the choice to the buffers.
    pub tolerance: Option<Tolerance>,
}

impl Settings {
    /// What is promised of t where answers are certified.
    #[must_use]
    pub fn promise(&self) -> Tolerance {
        self.tolerance.unwrap_or_default()
    }

    /// What is rendered of `scene`'s frame.
    ///
    /// # Errors
    /// [`Error::Settings`] where the window is no part of it.
    pub fn window_of(&self, scene: &Scene) -> Result<Window> {
        let (width, height) = (scene.image.width, scene.image.height);
        self.window.map_or(Ok(Window::full(width, height)), |window| window.within(width, height))
    }

    /// Whether any of these buffers is requested.
    pub(crate) fn asks(&self, some: &[Aov]) -> bool {
        some.iter().any(|aov| self.aovs.contains(aov))
    }
}

/// A promised relative error: at least 2^-50, the default 1e-5.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance(f64);

impl Tolerance {
    /// The promise, if f64 can hold it.
    ///
    /// # Errors
    /// [`Error::Settings`] for 0, less than 2^-50, and what is no number.
    pub fn new(relative: f64) -> Result<Self> {
        if relative >= 2f64.powi(-50) && relative.is_finite() {
            return Ok(Self(relative));
        }
        let problem = format!("a tolerance of {relative} cannot be promised");
        Err(Error::settings(problem, "give a relative error of 2^-50 (8.9e-16) or more"))
    }

    /// The number.
    #[must_use]
    pub fn relative(self) -> f64 {
        self.0
    }
}

impl Default for Tolerance {
    fn default() -> Self {
        Self(1e-5)
    }
}

/// How the candidates of a ray are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Search {
    /// What the scene requires.
    #[default]
    Auto,
    /// Every ray tests all spheres.
    All,
    /// The spheres are binned into tiles of 8 x 8 pixels that they may cover, nearest first; a ray tests those of its tile
    /// until the rest lies behind its hit.
    Tiles,
    /// A tree of boxes over the spheres, for given rays; it changes no answer.
    Tree,
}

impl Search {
    /// All of them.
    pub const ALL: &'static [Self] = &[Self::Auto, Self::All, Self::Tiles, Self::Tree];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::All => "all",
            Self::Tiles => "tiles",
            Self::Tree => "tree",
        }
    }

    /// The level of the lists of candidates: tiles, or one for the whole image.
    pub(crate) fn level(self) -> u32 {
        if self == Self::All { WHOLE } else { 0 }
    }
}

impl FromStr for Search {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        crate::error::by_name("search", name, Self::ALL, Self::name)
    }
}
