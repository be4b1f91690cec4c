//! halfline (skeleton)
pub mod camera;
mod dd;
pub mod error;
pub mod frame;
pub mod measure;
pub mod scene;
