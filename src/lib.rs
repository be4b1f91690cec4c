//! halfline renders spheres, from atoms to planets, headless, on any GPU, on software Vulkan or on the CPU.
//!
//! # Render a picture with the depth of every pixel
//!
//! ```
//! use halfline::{Aov, Camera, ImagePlane, Scene, Settings, Spheres};
//!
//! let mut spheres = Spheres::default();
//! spheres.push([0.0, 0.0, -3.0], 1.0, Some([0.9, 0.4, 0.2]));
//! let image = ImagePlane { width: 64, height: 64, background: [0.0; 3] };
//! let scene = Scene { camera: Camera::CANONICAL, image, spheres, lighting: Default::default() };
//! let settings = Settings { aovs: vec![Aov::Color, Aov::Depth], ..Settings::default() };
//! let frame = halfline::render(&scene, &settings)?;
//! assert_eq!(frame.ids()[32 * 64 + 32], 0, "the middle pixel shows sphere 0");
//! assert!((frame.f64(Aov::Depth).unwrap()[32 * 64 + 32] - 2.0).abs() < 1e-3, "its front is 2 away");
//! frame.image().unwrap().save(std::env::temp_dir().join("halfline.png"))?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The modules
//!
//! The data flows one way, and the modules follow it:
//!
//! ```text
//! Scene (f64, world) -> View (canonical camera) -> rays -> nearest hit -> shade -> Frame
//! ```
//!
//! - [`scene`]: spheres, colours, camera and image in f64, taken as exact.
//! - [`camera`]: the general perspective camera and the orthographic one, by the names of the lecture: eye, view, up;
//!   basis u, v, w; viewport vw x vh at distance d.
//! - [`view`]: *move the world, not the ray*. Spheres are moved into the canonical camera in f64 and rounded once.
//! - [`ray`]: one viewing ray per pixel, (u, v, -d) from the origin; only t > 0 counts.
//! - [`intersect`]: the list of forms of the ray-sphere quadratic, each a WGSL file with a CPU twin.
//! - [`shade`]: the colour of a hit.
//! - [`frame`]: colour, distance, depth, normal, position, id, mask as plain buffers, and their provenance.
//! - [`render`](mod@render): renders one frame from scene to buffers; a [`Renderer`] keeps device and kernels for many.
//! - [`trace`](mod@trace): traces given rays, such as those that [`scene::lidar`] makes.
//! - [`settings`]: the settings of a rendering.
//! - [`plan`]: decides what a scene requires: method, accuracy, search.
//! - [`quote`]: quotes text of files in messages, and names settings in them.
//! - [`progress`]: progress reporting and cancellation.
//!
//! Scenes are read from files, and frames written to files, by the crate `halfline-files`; `halfline-measure` compares frames with exact
//! arithmetic.

mod answers;
mod certify;
mod cpu;
mod double_double;
mod dyadic;
pub mod exact;
pub mod frame;
mod gpu;
pub mod intersect;
mod kernel;
pub mod number;
pub mod render;
pub mod scene;
mod search;
pub mod settings;
pub mod shade;
#[cfg(test)]
mod testing;
mod tile;
pub mod view;
pub mod window;

pub use frame::{Aov, Frame, report};
pub use gpu::device::{AdapterSummary, adapters};
pub use gpu::selftest::{Check, Rounding, Usable, Verdict as AdapterVerdict, verdicts};
pub use halfline_ground::{Cancel, Error, Progress, Result, Step, Watch, error, memory, parallel, progress, quote};
pub use intersect::{Method, predict};
pub use render::trace::{Hits, Occlusion, Rays, Tracer, trace};
pub use render::{Renderer, explain, plan, render, trace};
pub use scene::camera::{self, Camera, Lens, Look};
pub use scene::{ImagePlane, Light, LightSource, Lighting, Scene, Sky, Spheres};
pub use settings::{Accuracy, Backend, Search, Settings, Tolerance};
pub use shade::Shade;
pub use view::ray;
/// The wgpu that [`Renderer::with_device`] takes its device from.
pub use wgpu;
pub use window::Window;
