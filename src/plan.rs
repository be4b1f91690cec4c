//! What a scene requires, decided in one place: which kernel, which sharing, which buffers, which precision.

use crate::error::{Error, Result};
use crate::frame::Aov;
use crate::gpu::device::AdapterSummary;
use crate::intersect::Method;
use crate::scene::Scene;
use crate::shade::Shade;
use crate::view::{SphereRecord, View};
use rayon::prelude::*;
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
    /// How a hit becomes a colour.
    pub shade: Shade,
    /// Which buffers the frame shall hold; ids are always computed.
    pub aovs: Vec<Aov>,
    /// Promised relative error of t where answers are certified.
    pub tolerance: Tolerance,
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
    /// The width of the depth's interval is written.
    pub(crate) width: bool,
}

impl Kernel {
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
    /// How candidates are found: `all` spheres.
    pub search: &'static str,
    #[serde(skip)]
    pub(crate) kernel: Kernel,
}

/// The buffers that are answers, not looks: asking for one asks for a certificate.
const ANSWERS: [Aov; 8] =
    [Aov::Distance, Aov::Depth, Aov::Normal, Aov::Position, Aov::Id, Aov::Mask, Aov::Certainty, Aov::Bound];

/// What f32 without a certificate is expected to do to a scene, before it is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Expected {
    /// How far the outline of the worst sphere may be off, in its radii.
    pub outline: f64,
    /// Which sphere that is.
    pub sphere: u32,
    /// Its distance in its radii.
    pub distance: f64,
}

/// Outlines that are off by more than this are warned of: a fiftieth of a radius can be seen.
const VISIBLE: f64 = 0.02;

impl Expected {
    /// The worst sphere of `view` for `method`; `None` without spheres.
    #[must_use]
    pub fn of(view: &View, method: Method) -> Option<Self> {
        let farness = |s: &SphereRecord| {
            let [x, y, z, r] = s.ball.map(f64::from);
            (x * x + y * y + z * z).sqrt() / r
        };
        let each = view.spheres.par_iter().enumerate().map(|(id, s)| (farness(s), id));
        let (distance, id) = each.reduce_with(|a, b| if b.0 > a.0 { b } else { a })?;
        // 2^-24: hardware rounds to nearest.
        let outline = method.outline_error(distance) * 2f64.powi(-24);
        Some(Self { outline, sphere: id as u32, distance })
    }

    /// A warning with a number and a mend, where the error can be seen.
    #[must_use]
    pub fn warning(&self, method: Method) -> Option<String> {
        let Self { outline, sphere, distance } = self;
        (*outline > VISIBLE).then(|| {
            format!(
                "method {} places the outline of sphere {sphere}, {distance:.1e} radii away, only within {outline:.1e} \
                 radii; use --accuracy certified",
                method.name()
            )
        })
    }
}

impl Plan {
    /// Decides what `scene` requires for the buffers asked for.
    ///
    /// # Errors
    /// [`Error::Settings`] for a method together with a certificate, [`Error::Accuracy`] for a promise that cannot be
    /// kept.
    pub fn new(scene: &Scene, settings: &Settings) -> Result<Self> {
        let mut plan = Self::for_method(settings)?;
        let asked = |some: &[Aov]| some.iter().any(|aov| settings.aovs.contains(aov));
        let shade = asked(&[Aov::Color]).then_some(settings.shade);
        plan.kernel.shade = shade;
        plan.kernel.colors = scene.spheres.colors.is_some() && shade.is_some_and(Shade::needs_colors);
        plan.kernel.t = asked(&[Aov::Distance, Aov::Depth, Aov::Position]);
        plan.kernel.normal = asked(&[Aov::Normal]);
        plan.accuracy = match (settings.accuracy, settings.method) {
            (Accuracy::Auto, None) if asked(&ANSWERS) => Accuracy::Certified,
            (Accuracy::Auto, _) => Accuracy::Fast,
            (stated, _) => stated,
        };
        if matches!(plan.accuracy, Accuracy::Certified | Accuracy::Exact) {
            plan.method = plan.accuracy.name();
            plan.kernel.certify = true;
            plan.kernel.width = asked(&[Aov::Bound]);
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
        let kernel = Kernel {
            method,
            rays: Rays::Camera,
            sharing: Sharing::None,
            shade: None,
            colors: false,
            t: false,
            normal: false,
            certify: false,
            width: false,
        };
        Ok(Self { method: method.name(), accuracy: Accuracy::Fast, search: "all", kernel })
    }
}
