#![doc = include_str!("../README.md")]

pub mod canvas;
pub mod cells;
pub mod inset;
pub mod legend;
mod raster;
