//! The columns of the vertices.

use super::splat::Splat;
use crate::read::particles::frame::Particles;
use crate::read::particles::layout::Layout;
use halfline::error::Result;

/// The columns of a vertex: its properties that are not lists.
pub(super) struct VertexColumns {
    pub(super) layout: Layout,
    /// The property that is a packed colour, which has three columns.
    pub(super) packed: Option<usize>,
    /// The splats that the vertices are.
    pub(super) splat: Option<Splat>,
}

impl VertexColumns {
    /// Adds a vertex with these numbers.
    ///
    /// # Errors
    /// [`Error::Scene`] at the field, without the place in the file.
    pub(super) fn add(&self, numbers: &mut Vec<f64>, particles: &mut Particles) -> Result<()> {
        self.splat.as_ref().map_or(Ok(()), |splat| splat.complete(numbers))?;
        self.layout.numbers(numbers, particles)
    }
}
