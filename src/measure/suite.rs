//! Scenes made for measuring: where renderers break, and one wall of spheres from near to far.

pub mod extremes;
mod random;

pub use random::Random;
