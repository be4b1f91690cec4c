//! The periodic cell of a simulation or a crystal.

/// A periodic cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// A corner.
    pub origin: [f64; 3],
    /// The three edges from that corner.
    pub edges: [[f64; 3]; 3],
}

impl Cell {
    /// The point at these fractions of the edges.
    pub fn place(&self, parts: [f64; 3]) -> [f64; 3] {
        let along = |k: usize| (0..3).map(|edge| parts[edge] * self.edges[edge][k]).sum::<f64>();
        [0, 1, 2].map(|k| self.origin[k] + along(k))
    }
}
