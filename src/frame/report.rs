//! The report of a rendering: adapter, method, times, counts, warnings.

use super::outline::Outline;
use super::tone::{Tone, Toning};
use crate::intersect::predict::Prediction;
use crate::scene::camera::CameraRecord;
use crate::scene::{CUT, CutPlane, REMOVED, Sky, Spheres};
use serde::Serialize;
use std::collections::BTreeMap;
use web_time::Instant;

/// The driver of the CPU reference path, as far as answers depend on it.
pub(crate) const CPU_DRIVER: &str = "halfline reference path, f32";

/// The report of a frame; the command line prints it as one JSON object.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// `halfline-render`.
    pub schema: &'static str,
    /// Version of this object's shape.
    pub version: u32,
    /// The program that wrote it.
    pub halfline: &'static str,
    /// Number of the picture in a sequence, from 1.
    pub number: u64,
    /// Spheres in the scene.
    pub spheres: u64,
    /// Objects of the scene file that are not spheres and were left out; 0 from a renderer, which knows no file.
    pub skipped: u64,
    /// The planes that cut spheres.
    pub cuts: Vec<CutPlane>,
    /// Spheres that a plane cuts; `None` where parts that overlap do not tell.
    pub spheres_cut: Option<u64>,
    /// Spheres that lie wholly beyond a plane, likewise.
    pub spheres_removed: Option<u64>,
    /// Viewing rays: pixels of the window.
    pub rays: u64,
    /// Rays that hit something.
    pub hits: u64,
    /// Samples per pixel whose mean is the colour and the alpha; 1 for pixel centres.
    pub samples: u32,
    /// The camera; `null` in JSON only where there is none.
    pub camera: Option<CameraRecord>,
    /// The look of the picture: `plain`, `soft` or `figure`, given or by the file; `None` without a picture, or where the
    /// caller chose settings without a look.
    pub look: Option<&'static str>,
    /// The frames of a sequence that set the camera, default radii and the range of colours: `first` or `all`, and
    /// `none` where each frame sets its own; `None` for a single picture.
    pub hold: Option<&'static str>,
    /// Lights of the scene; without any, and without a sky, the light is at the eye.
    pub lights: u64,
    /// The sky whose open share is computed, for the buffer `occlusion` where it is requested, else for the colour; a reach of
    /// any distance is `null` in JSON.
    pub occlusion: Option<Sky>,
    /// Whether outlines are drawn in the colour.
    pub silhouette: bool,
    /// Width and colour of these outlines; `None` where none are drawn.
    pub outline: Option<Outline>,
    /// Whether colours fade with depth.
    pub depth_cue: bool,
    /// The share of the background in the colour of the farthest sphere; `None` for the usual one, and where they do not.
    pub depth_cue_strength: Option<f64>,
    /// The layers of translucent spheres in the picture; `None` where it shows none.
    pub layers: Option<u32>,
    /// Whether translucent spheres block its lights and its sky.
    pub opacity_shadows: bool,
    /// Whether they grow opaque toward their rim.
    pub ghost_rim: bool,
    /// The curve of pictures in 8 and 16 bits for light beyond 1; `None` if colour is not requested.
    pub tone: Option<Tone>,
    /// The exposure of these pictures, stops.
    pub exposure: f64,
    /// The adapter's name; `cpu` for the reference path.
    pub adapter: String,
    /// Driver and its version; threads for the reference path.
    pub driver: String,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// The reason for the backend: requested, found or measured.
    pub backend_reason: String,
    /// The intersection method: the form of the quadratic.
    pub method: &'static str,
    /// `fast`, `certified` or `exact`.
    pub accuracy: &'static str,
    /// The reason for this method and this accuracy.
    pub reason: String,
    /// The shading; `None` if colour is not requested.
    pub shade: Option<&'static str>,
    /// The search for candidates, as the engine's name: `all`, `tiles`, `splat` or `exact`.
    pub search: &'static str,
    /// Share of the pixels whose answer is certified in f32.
    pub certified: f64,
    /// Pixels that were settled in exact arithmetic.
    pub settled: u64,
    /// Share of the hits for which the device decided in f32 all rays toward the sky and lights without a size; `None` where the host
    /// traced these rays, or there are none.
    pub light_on_device: Option<f64>,
    /// Proven bound of t's relative error, at most the tolerance; `None` when nothing is proven.
    pub bound: Option<f64>,
    /// Predicted worst-case rounding error; `None` where answers are certified.
    pub predicted: Option<Prediction>,
    /// Time to open the device, milliseconds.
    pub setup_ms: f64,
    /// Whole-frame wall times: view, upload, search, trace, settle, shade and readback; files excluded. The first
    /// includes compiling the kernel.
    pub frame_ms: Vec<f64>,
    /// The part of each of these times in which the device had no work and waited for the host, or the host worked for itself;
    /// all of it on the reference path.
    pub host_ms: Vec<f64>,
    /// Bytes that went to the device for the last frame; 0 on the reference path.
    pub bytes_up: u64,
    /// Bytes that came back from it.
    pub bytes_down: u64,
    /// Kernel time within each of these frames by the adapter's clock; empty where it has none.
    pub kernel_ms: Vec<f64>,
    /// Wall times of the last frame's stages, milliseconds.
    pub stages_ms: BTreeMap<&'static str, f64>,
    /// The counts of a figure without pixels; `None` where none was made.
    pub figure: Option<FigureCounts>,
    /// Whether nothing was rendered because every file existed already; fields that only rendering fills are then zero.
    pub resumed: bool,
    /// Warnings, in whole sentences.
    pub warnings: Vec<String>,
}

