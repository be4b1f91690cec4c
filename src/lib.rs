//! halfline (skeleton)
pub mod camera;
mod cpu;
mod dd;
pub mod error;
pub mod frame;
mod gpu;
pub mod intersect;
pub mod measure;
mod nearest;
pub mod plan;
pub mod ray;
pub mod real;
pub mod render;
pub mod report;
pub mod scene;
pub mod shade;
pub mod trace;
pub mod view;

pub use gpu::device::{AdapterSummary, adapters};
