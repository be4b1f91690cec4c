//! Measurements: comparing frames, and speed and error of every method.

pub mod compare;
pub mod export;
pub mod frames;
pub mod picture;
#[cfg(feature = "plots")]
pub mod plot;
pub mod record;
#[cfg(feature = "plots")]
pub mod report;
pub mod run;
pub mod score;
mod subject;
pub mod suite;
pub mod total;
pub mod variant;
pub mod verdict;

pub use crate::frame::array::{Array, ArrayValue, Values};
