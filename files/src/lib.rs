//! The files of halfline: scenes and given rays are read, frames and hits are written, read back and merged.
//!
//! - [`read`]: reads scene files, and turns particles into spheres.
//! - [`write`](mod@write): the files of frames, written, read back and merged; files of hits and rays.
//! - [`parts`]: files of what a frame needs of a part of its spheres.
//!
//! ```no_run
//! # use halfline::Aov;
//! let frame = halfline_files::read::scene("scenes/inside.toml".as_ref(), &Default::default())?;
//! let settings = halfline::Settings { aovs: vec![Aov::Color, Aov::Distance], ..Default::default() };
//! let frame = halfline::render(&frame.scene, &settings)?;
//! println!("{} of {} rays hit; the first pixel shows sphere {}", frame.report.hits, frame.report.rays, frame.ids()[0]);
//! frame.image().ok_or("no colour")?.save("inside.png")?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#[doc(hidden)]
pub mod blocks;
mod npy;
pub mod parts;
pub mod read;
pub mod write;

pub use read::ReadOptions;
