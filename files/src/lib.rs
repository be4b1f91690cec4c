#![doc = include_str!("../README.md")]
//!
//! - [`read`]: reads scene files, and turns particles into spheres.
//! - [`write`](mod@write): the files of frames, written, read back and merged; files of hits and rays.
//! - [`parts`]: files of the share that some of a scene's spheres have in a frame.

#![cfg_attr(
    not(feature = "formats"),
    expect(dead_code, reason = "the readers that are left out use some of what all share")
)]

pub mod parts;
pub mod read;
pub mod write;

#[doc(hidden)]
pub use halfline_particles::blocks;
pub use read::ReadOptions;

/// The line that brings the formats that a build lacks.
#[cfg(not(feature = "formats"))]
const WHOLE: &str = "cargo install --path command brings all formats";
