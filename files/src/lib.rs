//! The files of halfline: scenes and given rays are read, frames and hits are written, read back and merged.
//!
//! - [`read`]: reads scene files, and turns particles into spheres.
//! - [`write`](mod@write): the files of frames, written, read back and merged; files of hits and rays.

mod npy;
pub mod read;
pub mod write;

pub use read::ReadOptions;
