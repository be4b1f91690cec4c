//! Copies of particles that are operators over them.

use halfline::scene::instances::Operator;

/// Particles that follow each other, and their copies.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlacedPart {
    pub(in crate::read) count: usize,
    pub(in crate::read) operators: Vec<Operator>,
    /// The number of every operator from 0, as in the column `copy`.
    pub(in crate::read) copies: Vec<f64>,
}
