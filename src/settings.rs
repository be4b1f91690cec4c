//! The settings of a rendering: backend, accuracy, buffers, samples, part of the frame.

mod look;

pub use crate::frame::outline::Outline;
pub use look::{AddedLight, ChosenLook, FileLook, Look};

use crate::frame::tone::{Tone, Toning};
use crate::frame::{Aov, MOST_LIGHTS};
use crate::intersect::Method;
use crate::scene::camera::Aperture;
use crate::scene::{Material, Scene, Sky};
use crate::shade::Shade;
use crate::window::Window;
use halfline_ground::error::{Error, Place, Result, named};
use halfline_ground::quote::setting::{
    CRYPTOMATTE, DEPTH_CUE_STRENGTH, GHOST_RIM, LAYERS, LOOK, OPACITY, OPACITY_SHADOWS, SUN,
};
use serde::Serialize;

/// The device that renders: a GPU or the CPU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// A GPU if there is one, else the CPU path.
    #[default]
    Auto,
    /// An adapter; an error if there is none.
    Gpu,
    /// The CPU reference path.
    Cpu,
}

named! { Backend, "backend", Auto "auto" Gpu "gpu" Cpu "cpu" }

/// The accuracy of the answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Accuracy {
    /// The accuracy that the outputs require.
    #[default]
    Auto,
    /// f32 without a certificate.
    Fast,
    /// Proved equal to the exact answer.
    Certified,
    /// Every pixel in exact arithmetic.
    Exact,
}

named! { Accuracy, "accuracy", Auto "auto" Fast "fast" Certified "certified" Exact "exact" }

/// The share of the background in the colour of the farthest sphere under a depth cue. On black 0.4 of its light is left, two thirds of
/// its value in sRGB: visibly darker, and its own colour is still seen.
pub const DEPTH_CUE: f64 = 0.6;

/// The most layers of translucent spheres in a picture.
pub const MOST_LAYERS: u32 = 64;

/// The settings of a rendering, besides its scene.
///
/// ```
/// use halfline::{Accuracy, Aov, Backend, Settings};
///
/// let settings = Settings {
///     backend: Backend::Cpu,
///     accuracy: Accuracy::Certified,
///     aovs: vec![Aov::Depth, Aov::Normal],
///     ..Settings::default()
/// };
/// # assert!(settings.aovs.contains(&Aov::Depth));
/// ```
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// The device that renders: a GPU or the CPU.
    pub backend: Backend,
    /// The adapter, by index or part of its name; `None` takes WGPU_ADAPTER_NAME or the first.
    pub adapter: Option<String>,
    /// A single intersection method, uncertified; `None` leaves the choice to the plan.
    pub method: Option<Method>,
    /// The accuracy of the answers.
    pub accuracy: Accuracy,
    /// The search of given rays for the spheres that they may hit.
    pub search: Search,
    /// The shading of a hit.
    pub shade: Shade,
    /// The buffers of the frame; ids are always computed.
    pub aovs: Vec<Aov>,
    /// Samples per pixel whose mean is the colour and the alpha, rounded up to the next square n x n: one point in each
    /// of n x n equal squares of the pixel. 0 and 1 use the pixel's centre. All other buffers use the centre.
    pub samples: u32,
    /// Whether the frame counts the samples of each pixel that show each sphere. The scene then has opaque spheres only.
    pub coverage: bool,
    /// A lens with a size, for colour and alpha; `None` for a pinhole. It needs several samples, and each leaves from
    /// another point of it.
    pub aperture: Option<Aperture>,
    /// Layers of translucent spheres in the picture: the nearest hits of each ray before the first opaque one, composed over it in
    /// order, at most [`MOST_LAYERS`]. 0 and 1 are one layer.
    pub layers: u32,
    /// Whether translucent spheres block the lights and the sky of the picture as opaque ones do.
    pub opacity_shadows: bool,
    /// Whether translucent spheres of the picture grow opaque toward their rim.
    pub ghost_rim: bool,
    /// Whether dark lines are drawn in the colour where the depth jumps by several pixels, or behind the last sphere.
    pub silhouette: bool,
    /// Width and colour of these lines.
    pub outline: Outline,
    /// Whether colours fade to the background with depth, from the nearest sphere of the scene to the farthest.
    pub depth_cue: bool,
    /// The share of the background in the colour of the farthest sphere, above 0 and at most 1; `None` is [`DEPTH_CUE`].
    pub depth_cue_strength: Option<f64>,
    /// The curve of pictures in 8 and 16 bits for light beyond 1; `None` for the soft one where lights or a sky light the
    /// picture, else the linear one.
    pub tone: Option<Tone>,
    /// The exposure of these pictures, stops: light is multiplied by 2 to this power.
    pub exposure: f64,
    /// The sky of the buffer `occlusion` where the scene has none. It does not change the colour.
    pub sky: Sky,
    /// Seed of the sample positions; they also depend on the pixel's place in the full frame.
    pub seed: u32,
    /// The part of the frame that is rendered, bit for bit as in the whole frame; `None` renders all of it.
    pub window: Option<Window>,
    /// Bytes of memory that the caller needs while it holds the frame, for example to write its files. A frame that
    /// would leave fewer free is refused.
    pub reserve: u64,
    /// The allowed relative error of t. Certified answers stay within it. Where accuracy and method are open, the plan
    /// takes the cheapest method whose predicted error stays within it. `None` promises the default and leaves the
    /// choice to the plan.
    pub tolerance: Option<Tolerance>,
}

