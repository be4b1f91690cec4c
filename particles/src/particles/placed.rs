//! Copies of particles that are operators over them.

use halfline_ground::Operator;

/// Particles that follow each other, and their copies.
#[derive(Debug, Clone, Default)]
pub struct PlacedPart {
    pub count: usize,
    pub operators: Vec<Operator>,
    /// The number of every operator from 0, as in the column `copy`.
    pub copies: Vec<f64>,
}
