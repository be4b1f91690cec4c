//! Scenes made for measuring: where renderers break, and one wall of spheres from near to far.

pub mod extremes;
pub mod ladder;
mod random;

pub use random::Random;
