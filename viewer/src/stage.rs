//! The requests of the page, as JSON, and the trait [`Stage`], which answers them.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// Why there is no answer: the error object of the command line, as `--json` prints it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The kind: settings, scene, adapter, limits, device-lost, accuracy, io, internal.
    pub kind: &'static str,
    /// The description of the problem, for people.
    pub message: String,
    /// The exit code that the command has for this kind.
    pub exit: u8,
}

impl Refusal {
    /// A request that cannot be answered as it is.
    pub fn settings(message: impl Into<String>) -> Self {
        Self { kind: "settings", message: message.into(), exit: 2 }
    }

    /// A fault of the program.
    pub fn internal(message: impl Into<String>) -> Self {
        Self { kind: "internal", message: message.into(), exit: 101 }
    }

    /// `{"error": {kind, message, exit}}`
    pub fn json(&self) -> Value {
        serde_json::json!({ "error": { "kind": self.kind, "message": self.message, "exit": self.exit } })
    }
}

/// An answer, or why there is none.
pub type Answer<T> = Result<T, Refusal>;

/// The extent of the camera's view: an angle, a height for an orthographic camera, or a lens with a name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// The angle of the full height in degrees.
    Vfov(f64),
    /// The full height in units of the scene, for an orthographic camera.
    Height(f64),
    /// A lens that options name.
    Named(NamedLens),
}

/// A lens by the values of the command's options for it. The page keeps it as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NamedLens {
    /// The option `lens`.
    pub name: LensName,
    /// Degrees of the full height of a fisheye.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vfov: Option<f64>,
    /// Focal lengths and principal point, and the columns and rows of the image that they belong to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intrinsics: Option<([f64; 4], [u32; 2])>,
    /// Coefficients in the order of the option.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coefficients: Option<[f64; 8]>,
    /// Half of the height of what is seen at the distance 1, for moves of the camera: on a plane with the pixels of the middle.
    pub half: f64,
}

/// The name of a lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LensName {
    /// Image heights that grow with the angle.
    Fisheye,
    /// The whole sphere.
    Equirectangular,
    /// Focal lengths and distortion.
    Opencv,
}

/// A camera. In JSON it has exactly one of `vfov`, `height` and `lens`, and its numbers are finite.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Pose {
    /// The position of the eye, in units of the scene.
    pub eye: [f64; 3],
    /// The point in the middle of the picture.
    pub at: [f64; 3],
    /// The direction that is upwards in the picture.
    pub up: [f64; 3],
    /// The angle or the height of the view, or its lens.
    pub lens: Lens,
}

/// A camera as it is written.
#[derive(Serialize, Deserialize)]
#[serde(rename = "camera")]
struct Written {
    eye: [f64; 3],
    at: [f64; 3],
    up: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    vfov: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lens: Option<NamedLens>,
}

impl TryFrom<Written> for Pose {
    type Error = &'static str;

    fn try_from(Written { eye, at, up, vfov, height, lens: named }: Written) -> Result<Self, Self::Error> {
        let lens = match (vfov, height, named) {
            (Some(vfov), None, None) => Lens::Vfov(vfov),
            (None, Some(height), None) => Lens::Height(height),
            (None, None, Some(named)) => Lens::Named(named),
            _ => return Err("a camera has either vfov, height or lens"),
        };
        // The numbers of a named lens are checked with the options that it becomes.
        let numbers = [eye, at, up].into_iter().flatten().chain(vfov).chain(height);
        if !numbers.into_iter().all(f64::is_finite) {
            return Err("the numbers of a camera are finite");
        }
        Ok(Self { eye, at, up, lens })
    }
}

impl From<Pose> for Written {
    fn from(Pose { eye, at, up, lens }: Pose) -> Self {
        let (vfov, height, lens) = match lens {
            Lens::Vfov(vfov) => (Some(vfov), None, None),
            Lens::Height(height) => (None, Some(height), None),
            Lens::Named(lens) => (None, None, Some(lens)),
        };
        Self { eye, at, up, vfov, height, lens }
    }
}

/// The purpose of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The camera moves: the frame comes soon and may leave out detail.
    Move,
    /// The camera rests: the frame has its full quality.
    #[default]
    Still,
    /// The pixels of a window of a still, in full quality, for a page that composes it.
    Part,
    /// A figure without pixels, as SVG.
    Svg,
    /// The same as PDF.
    Pdf,
}

/// Options that replace options of the scene, by their identifiers: the values of each, one for every time that it is given. An option
/// without values is taken away.
pub type Options = BTreeMap<String, Vec<String>>;

