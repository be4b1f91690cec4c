//! The report of `halfline plan`, as it is printed.

use crate::certify::binned::BinnedScene;
use crate::frame::tone::Tone;
use crate::intersect::predict::Prediction;
use crate::render::rendering::Pass;
use crate::scene::camera::CameraRecord;
use crate::scene::{Material, Scene, Sky};
use serde::Serialize;

/// The decisions for a scene, its work and its memory; the command line prints it.
#[derive(Debug, Clone, Serialize)]
pub struct Explanation {
    /// `halfline-plan`.
    pub schema: &'static str,
    /// Version of this object's shape.
    pub version: u32,
    /// The program that planned.
    pub halfline: &'static str,
    /// Spheres in the scene.
    pub spheres: u64,
    /// Objects of the scene file that are not spheres and are left out.
    pub skipped: u64,
    /// Columns and rows of the full frame.
    pub size: [u32; 2],
    /// The camera.
    pub camera: CameraRecord,
    /// The window that would be rendered: x0, y0, x1, y1, ends excluded.
    pub window: [u32; 4],
    /// Viewing rays: the pixels of the window.
    pub rays: u64,
    /// Samples per pixel whose mean is the colour and the alpha: one more pass per sample, by a kernel that writes only
    /// ids and colour. 1 for pixel centres.
    pub samples: u32,
    /// The number of lights; without any, and without a sky, the light is at the eye.
    pub lights: u64,
    /// The position or direction of each light in words, its colour unless white, and its intensity unless 1.
    pub lit_by: Vec<String>,
    /// Whether shadows of the lights are computed, for the picture or for the buffer `shadow`.
    pub shadows: bool,
    /// The sky whose open share is computed, for the picture or for the buffer `occlusion`; a reach of any distance is
    /// `null` in JSON.
    pub occlusion: Option<Sky>,
    /// The spheres from which rays go on, by what they are made of.
    pub materials: MaterialCounts,
    /// The most times that a ray of the picture goes on from mirrors and through glass; 0 where no material asks for
    /// it.
    pub bounces: u32,
    /// The rays of a pixel whose viewing rays all hit.
    pub rays_per_pixel: PixelRays,
    /// Whether outlines are drawn in the picture.
    pub silhouette: bool,
    /// Whether colours fade with depth.
    pub depth_cue: bool,
    /// The layers of translucent spheres in the picture; `None` where it shows none.
    pub layers: Option<u32>,
    /// The curve of pictures in 8 and 16 bits for light beyond 1; `None` where no picture is requested.
    pub tone: Option<Tone>,
    /// The exposure of these pictures, stops.
    pub exposure: f64,
    /// `gpu` or `cpu`.
    pub backend: &'static str,
    /// The reason for the backend: requested, found or measured.
    pub backend_reason: String,
    /// The adapter's name; `cpu` for the reference path.
    pub adapter: String,
    /// `fast`, `certified` or `exact`.
    pub accuracy: &'static str,
    /// The intersection method, `certified` or `exact`.
    pub method: &'static str,
    /// The reason for this accuracy and this method.
    pub reason: String,
    /// The allowed relative error; promised where answers are certified.
    pub tolerance: f64,
    /// The predicted worst-case rounding error; `None` where answers are certified.
    pub predicted: Option<Prediction>,
    /// The arithmetic of the kernel and the source of its input.
    pub precision: String,
    /// The search for candidates, as the engine's name: `all`, `tiles`, `splat` or `exact`.
    pub search: &'static str,
    /// The reason for this search.
    pub search_reason: String,
    /// The numbers of spheres by their place in the candidate lists; `None` where spheres are not binned.
    pub staged: Option<BinnedCounts>,
    /// The shader files of the kernel, in order; empty where no kernel runs.
    pub kernel: Vec<ShaderFile>,
    /// The buffers that the host uploads for the first frame, over all passes; empty without a device.
    pub uploaded: Vec<DeviceBuffer>,
    /// The buffers that the kernel writes and the host reads back, for all pixels together.
    pub written: Vec<DeviceBuffer>,
    /// The number of dispatches: bands of rows that fit the adapter's bindings and half a second of a software adapter;
    /// a faster adapter takes fewer. 0 where no kernel runs.
    pub dispatches: u64,
    /// The number of spheres that fit, and the memory.
    pub room: Room,
    /// The buffers of the finished frame.
    pub frame: Vec<Shown>,
    /// The passes of the frame, in their order.
    pub passes: Vec<PassOfFrame>,
    /// The parts of the renderer that this scene does not need, with the reasons.
    pub left_out: Vec<LeftOut>,
    /// The warnings of the frame's report, as far as they are known before a ray is traced.
    pub warnings: Vec<String>,
}

