//! halfline (skeleton)
pub mod camera;
mod dd;
pub mod error;
pub mod exact;
pub mod frame;
pub mod scene;
