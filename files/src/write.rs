//! Files of frames: formats, encoding, atomic files; reading them back, and merging the files of tiles. Files of
//! hits and of rays.

pub(crate) mod atomic;
pub mod buffers;
#[cfg(feature = "formats")]
mod copy;
mod cryptomatte;
mod digest;
mod encode;
#[cfg(feature = "formats")]
mod exr;
pub mod figure;
pub mod file;
pub mod format;
pub mod glb;
pub mod hits;
pub mod image_file;
mod layer;
pub mod mattes;
pub mod merge;
#[cfg(not(feature = "formats"))]
mod no_copy;
#[cfg(not(feature = "formats"))]
mod no_exr;
pub mod npy;
pub(crate) mod npz;
mod pfm;
mod plain;
pub mod png;
pub mod rays;
mod rows;
pub mod vector;

#[cfg(not(feature = "formats"))]
use {no_copy as copy, no_exr as exr};