/// A request for a frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameRequest {
    /// The number of the request; it cancels earlier requests with smaller numbers.
    #[serde(default)]
    pub seq: u64,
    /// The camera.
    pub camera: Pose,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The number of the file's frame; without it, the one that is shown.
    #[serde(default)]
    pub frame: Option<u64>,
    /// The spheres that are emphasised.
    #[serde(default)]
    pub select: Option<String>,
    /// Options of the picture.
    #[serde(default)]
    pub options: Options,
    /// The purpose: a camera that moves, one at rest, or a part of a still.
    #[serde(default)]
    pub mode: Mode,
    /// Of a part: the columns and rows x0, y0, x1, y1, ends excluded; without it, all of them.
    #[serde(default)]
    pub window: Option<[u32; 4]>,
}

impl FrameRequest {
    /// A request for a still picture by this camera in this size, with the defaults of all else.
    pub fn still(camera: Pose, size: [u32; 2]) -> Self {
        Self {
            seq: 0,
            camera,
            size,
            frame: None,
            select: None,
            options: Options::new(),
            mode: Mode::Still,
            window: None,
        }
    }
}

/// A request for the sphere at a pixel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PickRequest {
    /// The camera.
    pub camera: Pose,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The number of the file's frame; without it, the one that is shown.
    #[serde(default)]
    pub frame: Option<u64>,
    /// The spheres that are emphasised.
    #[serde(default)]
    pub select: Option<String>,
    /// Options of the picture.
    #[serde(default)]
    pub options: Options,
    /// The pixel's column, from the left.
    pub x: u32,
    /// The pixel's row, from the top.
    pub y: u32,
    /// The id of a sphere, to which the distance is wanted.
    #[serde(default)]
    pub from: Option<u64>,
}

/// A request for the summary of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneRequest {
    /// Width and height of the picture for which it is framed; without it, its own.
    #[serde(default)]
    pub size: Option<[u32; 2]>,
}

/// A request for the number of spheres that an expression selects, and for the legend of their colours.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SelectRequest {
    /// The expression; without it, all spheres.
    #[serde(default)]
    pub expr: Option<String>,
    /// Options of the picture.
    #[serde(default)]
    pub options: Options,
    /// The number of the file's frame; without it, the one that is shown.
    #[serde(default)]
    pub frame: Option<u64>,
}

/// The pixels of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Pixels {
    /// Red, green and blue of each pixel, row by row from the top: sent as JPEG.
    Rgb {
        /// Width and height.
        size: [u32; 2],
        /// Three bytes for each pixel.
        levels: Vec<u8>,
    },
    /// A whole PNG file, sent as it is.
    Png(Vec<u8>),
    /// A whole SVG file.
    Svg(Vec<u8>),
    /// A whole PDF file.
    Pdf(Vec<u8>),
}

/// A frame and what is said about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// The pixels.
    pub pixels: Pixels,
    /// The object of the header `X-Halfline`.
    pub info: Value,
}

/// Ways to make a frame without the page.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Commands {
    /// The command line; `None` for a scene that no command can read.
    pub shell: Option<String>,
    /// The lines of Python.
    pub python: String,
}

/// Whether a frame is still wanted.
pub type GoOn = Arc<dyn Fn() -> bool + Send + Sync>;

/// Answers the requests of the page for one scene file, with its renderer. All methods may be called from several
/// threads at once; `frame` is called by one at a time.
pub trait Stage: Send + Sync {
    /// The summary of the scene; waits until the file is read.
    fn scene(&self, request: &SceneRequest) -> Answer<Value>;

    /// A frame. `None` if `go_on` said that it is no longer wanted.
    fn frame(&self, request: &FrameRequest, go_on: &GoOn) -> Answer<Option<Picture>>;

    /// The sphere at a pixel, or null.
    fn pick(&self, request: &PickRequest) -> Answer<Value>;

    /// The number of spheres that an expression selects, and their legend.
    fn select(&self, request: &SelectRequest) -> Answer<Value>;

    /// The camera that shows all spheres, or those that are selected, in the direction of a frame.
    fn fit(&self, request: &FrameRequest) -> Answer<Value>;

    /// The command and the lines of Python that make the frame.
    fn command(&self, request: &FrameRequest) -> Answer<Commands>;

    /// The progress of reading the file; returns when reading has ended, and at the latest after `wait`.
    fn progress(&self, wait: Duration) -> Answer<Value>;
}
