//! What lights and the sky give to the pixels of a frame.

/// The buffers of lights and sky in row order; those that were not requested are empty.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Lit {
    /// Linear RGB, three numbers per pixel.
    pub(crate) color: Vec<f32>,
    /// Share of each light that is hidden, one number per light and pixel.
    pub(crate) shadow: Vec<f32>,
    /// Share of the sky that is open.
    pub(crate) occlusion: Vec<f32>,
    /// Pixels of which the judge decided a secondary ray, in their order.
    pub(crate) settled: Vec<u32>,
}