/// Spheres from which rays go on. One that reflects and lets light through counts as a mirror and as clear.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct MaterialCounts {
    /// Plastic with a mirror image: NFF's Ks is not 0.
    pub mirrors: u64,
    /// Metal.
    pub metals: u64,
    /// Glass, and what light passes through: NFF's T is not 0.
    pub clear: u64,
}

/// Rays by kind. The centre of a pixel is one more point where buffers are requested of it beside several samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct PixelRays {
    /// Viewing rays: the samples.
    pub viewing: u64,
    /// Rays from the hits of viewing rays to lights: one to a light, several to one with a size. 0 without shadows.
    pub lights: u64,
    /// Rays from the hits of viewing rays to the sky.
    pub sky: u64,
    /// Rays that go on from mirrors and through glass, at most: rays of little weight are not followed. Lights and sky are
    /// asked at each of their hits too.
    pub onward: u64,
}

/// Spheres by their place in the candidate lists.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BinnedCounts {
    /// Projected spheres, in the tiles' lists: wholly in front of the eye.
    pub front: u64,
    /// General spheres: around the eye, across its plane, or large and close.
    pub near: u64,
    /// Not uploaded, because no ray can hit them: behind the eye or outside the image.
    pub unseen: u64,
}

/// The number of spheres that fit for this image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Room {
    /// The number that the adapter's bindings hold of spheres distributed like these; `None` where no kernel runs.
    pub adapter: Option<u64>,
    /// The number that this machine's free memory holds, including the scene's own; `None` where the system does not
    /// report it.
    pub host: Option<u64>,
    /// Estimate of the memory that the frame needs besides the scene, bytes.
    pub needed: u64,
    /// Free memory, bytes.
    pub free: Option<u64>,
}

/// A WGSL file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ShaderFile {
    /// Its name under shaders/.
    pub file: &'static str,
    /// Its number of lines.
    pub lines: usize,
}

/// A buffer on the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct DeviceBuffer {
    /// Its name in WGSL.
    pub name: &'static str,
    /// Its size in bytes.
    pub bytes: u64,
}

/// A buffer of the frame.
#[derive(Debug, Clone, Serialize)]
pub struct Shown {
    /// Its name.
    pub name: &'static str,
    /// Rows, columns, and components if more than one.
    pub shape: Vec<u64>,
    /// The type of its values, as NumPy names it.
    pub dtype: &'static str,
    /// Its size in bytes.
    pub bytes: u64,
    /// Whether it is requested; ids are always present.
    pub asked: bool,
}

/// A pass of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct PassOfFrame {
    /// Its name.
    pub name: &'static str,
    /// Its output, in words.
    pub output: &'static str,
}

impl From<&'static Pass> for PassOfFrame {
    fn from(Pass { name, output, .. }: &'static Pass) -> Self {
        Self { name, output }
    }
}

/// A part of the renderer that this scene does not need.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The part.
    pub what: &'static str,
    /// The reason.
    pub why: String,
}

impl MaterialCounts {
    pub(super) fn of(scene: &Scene) -> Self {
        let mut counts = Self::default();
        let Some(materials) = &scene.spheres.materials else { return counts };
        for kind in &materials.of {
            match materials.kinds.get(*kind as usize) {
                Some(Material::Phong { specular, transmission, .. }) => {
                    counts.mirrors += u64::from(*specular > 0.0);
                    counts.clear += u64::from(*transmission > 0.0);
                }
                Some(Material::Metal { .. }) => counts.metals += 1,
                Some(Material::Glass { .. }) => counts.clear += 1,
                Some(Material::Plastic { .. } | Material::Ink) | None => {}
            }
        }
        counts
    }

    /// Whether rays go on from no sphere.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl BinnedCounts {
    pub(super) fn of(binned: &BinnedScene, scene: &Scene) -> Self {
        let (front, near) = (binned.projected_count, binned.generals.len() as u64);
        Self { front, near, unseen: scene.spheres.len() as u64 - front - near }
    }
}
