//! Inputs and answer of a pixel's certificate: the projection uniform, the quantities of a ray, the bounds of its hit.

use bytemuck::{Pod, Zeroable};

/// The kernel's second uniform buffer, declared in certify/projection.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, PartialEq)]
pub(crate) struct ProjectionRecord {
    pub(crate) slope: [f32; 2],
    pub(crate) step: [f32; 2],
    pub(crate) fixed: [f32; 2],
    pub(crate) shift: u32,
    pub(crate) unit: f32,
    pub(crate) errors: [f32; 3],
    pub(crate) edge: f32,
    pub(crate) depth: f32,
    pub(crate) tolerance: f32,
    pub(crate) generals: u32,
    pub(crate) cull_margin: f32,
    pub(crate) size: f32,
    /// WGSL rounds the size up to the alignment of errors.
    pub(crate) unused: [f32; 3],
}

/// The quantities of one ray: slopes, |d|^2 and its reciprocal, the pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slopes<R> {
    pub(crate) x: R,
    pub(crate) y: R,
    pub(crate) a: R,
    pub(crate) inverse: R,
    pub(crate) row: i32,
    pub(crate) column: i32,
}

/// The answer for a winner. The depth is the centre's depth (0 for a general sphere) plus the offset; it lies between
/// low and high.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer<R> {
    /// Hit, root, depth and normal are within the promised tolerance. Excludes the order of the hits.
    pub(crate) sure: bool,
    /// The hit is certain; nothing else need be.
    pub(crate) hits: bool,
    pub(crate) id: u32,
    pub(crate) offset: R,
    pub(crate) low: R,
    pub(crate) high: R,
    /// Bound of the error of the returned depth.
    pub(crate) depth_interval: R,
    pub(crate) normal: [R; 3],
    /// Bound of the normal's error; 0 where the eye is not outside of the sphere. Rays leave from hits only on devices.
    #[cfg(test)]
    pub(crate) turn: R,
}
