//! Scenes made for measurements: hard cases for renderers, and a wall of spheres from near to far.

pub mod extremes;
pub mod ladder;
mod random;

pub use random::Random;
