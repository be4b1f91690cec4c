//! What a scene requires, decided in one place: which kernel, which sharing, which buffers, which precision.

mod choose;
mod explain;
mod search;

pub use explain::{Binding, Explanation, LeftOut, Part, Room, Shown, Staged, explain};
pub use search::Search;

use crate::certify::stage::Stage;
use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::gpu::device::AdapterSummary;
use crate::intersect::Method;
use crate::predict::Prediction;
use crate::scene::Scene;
use crate::shade::Shade;
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

/// How sure the answers must be.
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

/// What is asked for besides the scene.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// Where to compute.
    pub backend: Backend,
    /// Which adapter, by index or part of its name; `None` takes WGPU_ADAPTER_NAME or the first.
    pub adapter: Option<String>,
    /// One form of the quadratic and nothing else; `None` leaves the choice to the plan.
    pub method: Option<Method>,
    /// How sure the answers must be.
    pub accuracy: Accuracy,
    /// How candidates are found.
    pub search: Search,
    /// How a hit becomes a colour.
    pub shade: Shade,
    /// Which buffers the frame shall hold; ids are always computed.
    pub aovs: Vec<Aov>,
    /// How many samples of each pixel colour and alpha are the means of: the next square n x n, each of n x n equal squares
    /// of the pixel asked at one point; 0 and 1 ask the pixel's centre. Everything else is always the answer of the centre.
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

    /// Whether any of these buffers shall be in the frame.
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

/// Where a kernel's rays come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Rays {
    /// One viewing ray per pixel.
    Camera,
    /// Given rays that leave from one point, which is then the origin.
    SharedOrigin,
    /// Given rays from many points; their origins come in high and low parts.
    Spread,
}

/// How invocations share the spheres they load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Sharing {
    /// Everyone loads for itself. Hardware loads a shared address once by itself.
    None,
    /// Broadcast within subgroups of 4.
    Subgroup4,
    /// Broadcast within subgroups of 8.
    Subgroup8,
    /// Shuffle within subgroups of any size.
    Shuffle,
}

impl Sharing {
    #[cfg(test)]
    pub(crate) const ALL: [Self; 4] = [Self::None, Self::Subgroup4, Self::Subgroup8, Self::Shuffle];

    /// Software adapters load a shared address lane by lane, so there one load per subgroup pays; a broadcast from a
    /// constant lane is cheaper than a shuffle, but needs to know the subgroup's size.
    pub(crate) fn on(adapter: &AdapterSummary) -> Self {
        match adapter.subgroup {
            _ if adapter.kind != "software" => Self::None,
            None => Self::None,
            Some([4, 4]) => Self::Subgroup4,
            Some([8, 8]) => Self::Subgroup8,
            Some(_) => Self::Shuffle,
        }
    }
}

/// All that a kernel is compiled from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Kernel {
    pub(crate) method: Method,
    pub(crate) rays: Rays,
    pub(crate) sharing: Sharing,
    /// Colour is written, shaded so.
    pub(crate) shade: Option<Shade>,
    /// Spheres have colours of their own.
    pub(crate) colors: bool,
    /// t is written.
    pub(crate) t: bool,
    /// Normals are written.
    pub(crate) normal: bool,
    /// With a certificate instead of `method`.
    pub(crate) certify: bool,
    /// Some spheres are not wholly in front of the eye plane: only a stage tells.
    pub(crate) nears: bool,
    /// `method` asks the candidates of a tile, not every sphere. A certified kernel always does.
    pub(crate) tiles: bool,
    /// The width of the depth's interval is written.
    pub(crate) width: bool,
    /// Given rays walk a tree instead of asking every sphere.
    pub(crate) tree: bool,
    /// Viewing rays go through samples of their pixels instead of the centres.
    pub(crate) samples: bool,
}

impl Kernel {
    /// One for viewing rays that asks every sphere and writes nothing but ids.
    pub(crate) fn bare(method: Method) -> Self {
        Self {
            method,
            rays: Rays::Camera,
            sharing: Sharing::None,
            shade: None,
            colors: false,
            t: false,
            normal: false,
            certify: false,
            nears: false,
            tiles: false,
            width: false,
            tree: false,
            samples: false,
        }
    }

    /// Whether subgroups are used; lists are shared by subgroups that divide a chunk of them, or not at all.
    pub(crate) fn shares(&self) -> bool {
        match self.sharing {
            Sharing::None => false,
            Sharing::Shuffle => !self.certify && !self.tiles,
            Sharing::Subgroup4 | Sharing::Subgroup8 => true,
        }
    }

    /// The same, with what the staged scene requires.
    pub(crate) fn for_stage(self, stage: Option<&Stage>) -> Self {
        Self { nears: stage.is_some_and(|stage| !stage.nears.is_empty()), ..self }
    }