impl Settings {
    /// The promised relative error of t where answers are certified.
    #[must_use]
    pub fn promise(&self) -> Tolerance {
        self.tolerance.unwrap_or_default()
    }

    /// The sky whose open share is computed: the sky of the buffer `occlusion` where it is requested, else the scene's for the
    /// colour.
    #[must_use]
    pub fn sky(&self, scene: &Scene) -> Option<Sky> {
        let requested = self.aovs.contains(&Aov::Occlusion).then(|| self.buffer_sky(scene));
        let sky = requested.or(scene.lighting.sky.filter(|_| self.aovs.contains(&Aov::Color)))?;
        Some(Sky { at_centers: self.sky_at_centers(sky), ..sky })
    }

    /// Whether the rays toward a sky leave from the centres of pixels. Through an open lens a sample may hit spheres that no
    /// centre shows, so there each sample has its own rays.
    pub(crate) fn sky_at_centers(&self, sky: Sky) -> bool {
        sky.at_centers && self.aperture.is_none()
    }

    /// The sky of the buffer `occlusion`: the scene's, else the settings'. A sky at the centres of pixels is of the
    /// picture alone.
    pub(crate) fn buffer_sky(&self, scene: &Scene) -> Sky {
        scene.lighting.sky.filter(|sky| !sky.at_centers).unwrap_or(self.sky)
    }

    /// Exposure and curve of the scene's pictures in 8 and 16 bits.
    #[must_use]
    pub fn toning(&self, scene: &Scene) -> Toning {
        let uses_lights = self.shade == Shade::Headlight && scene.lighting.has_light();
        let tone = self.tone.unwrap_or(if uses_lights { Tone::Soft } else { Tone::Linear });
        Toning { tone, stops: self.exposure }
    }

