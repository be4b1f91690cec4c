//! Files of frames: formats, encoding, atomic files; reading them back, and merging the files of tiles. Files of
//! hits and of rays.

pub(crate) mod atomic;
pub mod buffers;
mod cryptomatte;
mod digest;
mod encode;
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
pub mod npy;
pub(crate) mod npz;
mod pfm;
mod plain;
pub mod png;
pub mod rays;
mod rows;
