#![doc = include_str!("../README.md")]

pub mod compare;
pub mod export;
pub mod frames;
pub mod picture;
pub mod plot;
pub mod record;
pub mod report;
pub mod run;
pub mod score;
mod subject;
pub mod suite;
pub mod total;
pub mod variant;
pub mod verdict;

pub use halfline::frame::array::{Array, ArrayValue, Values};
