//! The columns of the vertices.

use super::splat::Splat;
use crate::particles::frame::Particles;
use crate::particles::layout::Layout;
use crate::particles::records::Record;
use halfline_ground::error::{Error, Result};

/// The columns of a vertex: its properties that are not lists.
pub(super) struct VertexColumns {
    pub(super) layout: Layout,
    /// The property that is a packed colour, which has three columns.
    pub(super) packed: Option<usize>,
    /// The properties that are not lists, in a binary file.
    pub(super) record: Record,
    /// The splats that the vertices are.
    pub(super) splat: Option<Splat>,
}

impl VertexColumns {
    /// Adds a vertex with these numbers, or counts it as left out; `placed` gives an error its place in the file.
    ///
    /// # Errors
    /// [`Error::Scene`] at the field.
    pub(super) fn add(
        &self,
        numbers: &mut Vec<f64>,
        particles: &mut Particles,
        placed: impl Fn(Error) -> Error,
    ) -> Result<()> {
        match self.splat.as_ref().map_or(Ok(()), |splat| splat.complete(numbers)) {
            Ok(()) => self.layout.checked_numbers(numbers, particles, placed),
            Err(error) => self.layout.refuse(placed(error), particles),
        }
    }
}
