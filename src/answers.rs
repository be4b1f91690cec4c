//! From the buffers that a kernel writes to the buffers of a frame: unsure pixels are settled exactly, samples are
//! averaged, and the values get their units.

pub(crate) mod assemble;
pub(crate) mod depth_cue;
pub(crate) mod finish;
pub(crate) mod hits;
pub(crate) mod layers;
pub(crate) mod light;
pub(crate) mod open_sky;
pub(crate) mod raw;
pub(crate) mod samples;
pub(crate) mod settle;
pub(crate) mod silhouette;