/// Counts of a figure without pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct FigureCounts {
    /// Paths.
    pub paths: u64,
    /// Spheres, and visible parts of spheres, that are left out because they are small.
    pub small: u64,
    /// Lines that were closed by a straight one, because arithmetic in f64 did not tell where they go on.
    pub joined: u64,
    /// Bytes of its file; 0 where none was written.
    pub bytes: u64,
}

impl Report {
    /// Share of the pixels whose answer is proved: in f32, or settled in exact arithmetic.
    #[must_use]
    pub fn proved(&self) -> f64 {
        let rays = self.rays as f64;
        // Whole numbers of pixels: the share is rounded.
        let proved = (self.certified * rays).round() + self.settled as f64;
        if self.accuracy == "exact" || proved >= rays { 1.0 } else { proved / rays }
    }

    /// Adds what planes do to the spheres of a scene.
    pub(crate) fn add_cuts(&mut self, spheres: &Spheres) {
        let Some(cuts) = &spheres.cuts else { return };
        self.spheres = spheres.len() as u64;
        self.cuts.clone_from(&cuts.planes);
        (self.spheres_cut, self.spheres_removed) = (Some(cuts.count(CUT)), Some(cuts.count(REMOVED)));
        self.warnings.extend(cuts.warning());
    }

    /// Exposure and curve of pictures in 8 and 16 bits.
    #[must_use]
    pub fn toning(&self) -> Toning {
        Toning { tone: self.tone.unwrap_or_default(), stops: self.exposure }
    }
}

/// Wall times by name.
#[derive(Debug, Default)]
pub(crate) struct Timings(BTreeMap<&'static str, f64>);

impl Timings {
    /// Runs `work` and adds its wall time to `stage`.
    pub(crate) fn time<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.add(stage, start);
        result
    }

    /// Adds the time since `start` to `stage`.
    pub(crate) fn add(&mut self, stage: &'static str, start: Instant) {
        *self.0.entry(stage).or_default() += milliseconds(start);
    }

    pub(crate) fn into_map(self) -> BTreeMap<&'static str, f64> {
        self.0
    }
}

/// Milliseconds since `start`.
pub(crate) fn milliseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