    /// Checks the exposure, the outline and the opacities, and that the scene has what the buffers need.
    ///
    /// # Errors
    /// [`Error::Settings`] for an exposure or an outline out of range, for the buffer `shadow` without lights, or with more than [`MOST_LIGHTS`], for
    /// coverage of translucent spheres;
    /// [`Error::Scene`] for a sky with numbers out of range.
    pub fn check_lighting(&self, scene: &Scene) -> Result<()> {
        Toning::check_stops(self.exposure)?;
        self.outline.check()?;
        if let Some(strength) = self.depth_cue_strength.filter(|strength| !(*strength > 0.0 && *strength <= 1.0)) {
            let problem = format!("{DEPTH_CUE_STRENGTH} is {strength}");
            return Err(Error::settings(problem, "give a number above 0 and at most 1"));
        }
        if self.layers > MOST_LAYERS {
            let problem = format!("{LAYERS} is {}", self.layers);
            return Err(Error::settings(problem, format!("give a whole number from 1 to {MOST_LAYERS}")));
        }
        let lights = scene.lighting.lights.len();
        if self.aovs.contains(&Aov::Shadow) && lights == 0 {
            return Err(Self::no_light());
        }
        if self.aovs.contains(&Aov::Shadow) && lights > MOST_LIGHTS {
            let problem = format!("the buffer shadow cannot hold {lights} lights");
            return Err(Error::settings(problem, format!("use at most {MOST_LIGHTS} lights")));
        }
        if self.coverage && scene.spheres.is_translucent() {
            let problem =
                format!("{CRYPTOMATTE} counts the first hits of rays, and some spheres have an {OPACITY} below 1");
            return Err(Error::settings(problem, format!("remove {OPACITY}, or {CRYPTOMATTE}")));
        }
        self.sky.check(|field| Place::field(format!("occlusion.{field}")))
    }

    /// The strength of the depth cue; `None` without one.
    pub(crate) fn cue_strength(&self) -> Option<f64> {
        self.depth_cue.then(|| self.depth_cue_strength.unwrap_or(DEPTH_CUE))
    }

    /// Warnings about settings of translucent spheres that change nothing, since a picture has none of them.
    pub(crate) fn idle_layers(&self) -> impl Iterator<Item = String> {
        let given = [(self.layers > 0, LAYERS), (self.opacity_shadows, OPACITY_SHADOWS), (self.ghost_rim, GHOST_RIM)];
        let why = format!("no sphere of the picture has an {OPACITY} below 1");
        given
            .into_iter()
            .filter(|(given, _)| *given)
            .map(move |(_, setting)| format!("{setting} changes nothing: {why}"))
    }

    /// A warning about plastic in a picture without a light, whose highlights it would have.
    pub(crate) fn idle_plastic(&self, scene: &Scene) -> Option<String> {
        let has_highlights = !scene.lighting.lights.is_empty() && self.shade == Shade::Headlight;
        let materials = scene.spheres.materials.as_ref().filter(|_| self.asks(&[Aov::Color]) && !has_highlights)?;
        let is_plastic = |material: &Material| matches!(material, Material::Plastic { .. });
        let why = match self.shade {
            Shade::Headlight => format!("the picture has no light; {SUN} and {LOOK} soft add one"),
            other => format!("the shading {} shows none", other.name()),
        };
        let idle = format!("plastic has no highlights: {why}");
        materials.kinds.iter().any(is_plastic).then_some(idle)
    }

    /// The error for the buffer `shadow` without a light.
    #[must_use]
    pub fn no_light() -> Error {
        let problem = "the buffer shadow needs a light, and the scene has none";
        Error::settings(problem, format!("add {SUN} X,Y,Z, or [[light]] tables to the scene file"))
    }

    /// The part of `scene`'s frame that is rendered.
    ///
    /// # Errors
    /// [`Error::Settings`] where the window does not lie within the frame.
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
    /// The tolerance, if f64 can hold it.
    ///
    /// # Errors
    /// [`Error::Settings`] for 0, for less than 2^-50 and for NaN.
    pub fn new(relative: f64) -> Result<Self> {
        if relative >= 2f64.powi(-50) && relative.is_finite() {
            return Ok(Self(relative));
        }
        let problem = format!("the tolerance {relative} is not a relative error that can be promised");
        Err(Error::settings(problem, "give a relative error of 2^-50 (8.9e-16) or more"))
    }

    /// The relative error.
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

/// The search of given rays for the spheres that they may hit. Viewing rays have one search for each engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Search {
    /// A tree for certified and exact answers; a method tests all spheres.
    #[default]
    Auto,
    /// Every ray tests all spheres.
    All,
    /// A tree of boxes over the spheres; the answers are the same.
    Tree,
}

named! { Search, "search", Auto "auto" All "all" Tree "tree" }
