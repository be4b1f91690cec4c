//! A run of consecutive pixels that are lit in vectors.

use super::lighting::LightingContext;
use crate::answers::light::Chunk;
use crate::number::vector::LANES;
use crate::view::picture_rays::{PictureRays, ShownBalls};
use glam::DVec3;

/// Some pixels of a frame, and where their light goes.
pub(super) struct Run<'a, 'b, 'c> {
    pub(super) lighting: &'a LightingContext<'a>,
    pub(super) rays: &'a PictureRays<'a>,
    pub(super) ids: &'a [u32],
    pub(super) chunk: &'b mut Chunk<'c>,
}

impl Run<'_, '_, '_> {
    /// The index, in the buffers, of the pixel with this number.
    #[inline(always)]
    pub(super) fn pixel(&self, n: usize) -> u32 {
        (self.chunk.first + n) as u32
    }

    /// The spheres that the pixels from a number on show.
    #[inline(always)]
    pub(super) fn shown(&self, first: usize) -> ShownBalls {
        let LightingContext { scene, view, .. } = self.lighting;
        ShownBalls::of_run(&view.record, self.pixel(first), &self.ids[first..], &scene.spheres)
    }
}

/// The components of a vector in one lane.
#[inline(always)]
pub(super) fn lane(components: &[[f64; LANES]; 3], l: usize) -> DVec3 {
    DVec3::new(components[0][l], components[1][l], components[2][l])
}
