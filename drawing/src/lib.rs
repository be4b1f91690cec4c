#![doc = include_str!("../README.md")]

pub mod canvas;
pub mod cells;
pub mod figure;
pub mod inset;
pub mod legend;
mod raster;