    /// Whether normals are made: to be written, or to shade by.
    pub(crate) fn has_normals(&self) -> bool {
        self.normal || self.shade.is_some_and(|shade| shade != Shade::Flat)
    }

    /// Whether it computes in more than f32: it reads the low parts of all inputs and gives t in two parts.
    pub(crate) fn is_wide(&self) -> bool {
        !self.certify && self.method.is_wide()
    }
}

/// The decisions for one scene and request, in words that can be printed.
#[derive(Debug, Clone, Serialize)]
pub struct Plan {
    /// The form of the quadratic; `certified` and `exact` choose their own.
    pub method: &'static str,
    /// What the answers are worth: fast, certified or exact.
    pub accuracy: Accuracy,
    /// Why this accuracy and this method.
    pub reason: String,
    /// What rounding can do at worst, where that was asked before choosing.
    pub predicted: Option<Prediction>,
    /// How candidates are found: never `auto`.
    #[serde(serialize_with = "by_name")]
    pub search: Search,
    /// Why so.
    pub search_reason: &'static str,
    #[serde(skip)]
    pub(crate) kernel: Kernel,
    /// The kernel of the samples, where colour and alpha are means of them; then `kernel` makes no colour.
    #[serde(skip)]
    pub(crate) sampled: Option<Kernel>,
}

fn by_name<S: serde::Serializer>(search: &Search, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(search.name())
}

impl Plan {
    /// How colour is made, if anybody asked for it.
    pub(crate) fn shade(&self) -> Option<Shade> {
        self.sampled.unwrap_or(self.kernel).shade
    }

    /// Decides what `scene` requires for the buffers asked for, among the methods that `admits` lets run.
    ///
    /// # Errors
    /// [`Error::Settings`] for a method together with a certificate or parallel rays, [`Error::Scene`] for spheres that do not fit one
    /// frame.
    pub fn new(scene: &Scene, settings: &Settings, admits: &mut dyn FnMut(Method) -> bool) -> Result<Self> {
        if settings.search == Search::Tree {
            return Err(search::only_given_rays());
        }
        let mut plan = Self::for_method(settings)?;
        let shade = settings.asks(&[Aov::Color]).then_some(settings.shade);
        plan.kernel.shade = shade;
        plan.kernel.colors = scene.spheres.colors.is_some() && shade.is_some_and(Shade::needs_colors);
        plan.kernel.t = settings.asks(&[Aov::Distance, Aov::Depth, Aov::Position]);
        plan.kernel.normal = settings.asks(&[Aov::Normal]);
        let choice = choose::choose(scene, settings, admits)?;
        plan.kernel.method = choice.method;
        (plan.accuracy, plan.method) = (choice.accuracy, choice.method.name());
        (plan.reason, plan.predicted) = (choice.reason, choice.predicted);
        if matches!(plan.accuracy, Accuracy::Certified | Accuracy::Exact) {
            plan.method = plan.accuracy.name();
            plan.kernel.certify = true;
            plan.kernel.width = settings.asks(&[Aov::Bound]);
        }
        (plan.search, plan.search_reason) = settings.search.decide(plan.kernel.certify, scene.spheres.len());
        plan.kernel.tiles = !plan.kernel.certify && plan.search == Search::Tiles;
        if settings.samples > 1 && settings.asks(&[Aov::Color, Aov::Alpha]) {
            plan.sampled = Some(Kernel { samples: true, t: false, normal: false, width: false, ..plan.kernel });
            (plan.kernel.shade, plan.kernel.colors) = (None, false);
        }
        Ok(plan)
    }

    /// What the settings alone decide: a kernel that writes nothing but ids.
    pub(crate) fn for_method(settings: &Settings) -> Result<Self> {
        let promised = matches!(settings.accuracy, Accuracy::Certified | Accuracy::Exact);
        if let (Some(method), true) = (settings.method, promised) {
            let problem = format!("method {} runs alone and cannot be {}", method.name(), settings.accuracy.name());
            return Err(Error::settings(problem, "leave out --method or --accuracy"));
        }
        let method = settings.method.unwrap_or(Method::Stable);
        let kernel = Kernel::bare(method);
        let (method, accuracy, search) = (method.name(), Accuracy::Fast, Search::All);
        let (reason, search_reason) = (String::new(), "");
        Ok(Self { method, accuracy, reason, predicted: None, search, search_reason, kernel, sampled: None })
    }

    /// The same without tiles, where the spheres cannot be binned into them.
    pub(crate) fn without_tiles(self) -> Self {
        let without = |kernel: Kernel| Kernel { tiles: false, ..kernel };
        let (kernel, sampled) = (without(self.kernel), self.sampled.map(without));
        Self { search: Search::All, search_reason: search::NO_LENS, kernel, sampled, ..self }
    }
}
